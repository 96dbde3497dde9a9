#include "vision_node/touch_menu.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "vision_node/depth_cues.h"

namespace hapton {
namespace {

// Largest distance of the panel's corners from the middle of the workspace, as a share of the distance to the workspace's edge.
constexpr double kMaxCornerShare = 0.92;

// The largest factor for which `from + factor * along` is inside the box from -half to half; at least 0.
double find_step_limit(const Vec3& from, const Vec3& along, const Vec3& half) {
  double step_limit = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    if (along[k] == 0.0) continue;
    step_limit = std::min(step_limit, (along[k] > 0.0 ? half[k] - from[k] : -half[k] - from[k]) / along[k]);
  }
  return std::max(0.0, step_limit);
}

}  // namespace

std::string_view TouchMenu::label(Entry entry) {
  switch (entry) {
    case Entry::off:
      return "Pen off";
    case Entry::draw:
      return "Draw";
    case Entry::measure:
      return "Measure";
    case Entry::undo:
      return "Undo";
    case Entry::redo:
      return "Redo";
    case Entry::save:
      return "Save";
    case Entry::export_work:
      return "Export";
    case Entry::close:
      return "Close";
  }
  return {};
}

Vec3 place_entry(TouchMenu::Entry entry) {
  return {0.0, 0.5 * TouchMenu::kHeightM - (static_cast<double>(entry) + 0.5) * TouchMenu::kEntryHeightM, 0.0};
}

void TouchMenu::open(const StereoScreen& screen, const Vec3& p_WC) {
  const Vec3 right = screen.X_WV.linear().col(0);
  const Vec3 up = screen.X_WV.linear().col(1);
  const Vec3 half = kMaxCornerShare * 0.5 * workspace_size_m();
  // Moves the panel as far as all its corners stay in the workspace: to the right first, then up.
  Vec3 middle = Vec3::Zero();
  for (const Vec3& along : {right, up}) {
    double step_limit = std::numeric_limits<double>::infinity();
    for (const double x : {-0.5, 0.5}) {
      for (const double y : {-0.5, 0.5})
        step_limit = std::min(step_limit, find_step_limit(middle + x * kWidthM * right + y * kHeightM * up, along, half));
    }
    middle += step_limit * along;
  }
  Pose X_WM = screen.X_WV;
  X_WM.translation() = p_WC + middle;
  X_WM_ = X_WM;
  lit_.reset();
  last_buttons_ = ~0U;
}

std::optional<TouchMenu::Entry> TouchMenu::find_entry(const Vec3& p_M) const {
  if (!(std::abs(p_M.x()) <= 0.5 * kWidthM && std::abs(p_M.y()) < 0.5 * kHeightM && std::abs(p_M.z()) <= kReachM)) return std::nullopt;
  const auto row = static_cast<std::size_t>((0.5 * kHeightM - p_M.y()) / kEntryHeightM);
  return kEntries[std::min(row, kEntries.size() - 1)];
}

std::optional<TouchMenu::Entry> TouchMenu::receive(const Vec3& p_WP, std::uint32_t buttons) {
  const std::uint32_t pressed = buttons & ~std::exchange(last_buttons_, buttons);
  lit_ = is_open() ? find_entry(X_WM_->inverse(Eigen::Isometry) * p_WP) : std::nullopt;
  return pressed != 0 ? lit_ : std::nullopt;
}

std::optional<Vec3> TouchMenu::find_ray_point(const Vec3& p_WE, const Vec3& p_W) const {
  if (!is_open()) return std::nullopt;
  const Pose X_MW = X_WM_->inverse(Eigen::Isometry);
  const Vec3 from = X_MW * p_WE;
  const Vec3 along = X_MW.linear() * (p_W - p_WE);
  if (!(from.z() * along.z() < 0.0)) return std::nullopt;
  const Vec3 p_M = from - from.z() / along.z() * along;
  return find_entry(p_M) ? std::optional(Vec3(*X_WM_ * p_M)) : std::nullopt;
}

}  // namespace hapton
