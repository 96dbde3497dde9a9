#include "safety/wrench_intake.h"

namespace hapton {

WrenchIntake::Verdict WrenchIntake::take(const WantedWrench& wanted, std::int64_t now_ns) noexcept {
  const bool is_force_finite = wanted.wrench.force_n.allFinite();
  if (!is_force_finite || !wanted.wrench.torque_nm.allFinite()) {
    let_go();
    return is_force_finite ? Verdict::torque_not_finite : Verdict::force_not_finite;
  }
  if (wanted.sample_time_ns > now_ns) return Verdict::future;
  const bool is_repeated = has_answered_ && wanted.sample_time_ns <= answered_ns_;
  if (is_repeated || wanted.sample_time_ns <= now_ns - kSilenceLimitNs) return Verdict::old;
  wanted_ = wanted.wrench;
  answered_ns_ = wanted.sample_time_ns;
  is_live_ = has_answered_ = true;
  return Verdict::accepted;
}

bool WrenchIntake::falls_silent(std::int64_t now_ns) noexcept {
  if (!is_live_ || now_ns - answered_ns_ < kSilenceLimitNs) return false;
  let_go();
  return true;
}

}  // namespace hapton
