#pragma once

#include <algorithm>
#include <cstddef>

#include "core/effects/smooth_velocity.h"
#include "core/math/types.h"

namespace hapton {

// The frame F of surfaces that move together, and the motion of the device relative to them: a hand that they carry along is at rest. Where
// they deform as well, follow_deformation() takes the motion of the touched point within F into account.
//
// A frame that takes the last device point along faster than kMaxMPerS has jumped. A jump is not a motion of the device: the velocity goes
// on as that of the hand alone. Frame: S, except for names with F. Units: m, s, m/s. RT: yes. Threads: one.
class SurfaceFrame {
 public:
  // Four times as fast as any surface may move (kMaxSurfaceSpeed).
  static constexpr double kMaxMPerS = 1.0;

  void reset() noexcept { *this = {}; }

  // Adds the next sample, with the pose of the frame. dt_s: time since the sample before; not above zero: the same moment.
  void advance(const Pose& X_SF, const Vec3& p_SD, double dt_s) noexcept {
    X_SF_ = X_SF;
    has_jumped_ = false;
    const Vec3 p_FD = to_frame(p_SD);
    if (has_point_) {
      const Vec3 last_p_FD_now = to_frame(last_p_SD_);
      has_jumped_ = !((last_p_FD_now - last_p_FD_).norm() <= kMaxMPerS * std::max(dt_s, 0.0));
      if (has_jumped_) move_last_to(last_p_FD_now);
    }
    motion_ = has_point_ ? Vec3(p_FD - last_p_FD_) : Vec3(Vec3::Zero());
    velocity_.add(p_FD, dt_s);
    samples_since_follow_ = std::min(samples_since_follow_ + 1, SmoothVelocity::kSamples);
    last_p_SD_ = p_SD;
    last_p_FD_ = p_FD;
    has_point_ = true;
  }
  // Tells that the touched point moved by moved_F within F since the sample before; the motion before the contact counts as equally fast.
  // To be called at most once after advance(). Faster than kMaxMPerS, the point has jumped, and nothing is subtracted.
  void follow_deformation(const Vec3& moved_F, double dt_s) noexcept {
    const bool is_known = dt_s > 0.0 && moved_F.norm() <= kMaxMPerS * dt_s;
    if (is_known) {
      motion_ -= moved_F;
      velocity_.shift(samples_since_follow_, moved_F / dt_s);
    }
    samples_since_follow_ = 0;
  }
  // The scene has moved, so that the last device point has other coordinates in S.
  void move_last(const Vec3& p_SD) noexcept {
    if (!p_SD.allFinite()) return;
    last_p_SD_ = p_SD;
    move_last_to(to_frame(p_SD));
  }

  // Takes over the velocity of `other`, a frame that may move otherwise, at the same sample. Pre: both have advanced to it.
  void follow(const SurfaceFrame& other) noexcept {
    if (!has_point_ || !other.has_point_) return;
    velocity_ = other.velocity_;
    velocity_.move_last(last_p_FD_);
    samples_since_follow_ = other.samples_since_follow_;
  }

  Vec3 to_frame(const Vec3& p_S) const noexcept { return X_SF_.linear().transpose() * (p_S - X_SF_.translation()); }
  Vec3 to_scene(const Vec3& p_F) const noexcept { return X_SF_ * p_F; }
  Mat3 axes() const noexcept { return X_SF_.linear(); }
  const Vec3& p_FD() const noexcept { return last_p_FD_; }
  const Vec3& motion() const noexcept { return motion_; }  // of the device relative to the surface, since the sample before; in F
  const SmoothVelocity& velocity() const noexcept { return velocity_; }  // likewise, smoothed; in F
  bool has_jumped() const noexcept { return has_jumped_; }               // in the last step

 private:
  void move_last_to(const Vec3& p_F) noexcept {
    last_p_FD_ = p_F;
    velocity_.move_last(p_F);
  }

  Pose X_SF_ = Pose::Identity();
  SmoothVelocity velocity_;
  Vec3 motion_ = Vec3::Zero();
  Vec3 last_p_SD_ = Vec3::Zero();
  Vec3 last_p_FD_ = Vec3::Zero();
  std::size_t samples_since_follow_ = 0;  // samples since follow_deformation()
  bool has_point_ = false;
  bool has_jumped_ = false;
};

}  // namespace hapton
