#pragma once

#include <limits>
#include <string>
#include <vector>

namespace hapton {

// The CPUs to pin io_node and haptics_node to; -1: any. If they share one they take turns there, and neither spins for the other.
struct NodeCpus {
  int io = -1;
  int haptics = -1;

  bool are_shared() const { return io >= 0 && io == haptics; }
};

// The last CPU that this process may use, for both nodes; or one each, of which haptics_node has the last. Both -1: there is only one.
NodeCpus find_one_cpu();
NodeCpus find_two_cpus();

// Force round trips of a short run; infinite if there were none.
struct TrialRun {
  double p50_us = std::numeric_limits<double>::infinity();
  double p99_us = std::numeric_limits<double>::infinity();
  double longest_us = std::numeric_limits<double>::infinity();
};

// True if the nodes should have a CPU each: median and 99th percentile are shorter there, and the longest round trip is not much longer. A
// second CPU saves the switch between the nodes, but must wake up in time, too, so that on some machines the tail becomes longer.
bool should_use_two(const TrialRun& on_one, const TrialRun& on_two);

// The flags that put a node there.
std::vector<std::string> io_flags(const NodeCpus& cpus);
std::vector<std::string> haptics_flags(const NodeCpus& cpus);

// One line: what was measured and chosen.
std::string describe_choice(const NodeCpus& chosen, const TrialRun& on_one, const TrialRun& on_two);

}  // namespace hapton
