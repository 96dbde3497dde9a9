#include "remote_touch/slide_path.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "core/geometry/surface_walk.h"
#include "core/geometry/triangle_sampler.h"

namespace hapton {
namespace {

constexpr double kClearanceM = 0.005;    // above the surface, where the path begins
constexpr double kLeaveM = 0.010;        // above the surface, where the path ends
constexpr double kApproachSpeed = 0.05;  // m/s
constexpr double kSmoothM = 0.002;       // length constant, along the path, with which its normal follows that of the surface
constexpr double kMaxCurvature = 15.0;   // 1/m
constexpr double kProbeDepthM = 1e-4;    // depth below the surface at which is_free_above tries the contact
constexpr double kMaxDepths = 2.0;       // largest distance from proxy to device, as a multiple of the path's depth
constexpr int kMaxDraws = 1000;          // attempts to find a path that the hand can follow

// Whether a device that comes down along `outward` touches nothing until just above p_SQ, and just below p_SQ touches the surface at p_SQ.
bool is_free_above(ForceMethod& method, const Vec3& p_SQ, const Vec3& outward) {
  method.reset(p_SQ + kLeaveM * outward);
  for (const double share : {0.8, 0.6, 0.4, 0.2, 0.02}) {
    if (method.step({.p_SD = p_SQ + share * kLeaveM * outward}).contact) return false;
  }
  const MethodOutput below = method.step({.p_SD = p_SQ - kProbeDepthM * outward});
  const double depth_m = (below.p_SP - p_SQ).norm();
  return below.contact && depth_m < 2.0 * kProbeDepthM;
}

// Whether the proxy stays near the device along the whole path: the hand slides over one surface, and does not get behind another one.
bool is_followed(ForceMethod& method, const SlidePath& path, double max_distance_m) {
  method.reset(path.rows.front().device_m());
  for (const SlideRow& row : path.rows) {
    const Vec3 p_SD = row.device_m();
    if ((method.step({.p_SD = p_SD}).p_SP - p_SD).norm() > max_distance_m) return false;
  }
  return true;
}

class Walker {
 public:
  // Pre: `walk` outlives this object, and nothing else moves it meanwhile.
  Walker(SurfaceWalk& walk, std::uint32_t triangle, double heading_rad, double curvature) : walk_(walk), curvature_(curvature) {
    walk_.start(triangle, heading_rad);
    outward_ = walk_.normal();
  }
  void advance(double length_m) {
    walk_.turn(curvature_ * length_m);
    walk_.advance(length_m);
    const Vec3 smoothed = outward_ + (1.0 - std::exp(-length_m / kSmoothM)) * (walk_.normal() - outward_);
    outward_ = smoothed.norm() > 0.1 ? Vec3(smoothed) : walk_.normal();
  }
  SlideRow row(double depth_m) const { return {walk_.point(), outward_.normalized(), depth_m}; }

 private:
  SurfaceWalk& walk_;
  double curvature_;
  Vec3 outward_ = Vec3::Zero();
};

std::size_t rows_of(double seconds, double period_s) { return static_cast<std::size_t>(std::lround(seconds / period_s)); }

SlidePath make_rows(Walker walker, const SlidePlan& plan) {
  SlidePath path;
  const double per_row_m = kApproachSpeed * plan.period_s;
  for (double depth_m = -kClearanceM; depth_m < plan.depth_m; depth_m += per_row_m) path.rows.push_back(walker.row(depth_m));
  path.first_sliding_row = path.rows.size();
  // The hand slides to and fro on the same path. The stroke has the same length at every speed, and fits on a mesh of 100 mm.
  const std::size_t stroke_rows = std::max<std::size_t>(1, rows_of(plan.stroke_m / plan.speed_m_per_s, plan.period_s));
  for (std::size_t i = 0; i < rows_of(plan.slide_s, plan.period_s); ++i) {
    const std::size_t step = (i + 1) % (2 * stroke_rows);
    if (i < stroke_rows) {
      walker.advance(plan.speed_m_per_s * plan.period_s);
      path.rows.push_back(walker.row(plan.depth_m));
    } else {
      const SlideRow row = path.rows[path.first_sliding_row - 1 + (step <= stroke_rows ? step : 2 * stroke_rows - step)];
      path.rows.push_back(row);
    }
  }
  path.first_resting_row = path.rows.size();
  const SlideRow last = path.rows.back();
  const auto at_depth = [&](double depth_m) { return SlideRow{last.p_SQ, last.outward_S, depth_m}; };
  path.rows.insert(path.rows.end(), rows_of(plan.rest_s, plan.period_s), last);
  path.first_leaving_row = path.rows.size();
  for (double depth_m = plan.depth_m - per_row_m; depth_m > -kLeaveM; depth_m -= per_row_m) path.rows.push_back(at_depth(depth_m));
  path.rows.insert(path.rows.end(), rows_of(plan.after_s, plan.period_s), at_depth(-kLeaveM));
  return path;
}

}  // namespace

HandPath SlidePath::make_hand_path(double hand_n_per_m, double surface_n_per_m, double period_s) const {
  std::vector<HandPath::Point> points;
  points.reserve(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const SlideRow& row = rows[i];
    const double hand_depth_m = row.depth_m > 0.0 ? row.depth_m * (1.0 + surface_n_per_m / hand_n_per_m) : row.depth_m;
    points.push_back({.time_ns = std::llround(1e9 * period_s * static_cast<double>(i)), .p_WH = row.p_SQ - hand_depth_m * row.outward_S});
  }
  return HandPath(std::move(points));
}

Result<SlidePath> make_slide_path(const TriangleMesh& mesh, ForceMethod& method, const SlidePlan& plan) {
  const TriangleSampler draw_triangle(mesh);
  if (draw_triangle.empty()) return fail("slide: no triangle of the mesh has an area");
  SurfaceWalk walk(mesh);
  std::mt19937_64 random(plan.seed);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (int draw = 0; draw < kMaxDraws; ++draw) {
    const std::uint32_t triangle = draw_triangle(random);
    const double heading_rad = std::numbers::pi * (2.0 * uniform(random) - 1.0);
    const double curvature = kMaxCurvature * (2.0 * uniform(random) - 1.0);
    const SlidePath path = make_rows(Walker(walk, triangle, heading_rad, curvature), plan);
    const SlideRow& first = path.rows.front();
    const SlideRow& last = path.rows.back();
    if (is_free_above(method, first.p_SQ, first.outward_S) && is_free_above(method, last.p_SQ, last.outward_S) &&
        is_followed(method, path, kMaxDepths * plan.depth_m)) {
      return path;
    }
  }
  return fail("slide: no path over the surface was found that the hand can follow, in {} draws with seed {}", kMaxDraws, plan.seed);
}

}  // namespace hapton
