#include "tools/latency/node_cpus.h"

#include <fmt/core.h>
#include <sched.h>

#include "runtime/realtime.h"

namespace hapton {
namespace {

// Nodes that share a CPU must not spin: neither of them could reply while the other one spins.
std::vector<std::string> flags_of(int cpu, bool is_shared, const char* spin_flag) {
  std::vector<std::string> flags = {"--cpu", fmt::format("{}", cpu)};
  if (is_shared) flags.insert(flags.end(), {spin_flag, "0"});
  return flags;
}

}  // namespace

NodeCpus find_one_cpu() {
  const int last = find_shared_cpu();
  return {.io = last, .haptics = last};
}

NodeCpus find_two_cpus() {
  NodeCpus two_cpus = {.io = -1, .haptics = find_shared_cpu()};
  cpu_set_t set;
  CPU_ZERO(&set);
  if (two_cpus.haptics < 0 || sched_getaffinity(0, sizeof set, &set) != 0) return {};
  for (int cpu = 0; cpu < two_cpus.haptics; ++cpu) {
    if (CPU_ISSET(static_cast<std::size_t>(cpu), &set)) two_cpus.io = cpu;
  }
  return two_cpus;
}

bool should_use_two(const TrialRun& on_one, const TrialRun& on_two) {
  constexpr double kMaxLongestRatio = 1.5;  // the longest round trip of a short run is partly chance
  return on_two.p50_us < on_one.p50_us && on_two.p99_us < on_one.p99_us && on_two.longest_us < kMaxLongestRatio * on_one.longest_us;
}

std::vector<std::string> io_flags(const NodeCpus& cpus) { return flags_of(cpus.io, cpus.are_shared(), "--spin-reply"); }
std::vector<std::string> haptics_flags(const NodeCpus& cpus) { return flags_of(cpus.haptics, cpus.are_shared(), "--spin"); }

std::string describe_choice(const NodeCpus& chosen, const TrialRun& on_one, const TrialRun& on_two) {
  const std::string place = chosen.are_shared() ? fmt::format("io_node and haptics_node share CPU {}", chosen.io)
                                                : fmt::format("io_node has CPU {}, haptics_node CPU {}", chosen.io, chosen.haptics);
  return fmt::format(
      "{} (round trips of a short run, p50, p99 and longest: on one CPU {:.0f}, {:.0f} and {:.0f} us, on two {:.0f}, {:.0f} and {:.0f} us)",
      place, on_one.p50_us, on_one.p99_us, on_one.longest_us, on_two.p50_us, on_two.p99_us, on_two.longest_us);
}

}  // namespace hapton
