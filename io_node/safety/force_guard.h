#pragma once

#include <cstdint>
#include <optional>

#include "core/math/types.h"

namespace hapton {

// What a device bears. SI units; both finite and above zero.
struct ForceLimits {
  double max_force_n = 0.0;
  double max_slew_n_per_s = 0.0;
};

// A force someone asks for, in answer to the device sample taken at sample_time_ns (the guard's own clock).
struct WantedForce {
  Vec3 force_n = Vec3::Zero();
  std::int64_t sample_time_ns = 0;
};

// The last word on every force before it reaches the motors, whatever the others send. In this order:
//   finite   a force that is not finite is a fault: to zero, then a new ramp
//   fresh    a force that answers a sample of the future, one older than kSilenceLimitNs, or none newer than the last is refused
//   silence  kSilenceLimitNs after the last accepted force the output is zero: it has sunk before then as fast as the slew limit
//            needs, and stays zero until the next accepted force
//   ramp     after the start, a silence and a fault the force comes back in over kRampNs
//   clamp    norm at most max_force_n, direction kept
//   slew     norm of the change at most max_slew_n_per_s x time since the last step
// So the output is always finite, within the clamp and within the slew. Nothing switches any of it off; limits can only be
// tightened. Pure: time comes in, nothing is read from a clock.
// RT: step yes, tighten yes.
class ForceGuard {
 public:
  static constexpr std::int64_t kSilenceLimitNs = 20'000'000;
  static constexpr std::int64_t kRampNs = 100'000'000;
  // A device too slow to let go within the silence limit gets the slew that does.
  static constexpr std::int64_t kLongestReleaseNs = kSilenceLimitNs / 2;

  struct Counters {
    std::uint64_t accepted = 0;
    std::uint64_t not_finite = 0;
    std::uint64_t refused_old = 0;     // repeated, overtaken or older than the silence limit
    std::uint64_t refused_future = 0;  // answers a sample that has not been taken
    std::uint64_t silences = 0;        // times it went quiet after a force had been accepted
    std::uint64_t clamped = 0;
    std::uint64_t slewed = 0;  // accepted forces that the slew limit cut
  };

  // Limits that are not finite and positive give a guard that puts out zero.
  explicit ForceGuard(const ForceLimits& device);

  // Takes the smaller of the present and the given limits; what is not finite and positive changes nothing.
  void tighten(const ForceLimits& limits) noexcept;

  // The force to put out now: in answer to wanted, or without news. A now_ns that goes back counts as no time passed.
  Vec3 step(const std::optional<WantedForce>& wanted, std::int64_t now_ns) noexcept;

  const ForceLimits& limits() const noexcept { return limits_; }
  const Counters& counters() const noexcept { return counters_; }
  bool silent() const noexcept { return !live_; }

 private:
  bool accept(const WantedForce& wanted) noexcept;
  void let_go() noexcept;
  Vec3 clamped(const Vec3& force_n) noexcept;
  Vec3 target() noexcept;

  ForceLimits limits_;
  double release_n_per_s_ = 0.0;  // the device's own slew: letting go is never slowed down by tighter limits
  Counters counters_;
  Vec3 wanted_n_ = Vec3::Zero();  // accepted last, within the clamp
  Vec3 out_n_ = Vec3::Zero();
  std::int64_t now_ns_ = 0;
  std::int64_t accepted_ns_ = 0;  // when
  std::int64_t answered_ns_ = 0;  // sample_time_ns of the force accepted last
  std::int64_t ramp_begin_ns_ = 0;
  bool began_ = false;
  bool answered_ = false;
  bool live_ = false;  // a force is accepted and not older than the silence limit
};

}  // namespace hapton
