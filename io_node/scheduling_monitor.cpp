#include "io_node/scheduling_monitor.h"

#include <algorithm>

namespace hapton {
namespace {

constexpr double kSecondsPerNanosecond = 1e-9;
constexpr double kMillisecondsPerSecond = 1e3;

}  // namespace

SchedulingMonitor::SchedulingMonitor(double requested_spin_share, std::optional<double> realtime_share)
    : requested_spin_share_(requested_spin_share) {
  stats_.realtime_share = realtime_share.value_or(1.0);
  stats_.spin_limit = std::min(requested_spin_share_, kMaxUsedShare * stats_.realtime_share);
}

double SchedulingMonitor::update(const ThreadUsage& usage, std::int64_t spun_ns, std::int64_t now_ns) {
  const Reading now{usage, spun_ns, now_ns};
  const Reading last = last_.value_or(now);
  if (!first_) first_ = now;
  last_ = now;
  has_come_near_ = false;
  const double passed_s = kSecondsPerNanosecond * static_cast<double>(now_ns - last.now_ns);
  if (passed_s <= 0.0) return stats_.spin_limit;
  const double recent_run_share = (usage.run_s - last.usage.run_s) / passed_s;
  const double recent_spun_share = kSecondsPerNanosecond * static_cast<double>(spun_ns - last.spun_ns) / passed_s;
  stats_.spin_limit =
      std::clamp(kMaxUsedShare * stats_.realtime_share - std::max(0.0, recent_run_share - recent_spun_share), 0.0, requested_spin_share_);
  if (recent_run_share >= kNearThrottlingShare * stats_.realtime_share) has_come_near_ = stats_.near_throttling++ == 0;

  const double total_s = kSecondsPerNanosecond * static_cast<double>(now_ns - first_->now_ns);
  stats_.is_known = true;
  stats_.spun_share = std::clamp(kSecondsPerNanosecond * static_cast<double>(spun_ns - first_->spun_ns) / total_s, 0.0, 1.0);
  const double ran_share = std::clamp((usage.run_s - first_->usage.run_s) / total_s, stats_.spun_share, 1.0);
  stats_.worked_share = ran_share - stats_.spun_share;
  stats_.slept_share = 1.0 - ran_share;
  stats_.waited_ms = kMillisecondsPerSecond * (usage.waited_s - first_->usage.waited_s);
  stats_.involuntary_switches = usage.involuntary_switches - first_->usage.involuntary_switches;
  stats_.stolen_ms = kMillisecondsPerSecond * (usage.stolen_s - first_->usage.stolen_s);
  return stats_.spin_limit;
}

}  // namespace hapton
