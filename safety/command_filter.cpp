#include "safety/command_filter.h"

namespace hapton {

CommandFilter::Verdict CommandFilter::take(const WrenchCommand& command, std::int64_t now_ns) noexcept {
  const bool is_force_finite = command.wrench.force_n.allFinite();
  if (!is_force_finite || !command.wrench.torque_nm.allFinite()) {
    release();
    return is_force_finite ? Verdict::torque_not_finite : Verdict::force_not_finite;
  }
  if (command.sample_time_ns > now_ns) return Verdict::future;
  const bool is_repeated = has_accepted_ && command.sample_time_ns <= accepted_sample_ns_;
  if (is_repeated || command.sample_time_ns <= now_ns - kCommandTimeoutNs) return Verdict::old;
  wrench_ = command.wrench;
  accepted_sample_ns_ = command.sample_time_ns;
  is_live_ = has_accepted_ = true;
  return Verdict::accepted;
}

bool CommandFilter::times_out(std::int64_t now_ns) noexcept {
  if (!is_live_ || now_ns - accepted_sample_ns_ < kCommandTimeoutNs) return false;
  release();
  return true;
}

}  // namespace hapton
