#pragma once

#include <limits>
#include <string>
#include <vector>

namespace hapton {

// The CPUs to which io_node and haptics_node are pinned; -1: any. If both have the same CPU, neither node spins for the other's reply.
struct NodeCpus {
  int io = -1;
  int haptics = -1;

  bool are_shared() const { return io >= 0 && io == haptics; }
};

// One CPU for both nodes: the last that this process may use; or two: haptics_node gets the last, io_node the one before. -1: only one CPU.
NodeCpus find_one_cpu();
NodeCpus find_two_cpus();

// The force round trips of a short run; infinite if there were none.
struct TrialRun {
  double p50_us = std::numeric_limits<double>::infinity();
  double p99_us = std::numeric_limits<double>::infinity();
  double longest_us = std::numeric_limits<double>::infinity();
};

// True if each node should have its own CPU: with two, median and 99th percentile are shorter, and the longest round trip is less than
// 1.5 times that with one. A second CPU saves the switch between the nodes, but must wake up in time, which takes long on some machines.
bool should_use_two(const TrialRun& on_one, const TrialRun& on_two);

// The command-line flags that pin a node to its CPU.
std::vector<std::string> io_flags(const NodeCpus& cpus);
std::vector<std::string> haptics_flags(const NodeCpus& cpus);

// One line for people: which CPUs were chosen, and the round trips that were measured.
std::string describe_choice(const NodeCpus& chosen, const TrialRun& on_one, const TrialRun& on_two);

}  // namespace hapton
