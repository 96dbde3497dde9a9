#pragma once

#include <cstddef>
#include <vector>

#include "core/math/types.h"

namespace hapton {

// Where a body is at one time, on a motion that is known beforehand.
struct Keyframe {
  double time_s = 0.0;
  Vec3 p_S = Vec3::Zero();       // of the pivot, m
  Quat turn = Quat::Identity();  // about the pivot, from the body's pose at rest

  friend bool operator==(const Keyframe& a, const Keyframe& b) {
    return a.time_s == b.time_s && a.p_S == b.p_S && a.turn.coeffs() == b.turn.coeffs();
  }
};

// X_SO: what the points of a body at rest are moved by at a keyframe. pivot_S: on the body at rest. RT: yes.
Pose pose_of(const Keyframe& keyframe, const Vec3& pivot_S) noexcept;
// Between two keyframes, at a share from 0 to 1 of the time between them: the pivot moves straight, and the body turns about one axis, the
// shorter way (slerp: Shoemake 1985). The time of the result is 0. RT: yes.
Keyframe keyframe_between(const Keyframe& from, const Keyframe& to, double share) noexcept;
// How far a point of the body moves between two keyframes at most, m: no point is farther than radius_m from the pivot. RT: yes.
double most_travel_m(const Keyframe& from, const Keyframe& to, double radius_m) noexcept;

// The motion of a rigid body through keyframes: between two of them its pivot moves straight and evenly, and the body turns evenly about
// one axis, the shorter way (slerp: Shoemake 1985), as with LINEAR samplers of glTF 2.0. Before the first keyframe it is where that one has
// it. After the last it stays, or begins again if the motion loops. A function of time alone. Frame: S. RT: pose_at yes, the rest
// set-up only. Threads: const calls from any number.
class KeyframeMotion {
 public:
  // pivot_S: on the body at rest. Pre: two keyframes or more; times from 0 on, each after the one before; turns of unit length. Where it
  // loops, the first and the last have one pose.
  KeyframeMotion(const Vec3& pivot_S, std::vector<Keyframe> keyframes, bool loops);

  // X_SO: what the points of the body at rest are moved by. Pre: a finite time. A time before 0 counts as 0.
  Pose pose_at(double time_s) const noexcept;

  const Vec3& pivot() const { return pivot_S_; }
  const std::vector<Keyframe>& keyframes() const { return keyframes_; }
  bool loops() const { return loops_; }
  // Until it ends or begins again.
  double duration_s() const { return keyframes_.back().time_s; }
  // No point farther than radius_m from the pivot moves faster than this between keyframes i and i + 1, m/s; for a point in the plane
  // through the pivot square to the axis, where the motion is a turn or a shift alone, just as fast. Pre: i + 1 is a keyframe.
  double fastest_m_per_s(std::size_t i, double radius_m) const;

  friend bool operator==(const KeyframeMotion&, const KeyframeMotion&) = default;

 private:
  Vec3 pivot_S_;
  std::vector<Keyframe> keyframes_;
  bool loops_;
};

}  // namespace hapton
