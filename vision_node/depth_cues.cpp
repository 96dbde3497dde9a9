#include "vision_node/depth_cues.h"

#include <cmath>

#include <fmt/format.h>

namespace hapton {
namespace {

constexpr double kCellM = 0.02;       // m: side of a square of the grid; a free choice
constexpr double kMaxBarShare = 0.2;  // longest scale bar, as a share of the picture's width; a free choice

}  // namespace

double ground_height_m() { return -0.5 * workspace_size_m().y(); }

std::vector<LineSegment> make_workspace_box() {
  const Vec3 half = 0.5 * workspace_size_m();
  std::vector<LineSegment> lines;
  for (int axis = 0; axis < 3; ++axis) {
    for (int corner = 0; corner < 4; ++corner) {
      Vec3 from = half;
      from[(axis + 1) % 3] *= (corner & 1) != 0 ? 1.0 : -1.0;
      from[(axis + 2) % 3] *= (corner & 2) != 0 ? 1.0 : -1.0;
      Vec3 to = from;
      to[axis] = -to[axis];
      lines.push_back({from, to});
    }
  }
  return lines;
}

Vec3 find_nearest_corner(const Vec3& p_W) {
  const Vec3 half = 0.5 * workspace_size_m();
  return p_W.cwiseSign().unaryExpr([](double sign) { return sign < 0.0 ? -1.0 : 1.0; }).cwiseProduct(half);
}

std::vector<LineSegment> make_ground_grid() {
  const Vec3 half = 0.5 * workspace_size_m();
  const double y = ground_height_m();
  std::vector<LineSegment> lines;
  for (const auto& [across, along] : {std::pair(0, 2), std::pair(2, 0)}) {
    const int most = static_cast<int>(std::floor(half[across] / kCellM));
    for (int i = -most; i <= most; ++i) {
      Vec3 from(0.0, y, 0.0);
      from[across] = i * kCellM;
      from[along] = -half[along];
      Vec3 to = from;
      to[along] = half[along];
      lines.push_back({from, to});
    }
  }
  return lines;
}

Vec3 direction_to_shadow_light() { return Vec3(-0.25, 1.0, 0.35).normalized(); }

// p' = p - (p_y - h) / l_y l, with the ground's height h and the direction l towards the light.
Mat4 compute_shadow_matrix(const Vec3& towards_light) {
  const Vec3 slope = towards_light / towards_light.y();
  Mat4 m = Mat4::Identity();
  m.block<3, 1>(0, 1) -= slope;
  m.block<3, 1>(0, 3) = ground_height_m() * slope;
  return m;
}

std::optional<Vec3> find_shadow(const Vec3& p_W) {
  if (!p_W.allFinite() || p_W.y() < ground_height_m()) return std::nullopt;
  return Vec3((compute_shadow_matrix(direction_to_shadow_light()) * p_W.homogeneous()).head<3>());
}

ScaleBar choose_scale_bar(const StereoScreen& screen, PictureSize size) {
  ScaleBar bar;
  const double max_m = kMaxBarShare * screen.width_m;
  if (!(max_m > 0.0) || !std::isfinite(max_m) || size.width_px <= 0) return bar;
  const double power_of_ten = std::pow(10.0, std::floor(std::log10(max_m)));
  bar.length_m = power_of_ten;
  for (const double step : {2.0, 5.0}) {
    if (step * power_of_ten <= max_m) bar.length_m = step * power_of_ten;
  }
  bar.pixels = bar.length_m / screen.width_m * size.width_px;
  bar.label = bar.length_m >= 1.0    ? fmt::format("{:g} m", bar.length_m)
              : bar.length_m >= 1e-3 ? fmt::format("{:g} mm", 1e3 * bar.length_m)
                                     : fmt::format("{:g} um", 1e6 * bar.length_m);
  return bar;
}

}  // namespace hapton
