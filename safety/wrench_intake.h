#pragma once

#include <cstdint>

#include "safety/safety_limits.h"

namespace hapton {

// A wrench that someone asks for, in answer to the device sample taken at sample_time_ns (the governor's own clock).
struct WantedWrench {
  Wrench wrench;
  std::int64_t sample_time_ns = 0;
};

// Which wrenches count, and for how long: the checks for finite and fresh, and the watchdog.
//   finite   what is not finite does not count, and ends what counted
//   fresh    what answers a sample of the future, one as old as kSilenceLimitNs, or none newer than the last is refused
//   silence  kSilenceLimitNs after the sample that the last one answered nothing counts any more: counted from when it came, a force that
//            was on its way for 19 ms would be held until its sample is 39 ms old
// RT: yes.
class WrenchIntake {
 public:
  enum class Verdict : std::uint8_t { accepted, force_not_finite, torque_not_finite, future, old };

  // Pre, here and below: now_ns >= 0 and never goes back.
  Verdict take(const WantedWrench& wanted, std::int64_t now_ns) noexcept;
  // True once each time it falls silent.
  bool falls_silent(std::int64_t now_ns) noexcept;
  void let_go() noexcept { is_live_ = false; }

  bool is_live() const noexcept { return is_live_; }
  const Wrench& wanted() const noexcept { return wanted_; }
  // Until it would fall silent.
  double left_s(std::int64_t now_ns) const noexcept { return 1e-9 * static_cast<double>(kSilenceLimitNs - (now_ns - answered_ns_)); }

 private:
  Wrench wanted_;
  std::int64_t answered_ns_ = 0;  // sample_time_ns of what was accepted last
  bool has_answered_ = false;
  bool is_live_ = false;
};

}  // namespace hapton
