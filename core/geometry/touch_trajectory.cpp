#include "core/geometry/touch_trajectory.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>

#include "core/geometry/mesh_measures.h"
#include "core/geometry/surface_walk.h"
#include "core/geometry/triangle_sampler.h"

namespace hapton {
namespace {

constexpr double kPi = std::numbers::pi;
// These values are a choice, but recorded benchmarks depend on them: other values make other trajectories.
constexpr double kApproach_s = 0.2;
constexpr double kSlideSegment_s = 4.0;
constexpr double kTap_s = 0.04;
constexpr int kMaxTries = 64;  // attempts to draw a place with free space along its normal
constexpr int kSectors = 720;  // sectors of a full turn

// Whether the segment meets any triangle but `own`; tests every triangle. Rounding only changes the choice of a position.
bool is_obstructed(const TriangleMesh& mesh, const Vec3& from, const Vec3& to, std::uint32_t own) {
  const Vec3 motion = to - from;
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    if (i == own) continue;
    const Vec3& a = mesh.corner(i, 0);
    const Vec3 ab = mesh.corner(i, 1) - a;
    const Vec3 ac = mesh.corner(i, 2) - a;
    const Vec3 n = ab.cross(ac);
    const double slope = -motion.dot(n);
    if (slope == 0.0) continue;
    const Vec3 ap = from - a;
    const double t = ap.dot(n) / slope;
    if (!(t >= 0.0 && t <= 1.0)) continue;
    const Vec3 e = ap.cross(motion);  // -motion x ap
    const double v = ac.dot(e) / slope;
    const double w = -ab.dot(e) / slope;
    if (v >= 0.0 && w >= 0.0 && v + w <= 1.0) return true;
  }
  return false;
}

struct Place {
  std::uint32_t triangle;
  Vec3 point;
  Vec3 normal;
};

// A place with free space along its outward normal for the length of the approach; if no attempt finds one, the place of the last attempt.
template <class DrawPlace>
Place find_free_place(const TriangleMesh& mesh, double approach, DrawPlace draw) {
  Place place = draw();
  for (int i = 0; i < kMaxTries &&
                  is_obstructed(mesh, place.point + 1e-6 * approach * place.normal, place.point + approach * place.normal, place.triangle);
       ++i) {
    place = draw();
  }
  return place;
}

Vec3 normal_of(const TriangleMesh& mesh, std::uint32_t triangle) {
  return (mesh.corner(triangle, 1) - mesh.corner(triangle, 0)).cross(mesh.corner(triangle, 2) - mesh.corner(triangle, 0)).normalized();
}

Result<double> millimetre_of(const TriangleMesh& mesh) {
  const double extent = mesh.triangles.empty() ? 0.0 : compute_bounds(mesh).extent();
  if (!(extent > 0.0) || TriangleSampler(mesh).empty())
    return fail("trajectory: no triangle of the mesh has an area; there is nothing to follow");
  return extent / 100.0;
}

std::size_t rows_of(double seconds, const TrajectorySettings& settings) {
  return std::max<std::size_t>(2, static_cast<std::size_t>(std::lround(seconds * settings.rate_hz)));
}

// The outline of a mesh around an axis through `centre` along z: for each sector, the largest distance from the axis among the triangles in
// it that come within 12 mm of the height of `centre`.
std::vector<double> find_outline(const TriangleMesh& mesh, const Vec3& centre, double mm) {
  std::vector<double> outline(kSectors, 0.0);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    double low = 1e300, high = -1e300, farthest = 0.0;
    std::array<double, 3> angle{};
    for (int k = 0; k < 3; ++k) {
      const Vec3 p = mesh.corner(i, k) - centre;
      low = std::min(low, p.z());
      high = std::max(high, p.z());
      farthest = std::max(farthest, p.head<2>().norm());
      angle[k] = std::atan2(p.y(), p.x());
    }
    if (low > 12.0 * mm || high < -12.0 * mm) continue;
    std::sort(angle.begin(), angle.end());
    // The triangle's sectors run from one corner to another and leave out the widest gap between the corners' angles. If this is at most
    // half a turn, the axis passes through the triangle, which then counts in all sectors.
    const std::array<double, 3> gap{angle[1] - angle[0], angle[2] - angle[1], angle[0] + 2.0 * kPi - angle[2]};
    const int widest = static_cast<int>(std::max_element(gap.begin(), gap.end()) - gap.begin());
    const double from = gap[widest] <= kPi ? -kPi : angle[(widest + 1) % 3];
    const double span = gap[widest] <= kPi ? 2.0 * kPi : 2.0 * kPi - gap[widest];
    const int first = static_cast<int>(std::floor((from + kPi) / (2.0 * kPi) * kSectors)) - 1;
    const int count = static_cast<int>(std::ceil(span / (2.0 * kPi) * kSectors)) + 2;
    for (int s = first; s <= first + count && s < first + kSectors; ++s) {
      double& sector = outline[static_cast<std::size_t>((s % kSectors + kSectors) % kSectors)];
      sector = std::max(sector, farthest);
    }
  }
  return outline;
}

enum class Window : std::uint8_t { largest, mean };

// For each sector, the largest value or the mean over the sectors within five degrees of it.
std::vector<double> filter_outline(const std::vector<double>& outline, Window window) {
  std::vector<double> result(kSectors);
  for (int s = 0; s < kSectors; ++s) {
    double most = 0.0, sum = 0.0;
    for (int d = -10; d <= 10; ++d) {
      const double at = outline[static_cast<std::size_t>((s + d + kSectors) % kSectors)];
      most = std::max(most, at);
      sum += at;
    }
    result[static_cast<std::size_t>(s)] = window == Window::mean ? sum / 21.0 : most;
  }
  return result;
}

}  // namespace

Result<TouchTrajectory> make_slide_trajectory(const TriangleMesh& mesh, const TrajectorySettings& settings) {
  const auto mm = millimetre_of(mesh);
  if (!mm) return tl::unexpected(mm.error());
  std::mt19937_64 random(settings.seed);
  std::normal_distribution<double> normal;
  const TriangleSampler draw(mesh);
  SurfaceWalk walk(mesh);
  const std::size_t segment = rows_of(kSlideSegment_s, settings);
  const std::size_t approach = rows_of(kApproach_s, settings);
  const double dt = 1.0 / settings.rate_hz;
  const double low_pass = 1.0 - std::exp(-dt / 0.020);
  TouchTrajectory trajectory;
  trajectory.reset_every = segment;
  trajectory.p_SD.reserve(settings.rows);
  while (trajectory.p_SD.size() < settings.rows) {
    const Place start = find_free_place(mesh, 5.0 * *mm, [&] {
      const std::uint32_t triangle = draw(random);
      return Place{triangle, (mesh.corner(triangle, 0) + mesh.corner(triangle, 1) + mesh.corner(triangle, 2)) / 3.0,
                   normal_of(mesh, triangle)};
    });
    walk.start(start.triangle, std::uniform_real_distribution<double>(-kPi, kPi)(random));
    Vec3 up = start.normal;
    double turning = 0.0;  // rad/s
    for (std::size_t i = 0; i < segment && trajectory.p_SD.size() < settings.rows; ++i) {
      if (i < approach) {
        const double height = 5.0 - 6.5 * static_cast<double>(i + 1) / static_cast<double>(approach);
        trajectory.p_SD.push_back(start.point + height * *mm * start.normal);
        continue;
      }
      turning += (-turning * dt / 0.3) + 2.0 * std::sqrt(dt / 0.3) * normal(random);
      walk.turn(turning * dt);
      walk.advance(100.0 * *mm * dt);
      up += low_pass * (walk.normal() - up);
      const Vec3 direction = up.norm() > 0.1 ? Vec3(up.normalized()) : walk.normal();
      const double depth = 1.5 + 0.5 * std::sin(2.0 * kPi * static_cast<double>(i - approach) * dt / 0.8);
      trajectory.p_SD.push_back(walk.point() - depth * *mm * direction);
    }
  }
  return trajectory;
}

Result<TouchTrajectory> make_free_trajectory(const TriangleMesh& mesh, const TrajectorySettings& settings) {
  const auto mm = millimetre_of(mesh);
  if (!mm) return tl::unexpected(mm.error());
  const Vec3 centre = compute_bounds(mesh).centre();
  // Widens the outline, then smooths it over the same width: it gets smooth, and is nowhere below the surface. Widens it twice, because the
  // smoothing spans ten sectors to either side, and the interpolation one more.
  std::vector<double> ring = find_outline(mesh, centre, *mm);
  for (const Window window : {Window::largest, Window::largest, Window::mean}) ring = filter_outline(ring, window);
  std::mt19937_64 random(settings.seed);
  const double phase = std::uniform_real_distribution<double>(0.0, 2.0 * kPi)(random);
  TouchTrajectory trajectory;
  trajectory.p_SD.reserve(settings.rows);
  for (std::size_t i = 0; i < settings.rows; ++i) {
    const double t = static_cast<double>(i) / settings.rate_hz;
    const double turn = std::fmod(0.25 * t + phase / (2.0 * kPi), 1.0);
    const double at = turn * kSectors;
    const auto sector = static_cast<std::size_t>(at) % kSectors;
    const double part = at - std::floor(at);
    const double radius = (1.0 - part) * ring[sector] + part * ring[(sector + 1) % kSectors];
    const double height = 6.0 - 5.0 * std::cos(2.0 * kPi * t / 1.7);
    const double angle = 2.0 * kPi * turn - kPi;
    trajectory.p_SD.push_back(centre + (radius + height * *mm) * Vec3(std::cos(angle), std::sin(angle), 0.0));
  }
  return trajectory;
}

Result<TouchTrajectory> make_tap_trajectory(const TriangleMesh& mesh, const TrajectorySettings& settings) {
  const auto mm = millimetre_of(mesh);
  if (!mm) return tl::unexpected(mm.error());
  std::mt19937_64 random(settings.seed);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const TriangleSampler draw(mesh);
  const std::size_t tap = rows_of(kTap_s, settings);
  TouchTrajectory trajectory;
  trajectory.reset_every = tap;
  trajectory.p_SD.reserve(settings.rows);
  while (trajectory.p_SD.size() < settings.rows) {
    const std::size_t kind = 3 * trajectory.p_SD.size() / settings.rows;
    const Place place = find_free_place(mesh, 5.0 * *mm, [&] {
      const std::uint32_t triangle = draw(random);
      const int k = static_cast<int>(3.0 * uniform(random)) % 3;
      const Vec3 &a = mesh.corner(triangle, k), &b = mesh.corner(triangle, (k + 1) % 3), &c = mesh.corner(triangle, (k + 2) % 3);
      double u = uniform(random), v = uniform(random);
      if (u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
      const Vec3 point = kind == 0 ? Vec3(a + u * (b - a) + v * (c - a)) : kind == 1 ? a : Vec3(0.5 * (a + b));
      return Place{triangle, point, normal_of(mesh, triangle)};
    });
    for (std::size_t i = 0; i < tap && trajectory.p_SD.size() < settings.rows; ++i) {
      const double travelled = 500.0 * std::min(static_cast<double>(i), static_cast<double>(tap - 1 - i)) / settings.rate_hz;
      trajectory.p_SD.push_back(place.point + std::max(-1.5, 5.0 - travelled) * *mm * place.normal);
    }
  }
  return trajectory;
}

Result<TouchTrajectory> make_random_walk(const TriangleMesh& mesh, const TrajectorySettings& settings) {
  const auto mm = millimetre_of(mesh);
  if (!mm) return tl::unexpected(mm.error());
  std::mt19937_64 random(settings.seed);
  std::normal_distribution<double> normal;
  const MeshBounds bounds = compute_bounds(mesh);
  const Vec3 half = 0.6 * (bounds.high - bounds.low) + Vec3::Constant(5.0 * *mm);
  const double dt = 1.0 / settings.rate_hz;
  Vec3 at = bounds.centre();
  at.x() = bounds.high.x() + 4.0 * *mm;
  Vec3 velocity = Vec3::Zero();
  TouchTrajectory trajectory;
  trajectory.p_SD.reserve(settings.rows);
  for (std::size_t i = 0; i < settings.rows; ++i) {
    trajectory.p_SD.push_back(at);
    // Ornstein-Uhlenbeck velocity, with a correlation time of 0.2 s and a standard deviation of 250 mm/s in each component.
    velocity += -velocity * (dt / 0.2) + 250.0 * *mm * std::sqrt(2.0 * dt / 0.2) * Vec3(normal(random), normal(random), normal(random));
    at += velocity * dt;
    for (int k = 0; k < 3; ++k) {
      const double out = at[k] - bounds.centre()[k];
      if (std::abs(out) > half[k]) {
        at[k] = bounds.centre()[k] + std::copysign(half[k], out);
        velocity[k] = -velocity[k];
      }
    }
  }
  return trajectory;
}

}  // namespace hapton
