#include "vision_node/hand_route.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

namespace hapton {
namespace {

// Share of the picture's smaller side: the tip slides over obstacles that are lower than this, and keeps this distance from others.
constexpr double kClearance = 0.02;
// Shares of the picture's smaller side: between two samples on the path, and between two circles of the search for a way out.
constexpr double kStep = 0.01;
constexpr double kCircleStep = 0.0025;
constexpr int kDirections = 24;   // of the search, on each circle
constexpr int kCirclePoints = 8;  // points on a circle around a pixel, all of which must be open; a free choice
// Share of the clearance: distance from the visible surface at which a path through the air begins; it may end on the surface.
constexpr double kAirClearance = 0.5;
// Share of the clearance: a tip in the air that is up to this far behind the depth picture of a surface counts as in front of the surface,
// because that picture is coarse.
constexpr double kDepthTolerance = 0.1;
// The hand comes no nearer to the viewer than this share of the distance to the visible surface.
constexpr double kMinDepthShare = 0.25;

struct Sight {
  bool is_clear = true;
  double nearest_m = std::numeric_limits<double>::infinity();  // of the visible surface along the line
};

// Looks along the straight line from a pixel at one depth to another pixel at another depth; on it the inverse of the depth is linear in
// the picture. slack: how far behind the visible surface the line may be at its beginning and at its end.
Sight look_along(const VisibleDepth& visible, const Vec2& from, double from_m, const Vec2& to, double to_m, double slack_from_m,
                 double slack_to_m) {
  const double side_px = std::min(visible.size().width_px, visible.size().height_px);
  const int steps = std::clamp(static_cast<int>((to - from).norm() / (kStep * side_px)), 1, 1000);
  Sight sight;
  for (int i = 0; i <= steps; ++i) {
    const double t = static_cast<double>(i) / steps;
    const double surface_m = visible.depth_m(from + t * (to - from));
    const double line_m = 1.0 / ((1.0 - t) / from_m + t / to_m);
    sight.is_clear = sight.is_clear && line_m <= surface_m + (1.0 - t) * slack_from_m + t * slack_to_m;
    sight.nearest_m = std::min(sight.nearest_m, surface_m);
  }
  return sight;
}

// Whether nothing is nearer than that depth, at the pixel and on a circle around it.
bool is_open(const VisibleDepth& visible, const Vec2& pixel, double depth_m, double radius_px) {
  if (visible.depth_m(pixel) < depth_m) return false;
  for (int i = 0; i < kCirclePoints; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kCirclePoints;
    if (visible.depth_m(pixel + radius_px * Vec2(std::cos(angle), std::sin(angle))) < depth_m) return false;
  }
  return true;
}

// The nearest pixel that is open at that depth.
std::optional<Vec2> find_way_out(const VisibleDepth& visible, const Vec2& from, double depth_m, double radius_px) {
  const double side_px = std::min(visible.size().width_px, visible.size().height_px);
  const double most_px = std::hypot(visible.size().width_px, visible.size().height_px);
  for (double radius = kCircleStep * side_px; radius < most_px; radius += kCircleStep * side_px) {
    for (int i = 0; i < kDirections; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / kDirections;
      const Vec2 pixel = from + radius * Vec2(std::cos(angle), std::sin(angle));
      if (is_open(visible, pixel, depth_m, radius_px)) return pixel;
    }
  }
  return std::nullopt;
}

// The farthest depth of a pixel and those around it: on a steep surface a pixel's depth says little about points beside its middle.
double find_farthest_m(const VisibleDepth& visible, const Vec2& pixel) {
  double farthest_m = 0.0;
  for (const double x : {-1.0, 0.0, 1.0}) {
    for (const double y : {-1.0, 0.0, 1.0}) farthest_m = std::max(farthest_m, visible.depth_m(pixel + Vec2(x, y)));
  }
  return farthest_m;
}

// Whether the tip is behind the visible surface at this pixel. If the tip touches, the direction of its offset tells which side it touches:
// the back of a thin sheet is as far away as its front.
bool is_behind(const VisibleDepth& visible, const LedTip& tip, const Vec2& pixel, double tip_m, double clearance_m) {
  if (tip.offset_m.isZero()) return tip_m > find_farthest_m(visible, pixel) + kDepthTolerance * clearance_m;
  const double surface_m = visible.depth_m(pixel);
  const Vec3 to_viewer = visible.place(pixel, 0.0) - tip.p_WP;
  return tip_m > surface_m + clearance_m || (tip_m > surface_m - clearance_m && tip.offset_m.dot(to_viewer) < 0.0);
}

}  // namespace

Vec3 route_hand(const VisibleDepth& visible, const LedTip& led, const Vec3& p_WG) {
  const double tip_m = visible.depth_of(led.p_WP);
  const double goal_m = visible.depth_of(p_WG);
  if (!(tip_m > visible.near_m() && goal_m > visible.near_m())) return p_WG;
  const double clearance_m = kClearance * std::min(visible.screen().width_m, visible.screen().height_m);
  const double clearance_px = kClearance * std::min(visible.size().width_px, visible.size().height_px);
  const Vec2 tip = visible.pixel_of(led.p_WP);
  const Vec2 goal = visible.pixel_of(p_WG);
  const double surface_at_tip_m = visible.depth_m(tip);  // the surface that is seen at the tip's pixel
  const bool is_hidden = is_behind(visible, led, tip, tip_m, clearance_m);
  const bool touches_front = !led.offset_m.isZero() || tip_m <= surface_at_tip_m + kDepthTolerance * clearance_m;
  const bool slides = !is_hidden && touches_front && tip_m > surface_at_tip_m - clearance_m;
  if (!is_hidden) {
    // The path ends at the surface, however deep within it the goal is.
    const double surface_m = std::min(goal_m, visible.depth_m(goal));
    const Sight sight =
        look_along(visible, tip, tip_m, goal, surface_m, slides ? clearance_m : -kAirClearance * clearance_m, slides ? clearance_m : 0.0);
    if (sight.is_clear) return p_WG;
    if (slides || is_open(visible, tip, tip_m, 0.5 * clearance_px)) {
      const double path_depth_m = std::max(sight.nearest_m - clearance_m, kMinDepthShare * sight.nearest_m);
      return tip_m > path_depth_m + 0.5 * clearance_m ? visible.place(tip, path_depth_m) : visible.place(goal, path_depth_m);
    }
  }
  const auto way_out = find_way_out(visible, tip, tip_m, clearance_px);
  return way_out ? visible.place(*way_out, tip_m) : p_WG;
}

}  // namespace hapton
