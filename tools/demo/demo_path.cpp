#include "tools/demo/demo_path.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "tools/demo/demo_shapes.h"

namespace hapton {
namespace {

// The hand is a spring of 400 N/m in series with a surface of 1,000 N/m: 8 mm behind the surface the force is 2.3 N, a firm press.
constexpr double kPressM = 0.008;
constexpr double kAheadM = 0.035;   // distance in front of the object at which most paths begin and end
constexpr double kApproachS = 0.8;  // duration of the motion to the surface; durations and lengths of paths are free choices
constexpr double kRowS = 0.01;      // time between two rows of a path
constexpr double kTwoPi = 2.0 * std::numbers::pi;

// Appends a position, after_s after the last row.
void add(DemoPath& path, double after_s, const Vec3& p_WD) {
  path.push_back({path.empty() ? 0.0 : path.back().t_s + after_s, p_WD, Quat::Identity()});
}

}  // namespace

std::optional<Vec3> find_front(const Scene& scene, double x_m, double y_m) {
  double front = -std::numeric_limits<double>::infinity();
  for (const SceneObject& object : scene.objects) {
    for (const Triangle& triangle : object.mesh->triangles) {
      const Vec3& a = object.mesh->vertices[triangle[0]];
      const Vec3 ab = object.mesh->vertices[triangle[1]] - a;
      const Vec3 ac = object.mesh->vertices[triangle[2]] - a;
      const double area = ab.x() * ac.y() - ab.y() * ac.x();
      if (area == 0.0) continue;  // seen edge-on: a neighbour gives the front
      const double u = ((x_m - a.x()) * ac.y() - (y_m - a.y()) * ac.x()) / area;
      const double v = (ab.x() * (y_m - a.y()) - ab.y() * (x_m - a.x())) / area;
      if (u >= 0.0 && v >= 0.0 && u + v <= 1.0) front = std::max(front, a.z() + u * ab.z() + v * ac.z());
    }
  }
  return std::isfinite(front) ? std::optional(Vec3(x_m, y_m, front)) : std::nullopt;
}

Result<DemoPath> make_rest_path(const Scene& scene, double x_m, double y_m, double hold_s) {
  constexpr double kCircleM = 0.004;          // radius of the slow circle on the surface
  constexpr double kCircleS = 3.0;            // duration of one circle
  constexpr double kFrontRowS = 5.0 * kRowS;  // longer than in other paths, since each row needs a search of the whole mesh
  const auto middle = find_front(scene, x_m, y_m);
  if (!middle) return fail("the scene has nothing in front of x = {} m, y = {} m", x_m, y_m);
  DemoPath path;
  add(path, 0.0, *middle + Vec3(0.0, 0.0, kAheadM));
  add(path, kApproachS, *middle - Vec3(0.0, 0.0, kPressM));
  for (double t = 0.0; t < hold_s; t += kFrontRowS) {
    const double turn = kTwoPi * t / kCircleS;
    const double radius = kCircleM * std::min(1.0, t);
    const auto front = find_front(scene, x_m + radius * std::sin(turn), y_m + radius * (1.0 - std::cos(turn)));
    // Where the scene has no surface, beyond an edge, the hand stays at its last position.
    const Vec3 next = front ? Vec3(*front - Vec3(0.0, 0.0, kPressM)) : path.back().p_WD;
    add(path, kFrontRowS, next);
  }
  add(path, 0.5 * kApproachS, *middle + Vec3(0.0, 0.0, kAheadM));
  return path;
}

DemoPath make_groove_path() {
  constexpr double kReachM = 0.075;  // distance to each side: three quarters of the groove's half length
  constexpr double kOneWayS = 4.0;   // duration from one end of the groove's path to the other
  const double bottom_m = demo_groove::kFrontM - demo_groove::kDepthM - 1.25 * kPressM;
  DemoPath path;
  add(path, 0.0, Vec3(0.0, 0.0, demo_groove::kFrontM + kAheadM));
  add(path, kApproachS, Vec3(0.0, 0.0, bottom_m));
  for (double t = kRowS; t < 4.0 * kOneWayS; t += kRowS) {
    add(path, kRowS, Vec3(kReachM * std::sin(kTwoPi * t / (2.0 * kOneWayS)), 0.0, bottom_m));
  }
  add(path, 0.5 * kApproachS, Vec3(0.0, 0.0, demo_groove::kFrontM + kAheadM));
  return path;
}

DemoPath make_tap_path() {
  constexpr double kTapS = 0.5;                     // duration of one tap
  constexpr double kHoldS = 0.7;                    // time behind the wall
  constexpr double kRoundS = 4.0 * kTapS + kHoldS;  // three taps, and one that stays behind the wall
  constexpr int kRounds = 4;                        // in the whole path
  constexpr double kMiddleM = 0.0275;               // middle of the motion across the wall, from 70 mm in front of it to 15 mm behind it
  constexpr double kAmplitudeM = 0.0425;            // amplitude of that motion; 15 mm behind the wall the force is 4 N
  DemoPath path;
  for (double t = 0.0; t < kRounds * kRoundS; t += kRowS) {
    const double round_time_s = std::fmod(t, kRoundS);
    const double tap_time_s = round_time_s - std::clamp(round_time_s - 3.5 * kTapS, 0.0, kHoldS);
    const double phase = kTwoPi * t / (kRounds * kRoundS);
    add(path, kRowS,
        Vec3(0.03 * std::sin(phase), 0.02 * std::sin(2.0 * phase), kMiddleM + kAmplitudeM * std::cos(kTwoPi * tap_time_s / kTapS)));
  }
  return path;
}

DemoPath make_arc_path(double radius_m) {
  constexpr double kArcS = 6.0;  // duration of one round of the motion over the ball
  const double inside_m = radius_m - kPressM;
  DemoPath path;
  add(path, 0.0, Vec3(0.0, 0.0, radius_m + kAheadM));
  add(path, kApproachS, Vec3(0.0, 0.0, inside_m));
  for (double t = kRowS; t < 2.0 * kArcS; t += kRowS) {
    const double yaw_rad = 0.3 * std::min(1.0, t) + 0.4 * std::sin(kTwoPi * t / kArcS);
    const double pitch_rad = 0.3 * std::sin(2.0 * kTwoPi * t / kArcS);
    add(path, kRowS,
        inside_m * Vec3(std::sin(yaw_rad) * std::cos(pitch_rad), std::sin(pitch_rad), std::cos(yaw_rad) * std::cos(pitch_rad)));
  }
  add(path, 0.5 * kApproachS, Vec3(0.0, 0.0, radius_m + kAheadM));
  return path;
}

}  // namespace hapton
