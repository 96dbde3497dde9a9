#include "scene/object_motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/rounded_down.h"
#include "scene/text_cursor.h"

namespace hapton {
namespace {

constexpr double kSameTurn = 1e-9;  // rad: a turn this close to half a turn counts as one
// The largest permitted difference between the first and the last keyframe of a loop, divided by the object's radius: numbers of a binary
// file have seven digits.
constexpr double kSameEnd = 1e-5;
// Relative tolerance of the speed limit: the least time that the error message names must be accepted.
constexpr double kSpeedRounding = 1e-9;

Vec3 pivot_at(const MotionSpec& motion, double scale, const Vec3& p_SM, const Quat& q_SM) { return p_SM + q_SM * (scale * motion.p_MP); }

std::vector<Keyframe> place_keyframes(const ObjectSpec& object, const SceneFit& fit) {
  const Vec3 at_rest = pivot_at(object.motion, object.scale, object.p_SM, object.q_SM);
  std::vector<Keyframe> placed;
  for (const KeyframeSpec& one : object.motion.keyframes) {
    const Quat q_SM = one.q_SM.value_or(object.q_SM);
    const Vec3 pivot = one.p_SM ? pivot_at(object.motion, object.scale, *one.p_SM, q_SM) : at_rest;
    placed.push_back({one.time_s, fit.apply(pivot), (q_SM * object.q_SM.conjugate()).normalized()});
  }
  return placed;
}

// The keyframes of an animation in the mesh file, with the object's pose and scale applied.
std::vector<Keyframe> place_animation(const ObjectSpec& object, const SceneFit& fit) {
  std::vector<Keyframe> placed;
  for (const Keyframe& one : object.animated->keyframes()) {
    placed.push_back({one.time_s / object.motion.animation_speed, fit.apply(object.p_SM + object.q_SM * (object.scale * one.p_S)),
                      (object.q_SM * one.turn * object.q_SM.conjugate()).normalized()});
  }
  return placed;
}

// A bound on how far any point of the object moves between two poses.
double difference(const Keyframe& a, const Keyframe& b, double radius_m) {
  return (a.p_S - b.p_S).norm() + radius_m * a.turn.angularDistance(b.turn);
}

// The line of keyframe i in the scene file, or that of the animation that it comes from.
std::size_t line_of(const MotionSpec& motion, std::size_t i) {
  return motion.keyframes.empty() ? motion.animation_line : motion.keyframes[i].line;
}

Result<void> check_turns(const MotionSpec& given, const std::vector<Keyframe>& keyframes, const std::string& name) {
  for (std::size_t i = 1; i < keyframes.size(); ++i) {
    if (keyframes[i - 1].turn.angularDistance(keyframes[i].turn) < std::numbers::pi - kSameTurn) continue;
    if (given.seam_s > 0.0 && i + 1 == keyframes.size()) {
      return fail("line {}: '{}' would go back to its first pose by half a turn, which may go either way: leave out 'loop'",
                  line_of(given, i), name);
    }
    return fail("line {}: keyframe {} of '{}' is half a turn from the one before, which may go either way: put one between them",
                line_of(given, i), i + 1, name);
  }
  return {};
}

// An animation has one speed factor for all its keyframes, so the error names the fastest motion.
Result<void> check_animation_speed(const MotionSpec& given, const KeyframeMotion& motion, double radius_m, const std::string& name) {
  double fastest = 0.0;
  for (std::size_t i = 1; i < motion.keyframes().size(); ++i) fastest = std::max(fastest, motion.fastest_m_per_s(i - 1, radius_m));
  if (fastest <= kMaxSurfaceSpeed * (1.0 + kSpeedRounding)) return {};
  return fail("line {}: '{}' moves at up to {:.3g} m/s; a surface may move at {:g} m/s at most: set animation_speed to {:.2g} or less",
              given.animation_line, name, fastest, kMaxSurfaceSpeed, rounded_down(given.animation_speed * kMaxSurfaceSpeed / fastest));
}

Result<void> check_speed(const MotionSpec& given, const KeyframeMotion& motion, double radius_m, const std::string& name) {
  if (given.keyframes.empty()) return check_animation_speed(given, motion, radius_m, name);
  const std::vector<Keyframe>& keyframes = motion.keyframes();
  for (std::size_t i = 1; i < keyframes.size(); ++i) {
    const double fastest = motion.fastest_m_per_s(i - 1, radius_m);
    if (fastest <= kMaxSurfaceSpeed * (1.0 + kSpeedRounding)) continue;
    const double seconds = keyframes[i].time_s - keyframes[i - 1].time_s;
    return fail(
        "line {}: before keyframe {} '{}' moves at up to {:.3g} m/s; a surface may move at {:g} m/s at most: give it {:.3f} s or more",
        line_of(given, i), i + 1, name, fastest, kMaxSurfaceSpeed, std::ceil(1e3 * seconds * fastest / kMaxSurfaceSpeed) / 1e3);
  }
  return {};
}

}  // namespace

double radius_about(const Vec3& point, const TriangleMesh& mesh) {
  double most = 0.0;
  for (const Vec3& vertex : mesh.vertices) most = std::max(most, (vertex - point).norm());
  return most;
}

Result<std::shared_ptr<const KeyframeMotion>> make_motion(const ObjectSpec& object, const std::string& name, const SceneFit& fit,
                                                          const TriangleMesh& mesh, std::vector<std::string>& notes) {
  if (!object.moves()) return std::shared_ptr<const KeyframeMotion>();
  const MotionSpec& given = object.motion;
  const Vec3 in_mesh = object.animated ? object.animated->pivot() : given.p_MP;
  const Vec3 pivot = fit.apply(object.p_SM + object.q_SM * (object.scale * in_mesh));
  const double radius_m = radius_about(pivot, mesh);
  std::vector<Keyframe> keyframes = object.animated ? place_animation(object, fit) : place_keyframes(object, fit);
  if (given.loops) {
    const bool ends_elsewhere = difference(keyframes.front(), keyframes.back(), radius_m) > kSameEnd * radius_m;
    if (ends_elsewhere && !(given.seam_s > 0.0)) {
      return fail(
          "line {}: the last keyframe of '{}' has another pose than the first, so it would jump at each repetition: end with the first "
          "pose, or leave out 'loop'",
          line_of(given, keyframes.size() - 1), printable(name));
    }
    if (given.seam_s > 0.0) {
      const double seam_s = given.seam_s / given.animation_speed;
      if (ends_elsewhere) {
        notes.push_back(
            fmt::format("line {}: the animation of '{}' ends with another pose than the first, to which it goes back in {:.3g} s",
                        given.animation_line, printable(name), seam_s));
      }
      keyframes.push_back(keyframes.back());
      keyframes.back().time_s += seam_s;
    }
    keyframes.back().p_S = keyframes.front().p_S;
    keyframes.back().turn = keyframes.front().turn;
  }
  if (const auto checked = check_turns(given, keyframes, printable(name)); !checked) return tl::unexpected(checked.error());
  auto motion = std::make_shared<const KeyframeMotion>(pivot, std::move(keyframes), given.loops);
  if (const auto checked = check_speed(given, *motion, radius_m, printable(name)); !checked) return tl::unexpected(checked.error());
  return motion;
}

}  // namespace hapton
