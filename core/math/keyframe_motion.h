#pragma once

#include <cstddef>
#include <vector>

#include "core/math/types.h"

namespace hapton {

// The pose of a body at one time, on a motion that is known beforehand.
struct Keyframe {
  double time_s = 0.0;
  Vec3 p_S = Vec3::Zero();       // position of the pivot, m
  Quat turn = Quat::Identity();  // rotation about the pivot, from the pose at rest

  friend bool operator==(const Keyframe& a, const Keyframe& b) {
    return a.time_s == b.time_s && a.p_S == b.p_S && a.turn.coeffs() == b.turn.coeffs();
  }
};

// X_SO: takes the points of a body at rest to where they are at a keyframe. pivot_S: position of the pivot at rest. RT: yes.
Pose pose_of(const Keyframe& keyframe, const Vec3& pivot_S) noexcept;
// The pose between two keyframes, at a share from 0 to 1 of the time between them: the pivot moves straight, and the body turns about one
// axis, the shorter way (slerp: Shoemake 1985). time_s of the result is 0. RT: yes.
Keyframe keyframe_between(const Keyframe& from, const Keyframe& to, double share) noexcept;
// An upper bound, m, of the motion between two keyframes of a point no farther than radius_m from the pivot. RT: yes.
double most_travel_m(const Keyframe& from, const Keyframe& to, double radius_m) noexcept;

// The motion of a rigid body through keyframes: between two of them its pivot moves straight and evenly, and the body turns evenly about
// one axis, the shorter way (slerp: Shoemake 1985), as with LINEAR samplers of glTF 2.0. Before the first keyframe it has the pose of that
// keyframe. After the last one it stays, or begins again if the motion loops. A function of time alone. Frame: S. RT: pose_at yes, the rest
// set-up only. Threads: any for const calls.
class KeyframeMotion {
 public:
  // pivot_S: the position of the pivot while the body is at rest. Pre: two keyframes or more; times from 0 on, each later than the one
  // before; turns of unit length. If the motion loops, the first and the last keyframe have the same pose.
  KeyframeMotion(const Vec3& pivot_S, std::vector<Keyframe> keyframes, bool loops);

  // X_SO: takes the points of the body at rest to where they are at that time. Pre: the time is finite. A time before 0 counts as 0.
  Pose pose_at(double time_s) const noexcept;

  const Vec3& pivot() const { return pivot_S_; }
  const std::vector<Keyframe>& keyframes() const { return keyframes_; }
  bool loops() const { return loops_; }
  // The time until the motion ends or begins again.
  double duration_s() const { return keyframes_.back().time_s; }
  // An upper bound, m/s, of the speed between keyframes i and i + 1 of a point no farther than radius_m from the pivot; exact for one at
  // radius_m whose offset is perpendicular to the axis, if the body only turns or only shifts. Pre: i + 1 is a keyframe.
  double fastest_m_per_s(std::size_t i, double radius_m) const;

  friend bool operator==(const KeyframeMotion&, const KeyframeMotion&) = default;

 private:
  Vec3 pivot_S_;
  std::vector<Keyframe> keyframes_;
  bool loops_;
};

}  // namespace hapton
