#include "vision_node/edge_pointer.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace hapton {
namespace {

// Distance from the edge, as a share of the picture's smaller side: room for the pointer, and for the lines of text above and below.
constexpr double kInset = 0.05;
constexpr double kInsetAbove = 0.12;

std::string describe_distance(double length_m) {
  if (length_m >= 1.0) return fmt::format("{:.1f} m", length_m);
  return length_m >= 1e-3 ? fmt::format("{:.0f} mm", 1e3 * length_m) : fmt::format("{:.0f} um", 1e6 * length_m);
}

}  // namespace

std::optional<EdgePointer> find_edge_pointer(const StereoScreen& screen, Eye eye, PictureSize size, const Vec3& p_W) {
  if (!p_W.allFinite() || size.width_px <= 0 || size.height_px <= 0) return std::nullopt;
  const Vec3 p_V = screen.X_WV.inverse(Eigen::Isometry) * p_W;
  const EyeDepths depths = compute_eye_depths(screen, eye);
  const bool is_behind = p_V.z() >= depths.eye_m - depths.near_m;
  const Vec2 middle(0.5 * size.width_px, 0.5 * size.height_px);
  // A point beside the eye or behind it has no pixel: the pointer then shows to which side of the eye the point is.
  const Vec2 away = is_behind ? Vec2(p_V.head<2>()) : Vec2(project_to_pixel(screen, eye, size, p_W) - middle);
  if (!is_behind && (away.cwiseAbs().array() <= middle.array()).all()) return std::nullopt;
  if (!(away.norm() > 0.0) || !std::isfinite(away.norm())) return std::nullopt;
  EdgePointer pointer;
  pointer.towards = away.normalized();
  const Vec2 inset = std::min(size.width_px, size.height_px) * Vec2(kInset, kInsetAbove);
  const Vec2 half_inner = (middle - inset).cwiseMax(1.0);
  pointer.at_px = middle + away / away.cwiseAbs().cwiseQuotient(half_inner).maxCoeff();
  pointer.label = "probe " + describe_distance(p_V.norm());
  return pointer;
}

}  // namespace hapton
