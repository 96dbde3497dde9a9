#pragma once

#include "core/collision/touch_geometry.h"

namespace hapton {

// A ball round the device without a triangle: while the device stays in it, the proxy is free and a step is one comparison in the scene's
// own frame. Frames: S in metres where a name says so, otherwise TouchGeometry's local one. RT: yes.
class EmptyBall {
 public:
  // False for samples that are not finite, and without a ball.
  bool contains(const Vec3& p_SD) const noexcept { return (p_SD - centre_S_).squaredNorm() < radius_squared_m2_; }
  // is_correction: as MethodInput has it.
  void note_sample(const Vec3& p_SD, bool is_correction = false) noexcept {
    if (!is_correction) before_S_ = last_S_;
    last_S_ = p_SD;
  }
  bool exists() const noexcept { return radius_squared_m2_ > 0.0; }
  const Vec3& last_sample() const noexcept { return last_S_; }      // in the ball; frame S
  const Vec3& sample_before() const noexcept { return before_S_; }  // the one before it, maybe outside; likewise

  // Counts the distance that the device has moved outside the ball.
  void note_motion(double distance) noexcept { to_travel_ -= distance; }
  bool is_due() const noexcept { return to_travel_ <= 0.0; }  // a search may find another result than the last one

  // The radius of an empty ball around the device for a probe that keeps the distance `rest` from triangles; 0: there is none.
  // displacement: that of the device in this step; the search is limited to about 64 of them. may_go: largest radius.
  double find(const TouchGeometry& geometry, const Vec3& device, double displacement, double rest, double may_go) noexcept;
  int work() const noexcept { return work_; }  // units (step_work.h), of the last search
  // before_S: the device in the sample before.
  void enter(const TouchGeometry& geometry, const Vec3& p_SD, const Vec3& before_S, double radius) noexcept;
  void leave(const TouchGeometry& geometry) noexcept;
  void reset() noexcept { *this = EmptyBall(); }

 private:
  Vec3 centre_S_ = Vec3::Zero();    // m
  double radius_squared_m2_ = 0.0;  // 0: no ball known
  Vec3 last_S_ = Vec3::Zero();      // m
  Vec3 before_S_ = Vec3::Zero();    // m
  double to_travel_ = 0.0;          // distance before the next search
  int work_ = 0;
};

}  // namespace hapton
