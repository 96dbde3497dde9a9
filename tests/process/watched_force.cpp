#include "tests/process/watched_force.h"

#include <algorithm>

namespace hapton::process {

std::vector<std::string> tight_limits(const std::string& touch) {
  return {"--vision-rate", "1000", "--max-force", "1.5", "--max-slew", "100", "--touch", touch};
}

bool waits_for(System& system, const std::function<bool(const Json&)>& holds) { return holds(system.wait_for_report(holds)); }

bool feels_patches(System& system) {
  const std::int64_t before = count(system.request_report(), "local_forces");
  return waits_for(system, [&](const Json& report) { return count(report, "local_forces") > before + 100; });
}

Watched expect_within_limits(SessionObserver& observer, double seconds, Until until) {
  Watched watched;
  ProbeState last;
  std::int64_t last_sent_ns = 0;
  ProbeState state;
  const std::int64_t begin_ns = observer.now_ns();
  const auto goes_on = [&] {
    const double passed_s = 1e-9 * static_cast<double>(observer.now_ns() - begin_ns);
    const bool has_received = (until == Until::force ? watched.forces : watched.states) > 0;
    return passed_s < (has_received ? seconds : seconds + kPatience.count());
  };
  while (goes_on() && observer.receive_state(state)) {
    EXPECT_TRUE(state.force_n.allFinite());
    EXPECT_LE(state.force_n.norm(), kMaxForceN + 1e-9);
    // A state has the newest force, which was written a cycle after the state's sample, or later while replies are too old to be shown.
    const std::int64_t passed_ns = std::max(state.sample_time_ns - last.sample_time_ns, observer.sent_ns() - last_sent_ns);
    const double passed_s = 1e-9 * static_cast<double>(passed_ns) + 2e-3;
    const double risen_n = state.force_n.norm() - last.force_n.norm();
    EXPECT_TRUE(watched.states == 0 || risen_n <= kMaxSlewNPerS * passed_s) << risen_n << " N in " << passed_s << " s";
    last = state;
    last_sent_ns = observer.sent_ns();
    ++watched.states;
    watched.forces += state.force_n.norm() > 0.0 ? 1 : 0;
  }
  return watched;
}

}  // namespace hapton::process
