#include "vision_node/knob_box.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "runtime/log.h"

namespace hapton {
namespace {

// After this time a datagram counts as lost: some round trips of the slowest usual link, but too short for a hand to notice.
constexpr std::int64_t kResendNs = 50'000'000;

double radians(double degrees) { return degrees * std::numbers::pi / 180.0; }

}  // namespace

void Dials::turn(int axis, double by_degrees) {
  if (axis < 0 || axis > 2 || !std::isfinite(by_degrees)) return;
  const double turned = std::remainder(degrees[axis] + by_degrees, 360.0);
  degrees[axis] = turned == -180.0 ? 180.0 : turned;
}

Pose Dials::compute_pose(const Vec3& p_WC, const Pose& home_WS) const {
  const Quat turn = Eigen::AngleAxisd(radians(degrees.z()), Vec3::UnitZ()) * Eigen::AngleAxisd(radians(degrees.y()), Vec3::UnitY()) *
                    Eigen::AngleAxisd(radians(degrees.x()), Vec3::UnitX());
  return Eigen::Translation3d(p_WC) * turn * Eigen::Translation3d(-p_WC) * home_WS;
}

std::optional<Dials> find_dials(const Pose& X_WS, const Vec3& p_WC) {
  constexpr double kPrecision = 8.0 * std::numeric_limits<float>::epsilon();
  const Mat3 R = X_WS.linear();
  const double sin_y = -R(2, 0);
  const double cos_y = std::hypot(R(0, 0), R(1, 0));
  // At a quarter turn about y, the dials x and z turn about the same axis.
  const bool is_quarter = cos_y < kPrecision;
  const double x = is_quarter ? std::atan2(sin_y * R(0, 1), R(1, 1)) : std::atan2(R(2, 1), R(2, 2));
  const double z = is_quarter ? 0.0 : std::atan2(R(1, 0), R(0, 0));
  const Vec3 degrees = Vec3(x, std::atan2(sin_y, cos_y), z) * (180.0 / std::numbers::pi);
  // Dials that were turned by keys are at round numbers.
  const Vec3 round = (degrees * 1e3).array().round() / 1e3;
  for (const Vec3& tried : {round, degrees}) {
    const Dials dials{tried};
    const double off = (dials.compute_pose(p_WC).matrix() - X_WS.matrix()).cwiseAbs().maxCoeff();
    if (off <= kPrecision * (1.0 + p_WC.norm())) return dials;
  }
  return std::nullopt;
}

std::array<float, 12> to_twelve_floats(const Pose& X_WS) {
  std::array<float, 12> m;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) m[4 * row + column] = static_cast<float>(X_WS.matrix()(row, column));
  }
  return m;
}

Pose from_twelve_floats(const std::array<float, 12>& m) {
  Pose X_WS = Pose::Identity();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) X_WS.matrix()(row, column) = m[4 * row + column];
  }
  return X_WS;
}

void ViewTransformSender::set(const Pose& X_WS) {
  const auto floats = to_twelve_floats(X_WS);
  if (newest_.revision != 0 && floats == newest_.X_WS) return;
  newest_.X_WS = floats;
  is_adopted_ = false;
  ++newest_.revision;
  note_newest();
  is_due_ = true;
}

std::optional<Pose> ViewTransformSender::find_pose(std::uint32_t revision) const {
  const ViewTransform& known = history_[revision % kHistory];
  return revision != 0 && known.revision == revision ? std::optional(from_twelve_floats(known.X_WS)) : std::nullopt;
}

void ViewTransformSender::confirm(std::uint32_t hub_revision) {
  const bool first = !has_hub_reported_;
  has_hub_reported_ = true;
  confirmed_revision_ = hub_revision;
  if (first && newest_.revision != 0 && hub_revision >= newest_.revision) {
    newest_.revision = hub_revision + 1;
    note_newest();
    is_due_ = true;
  }
}

void ViewTransformSender::count_from(std::uint32_t revision) {
  if (revision <= newest_.revision) return;
  newest_.revision = confirmed_revision_ = revision;
  is_due_ = false;
}

bool ViewTransformSender::adopt(const ViewTransform& view, bool any_revision) {
  if (view.revision < newest_.revision && !any_revision) return false;
  const bool is_other = view.revision != newest_.revision || view.X_WS != newest_.X_WS;
  newest_ = view;
  is_adopted_ = true;
  note_newest();
  is_due_ = false;
  confirmed_revision_ = view.revision;
  has_hub_reported_ = true;  // so that this revision is not taken for one of an earlier vision node
  return is_other;
}

void ViewTransformSender::reject(std::uint32_t revision) {
  if (revision == 0 || revision != newest_.revision || revision == rejected_revision_) return;
  rejected_revision_ = revision;
  log_warning("the hub rejected view transform {}: not a rigid pose; the scene keeps its pose there until a dial turns", revision);
}

void ViewTransformSender::rejoin() {
  has_hub_reported_ = false;
  confirmed_revision_ = 0;
  is_due_ = newest_.revision != 0;
}

std::optional<ViewTransform> ViewTransformSender::take_due(std::int64_t now_ns) {
  const bool lost = !is_adopted_ && has_hub_reported_ && confirmed_revision_ < newest_.revision && rejected_revision_ != newest_.revision &&
                    now_ns - sent_ns_ >= kResendNs;
  if (!is_due_ && !lost) return std::nullopt;
  is_due_ = false;
  sent_ns_ = now_ns;
  ++sent_count_;
  return newest_;
}

}  // namespace hapton
