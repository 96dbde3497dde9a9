#include "core/force/evaluation/stress_episode.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace hapton {
namespace {

// Numbers of steps and legs: free choices. Long walks, of 20,000 steps, find faults that need more steps than an ordinary episode has.
constexpr std::size_t kLongestEpisode = 400;
constexpr int kWalkSteps = 390;
constexpr int kLongWalkLegs = 20;
constexpr int kLongWalkLegSteps = 1000;

std::uint64_t hash_of(std::string_view text) {  // FNV-1a
  std::uint64_t hash = 1469598103934665603ULL;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ULL;
  return hash;
}

}  // namespace

std::string_view name_of(StressMotion motion) {
  constexpr std::array<std::string_view, static_cast<std::size_t>(StressMotion::count)> kNames = {
      "slide", "tap-face", "tap-vertex", "tap-edge", "coincident", "near-parallel", "fast", "tiny", "walk", "hostile"};
  return kNames[static_cast<std::size_t>(motion)];
}

StressEpisode::StressEpisode(const TriangleMesh& mesh, SurfaceWalk& walk, double extent, bool is_free_outside, std::uint64_t seed,
                             std::string_view body, std::uint64_t number)
    : mesh_(mesh), walk_(walk), extent_(extent), side_(is_free_outside ? 1.0 : -1.0) {
  const std::uint64_t name = hash_of(body);
  std::seed_seq sequence{seed, seed >> 32, name, name >> 32, number, number >> 32};
  random_.seed(sequence);
  motion_ = static_cast<StressMotion>(random_() % static_cast<std::uint64_t>(StressMotion::count));
  is_long_ = number >= kFirstLongWalk;
  if (is_long_) motion_ = StressMotion::walk;
}

void StressEpisode::draw(const std::function<bool(const Vec3&)>& is_free, std::vector<Vec3>& positions) {
  positions.clear();
  for (int i = 0; i < 32; ++i) {
    choose_position();
    start_ = surface_point_ + 0.05 * extent_ * up_;
    if (is_free(start_)) break;
  }
  positions.push_back(start_);
  if (is_long_) return walk_over_body(positions);
  switch (motion_) {
    case StressMotion::slide:
      slide(positions);
      break;
    case StressMotion::tap_face:
    case StressMotion::tap_vertex:
    case StressMotion::tap_edge:
      tap(positions);
      break;
    case StressMotion::coincident:
      coincide(positions);
      break;
    case StressMotion::near_parallel:
      graze(positions);
      break;
    case StressMotion::fast:
      jump(positions);
      break;
    case StressMotion::tiny:
      creep(positions);
      break;
    default:
      random_walk(positions, kWalkSteps);
      break;
  }
  if (positions.size() > kLongestEpisode) positions.resize(kLongestEpisode);
}

Vec3 StressEpisode::direction() {
  Vec3 v(normal(), normal(), normal());
  return v.norm() > 0.0 ? Vec3(v.normalized()) : Vec3(Vec3::UnitX());
}

void StressEpisode::choose_position() {
  for (int i = 0; i < 64; ++i) {
    triangle_ = static_cast<std::uint32_t>(random_() % mesh_.triangles.size());
    if (walk_.has_area(triangle_)) break;
  }
  corner_ = static_cast<int>(random_() % 3);
  const Vec3 &a = mesh_.corner(triangle_, corner_), &b = mesh_.corner(triangle_, (corner_ + 1) % 3),
             &c = mesh_.corner(triangle_, (corner_ + 2) % 3);
  const Vec3 n = (b - a).cross(c - a);
  up_ = n.squaredNorm() > 0.0 ? Vec3(side_ * n.normalized()) : direction();
  double u = uniform(0.0, 1.0), v = uniform(0.0, 1.0);
  if (u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
  const double quarter = static_cast<double>(1 + random_() % 3) / 4.0;
  surface_point_ = motion_ == StressMotion::tap_vertex ? a
                   : motion_ == StressMotion::tap_edge ? Vec3(a + quarter * (b - a))
                                                       : Vec3(a + u * (b - a) + v * (c - a));
}

void StressEpisode::go_to(std::vector<Vec3>& positions, const Vec3& to, double step) {
  const Vec3 from = positions.back();
  const auto n = static_cast<std::size_t>(std::clamp(std::ceil((to - from).norm() / step), 1.0, 200.0));
  for (std::size_t i = 1; i <= n; ++i)
    positions.push_back(i == n ? to : Vec3(from + (static_cast<double>(i) / static_cast<double>(n)) * (to - from)));
}

void StressEpisode::slide(std::vector<Vec3>& positions) {
  walk_.start(triangle_, uniform(-std::numbers::pi, std::numbers::pi));
  const double step = extent_ * log_uniform(-5.0, -1.5);
  const double depth = extent_ * log_uniform(-4.0, -1.5);
  const double bend = 0.3 * normal();
  go_to(positions, walk_.point() - depth * side_ * walk_.normal(), extent_ * 0.01);
  Vec3 up = side_ * walk_.normal();
  for (int i = 0; i < 300; ++i) {
    walk_.turn(bend * normal());
    walk_.advance(step);
    up = (up + 0.2 * (side_ * walk_.normal() - up));
    positions.push_back(walk_.point() - depth * (1.0 + 0.7 * std::sin(0.1 * i)) * up);
  }
}

void StressEpisode::tap(std::vector<Vec3>& positions) {
  const double step = extent_ * log_uniform(-3.5, -1.0);
  // The probe comes along the normal, or from any direction in the free half space.
  Vec3 from = up_;
  if (random_() % 2 == 0) {
    from = direction();
    if (from.dot(up_) < 0.0) from = -from;
  }
  const Vec3 above = surface_point_ + 0.02 * extent_ * from;
  go_to(positions, above, 0.01 * extent_);
  const double depth = extent_ * log_uniform(-4.0, -1.5);
  for (int i = 0; i < 3; ++i) {
    go_to(positions, surface_point_, step);
    go_to(positions, surface_point_ - depth * from, step);
    for (int k = 0; k < 5; ++k) positions.push_back(positions.back());
    go_to(positions, above, step);
  }
}

void StressEpisode::coincide(std::vector<Vec3>& positions) {
  const Vec3 &a = mesh_.corner(triangle_, 0), &b = mesh_.corner(triangle_, 1), &c = mesh_.corner(triangle_, 2);
  auto on_lattice = [&] {
    const auto u = static_cast<double>(static_cast<int>(random_() % 7) - 2) / 2.0;
    const auto v = static_cast<double>(static_cast<int>(random_() % 7) - 2) / 2.0;
    const double lift = random_() % 3 == 0 ? (random_() % 2 == 0 ? 1.0 : -1.0) * log_uniform(-16.0, -8.0) * extent_ : 0.0;
    return Vec3(a + u * (b - a) + v * (c - a) + lift * up_);
  };
  const double size = std::max((b - a).norm(), (c - a).norm());
  for (int i = 0; i < 12; ++i) go_to(positions, on_lattice(), std::max(size * log_uniform(-2.0, 0.5), 1e-3 * extent_));
  go_to(positions, surface_point_ - extent_ * log_uniform(-6.0, -1.5) * up_, 0.003 * extent_);
  for (int i = 0; i < 6; ++i)
    go_to(positions, on_lattice() - extent_ * log_uniform(-6.0, -2.0) * up_, std::max(0.3 * size, 2e-3 * extent_));
}

void StressEpisode::graze(std::vector<Vec3>& positions) {
  Vec3 along = direction();
  along = (along - along.dot(up_) * up_).normalized();
  const double reach = extent_ * log_uniform(-3.0, -0.3);
  const double tilt = log_uniform(-15.0, -1.0);
  const Vec3 from = surface_point_ - reach * along + reach * tilt * up_;
  go_to(positions, from, 0.02 * extent_);
  for (int i = 0; i < 4; ++i) {
    go_to(positions, surface_point_ + reach * along - reach * tilt * up_, reach * log_uniform(-1.5, 0.5));
    go_to(positions, from, reach * log_uniform(-1.5, 0.5));
  }
}

void StressEpisode::jump(std::vector<Vec3>& positions) {
  const Vec3 middle = start_;
  for (int i = 0; i < 200; ++i) {
    positions.push_back(random_() % 8 == 0 ? surface_point_ - extent_ * log_uniform(-4.0, -0.5) * up_
                                           : Vec3(middle + extent_ * log_uniform(-2.0, 0.3) * direction()));
  }
}

void StressEpisode::creep(std::vector<Vec3>& positions) {
  const double step = extent_ * log_uniform(-12.0, -6.0);
  positions.push_back(surface_point_ + 2.0 * step * up_);
  Vec3 drift = direction();
  for (int i = 0; i < 150; ++i) {
    if (i % 50 == 0) drift = direction();
    positions.push_back(positions.back() + step * (0.5 * drift + 0.5 * direction() - 0.2 * up_));
  }
  const double deep = extent_ * log_uniform(-9.0, -2.0);
  positions.push_back(surface_point_ - deep * up_);
  for (int i = 0; i < 100; ++i) positions.push_back(positions.back() + step * direction());
}

void StressEpisode::walk_over_body(std::vector<Vec3>& positions) {
  for (int leg = 0; leg < kLongWalkLegs; ++leg) {
    random_walk(positions, kLongWalkLegSteps);
    choose_position();
  }
}

void StressEpisode::random_walk(std::vector<Vec3>& positions, int steps) {
  Vec3 velocity = Vec3::Zero();
  const double speed = extent_ * log_uniform(-4.0, -2.0);
  const double decay = uniform(0.02, 0.3);
  Vec3 at = positions.back();
  for (int i = 0; i < steps; ++i) {
    velocity +=
        -decay * velocity + speed * std::sqrt(2.0 * decay) * Vec3(normal(), normal(), normal()) - 0.02 * decay * (at - surface_point_);
    at += velocity;
    positions.push_back(motion_ == StressMotion::hostile && random_() % 16 == 0 ? hostile(at) : at);
  }
}

Vec3 StressEpisode::hostile(Vec3 at) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const double bad[] = {std::numeric_limits<double>::quiet_NaN(),  kInfinity, -kInfinity, 1e308, -1e30, 1e9 * extent_,
                        std::numeric_limits<double>::denorm_min(), -0.0};
  at[static_cast<int>(random_() % 3)] = bad[random_() % 8];
  return at;
}

}  // namespace hapton
