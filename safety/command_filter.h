#pragma once

#include <cstdint>

#include "safety/safety_limits.h"

namespace hapton {

// A requested wrench, in reply to the device sample taken at sample_time_ns (the clock of the governor). Frame: W (world).
struct WrenchCommand {
  Wrench wrench;
  std::int64_t sample_time_ns = 0;
};

// Decides which commands are valid, and for how long:
// - finite: a command that is not finite is rejected, and ends the one before as well.
// - fresh: a command is rejected if its sample is in the future, is kCommandTimeoutNs old or older, or is not newer than the sample of the
//   last accepted command.
// - timeout: a command is valid until kCommandTimeoutNs after its sample, not after its arrival. A force that travelled for 19 ms would
//   otherwise be held until its sample is 39 ms old.
// RT: yes. Threads: one.
class CommandFilter {
 public:
  enum class Verdict : std::uint8_t { accepted, force_not_finite, torque_not_finite, future, old };

  // Pre, here and below: now_ns >= 0 and never decreases from call to call.
  Verdict take(const WrenchCommand& command, std::int64_t now_ns) noexcept;
  // True once for each command timeout: at the first call after it.
  bool times_out(std::int64_t now_ns) noexcept;
  // Ends the command that is in use.
  void release() noexcept { is_live_ = false; }

  // A command is in use: wrench() is its wrench.
  bool is_live() const noexcept { return is_live_; }
  const Wrench& wrench() const noexcept { return wrench_; }
  // Time until the command timeout of the last accepted command; below 0 after it.
  double left_s(std::int64_t now_ns) const noexcept {
    return 1e-9 * static_cast<double>(kCommandTimeoutNs - (now_ns - accepted_sample_ns_));
  }

 private:
  Wrench wrench_;
  std::int64_t accepted_sample_ns_ = 0;  // sample_time_ns of the last accepted command
  bool has_accepted_ = false;
  bool is_live_ = false;
};

}  // namespace hapton
