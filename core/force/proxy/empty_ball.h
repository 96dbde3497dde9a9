#pragma once

#include "core/collision/touch_geometry.h"

namespace hapton {

// A ball around the device that contains no triangle: while the device stays in it, the proxy is free and a step is one comparison in the
// scene's own frame. Frames: S in metres where a name says so, otherwise TouchGeometry's local one. RT: yes.
class EmptyBall {
 public:
  // False if the sample is not finite, or if there is no ball.
  bool contains(const Vec3& p_SD) const noexcept { return (p_SD - centre_S_).squaredNorm() < radius_squared_m2_; }
  // The device is at p_SD, in the ball. is_correction: as in MethodInput.
  void note_sample(const Vec3& p_SD, bool is_correction = false) noexcept {
    if (!is_correction) before_S_ = last_S_;
    last_S_ = p_SD;
  }
  bool exists() const noexcept { return radius_squared_m2_ > 0.0; }
  const Vec3& last_sample() const noexcept { return last_S_; }      // in the ball; frame S
  const Vec3& sample_before() const noexcept { return before_S_; }  // the sample before it, maybe outside the ball; frame S

  // Counts the distance that the device moves while there is no ball.
  void note_motion(double distance) noexcept { travel_until_search_ -= distance; }
  bool is_due() const noexcept { return travel_until_search_ <= 0.0; }  // the device has moved so far that a search may have another result

  // The radius of an empty ball around the device for a probe that keeps the distance `offset` from triangles, at most max_radius; 0: none
  // found. displacement: length of the device's motion in this step; the search reaches about 64 times as far.
  double find(const TouchGeometry& geometry, const Vec3& device, double displacement, double offset, double max_radius) noexcept;
  int work() const noexcept { return work_; }  // of the last find(), in units (step_work.h)
  // Begins a ball of that radius around the device at p_SD. before_S: the device in the sample before.
  void enter(const TouchGeometry& geometry, const Vec3& p_SD, const Vec3& before_S, double radius) noexcept;
  void leave(const TouchGeometry& geometry) noexcept;
  void reset() noexcept { *this = EmptyBall(); }

 private:
  Vec3 centre_S_ = Vec3::Zero();      // m
  double radius_squared_m2_ = 0.0;    // 0: no ball known
  Vec3 last_S_ = Vec3::Zero();        // m
  Vec3 before_S_ = Vec3::Zero();      // m
  double travel_until_search_ = 0.0;  // distance before the next search
  int work_ = 0;
};

}  // namespace hapton
