#include "tools/doctor/realtime_rights_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

namespace hapton::doctor {
namespace {

constexpr double kRequestedPriority = 80.0;                 // the priority that io_node requests
constexpr double kEnoughMemoryBytes = 512.0 * 1024 * 1024;  // bytes; enough for a node with a large scene
constexpr double kEnoughCpuShare = 0.5;                     // share of a CPU; enough for the loop and spinning
constexpr double kMaxWakeUpUs = 20.0;                       // longest time to wake up without a warning: 2 % of a cycle at 1 kHz
constexpr const char* kLimitsFile = "/etc/security/limits.d/hapton.conf";

struct Limit {
  bool is_unlimited = false;
  double soft = 0.0;
};

// Reads a line such as "Max locked memory         8388608              8388608              bytes"
std::optional<Limit> read_limit(const Machine& machine, std::string_view name) {
  const std::string limits = machine.read("/proc/self/limits").value_or("");
  const auto words = split_words(find_field(limits, name));
  if (words.empty()) return std::nullopt;
  if (words[0] == "unlimited") return Limit{.is_unlimited = true};
  return Limit{.is_unlimited = false, .soft = std::strtod(std::string(words[0]).c_str(), nullptr)};
}

Finding check_priority(const Machine& machine) {
  const std::string subject = "real-time priority";
  if (machine.user().has_capability(User::kSysNice))
    return good(subject, fmt::format("any, by CAP_SYS_NICE; io_node requests {:g}", kRequestedPriority));
  const auto limit = read_limit(machine, "Max realtime priority");
  if (!limit) return note(subject, "not known: /proc/self/limits does not say");
  if (limit->is_unlimited || limit->soft >= kRequestedPriority)
    return good(subject, fmt::format("up to {}; io_node requests {:g}", limit->is_unlimited ? "any" : fmt::format("{:g}", limit->soft),
                                     kRequestedPriority));
  return problem(subject,
                 fmt::format("at most {:g} for {}, and io_node requests {:g}: other programs get in its way for milliseconds", limit->soft,
                             machine.user().name, kRequestedPriority),
                 line_that_grants_realtime(machine));
}

Finding check_memory_lock(const Machine& machine) {
  const std::string subject = "locked memory";
  if (machine.user().has_capability(User::kIpcLock)) return good(subject, "unlimited, by CAP_IPC_LOCK");
  const auto limit = read_limit(machine, "Max locked memory");
  if (!limit) return note(subject, "not known: /proc/self/limits does not say");
  if (limit->is_unlimited) return good(subject, "unlimited");
  const std::string observation = fmt::format("at most {:.0f} MiB for {}", limit->soft / (1024.0 * 1024.0), machine.user().name);
  if (limit->soft >= kEnoughMemoryBytes) return good(subject, observation);
  return problem(subject, observation + ": a page fault in the loop costs a millisecond or more", line_that_grants_realtime(machine));
}

Finding check_throttling(const Machine& machine) {
  const std::string subject = "real-time throttling";
  const auto runtime = machine.read_number("/proc/sys/kernel/sched_rt_runtime_us");
  const auto period = machine.read_number("/proc/sys/kernel/sched_rt_period_us");
  if (!runtime || !period || *period <= 0.0) return note(subject, "not known: the kernel does not say");
  if (*runtime < 0.0) {
    return warning(subject, "off: a loop that runs wild would take its CPU for good", "sudo sysctl -w kernel.sched_rt_runtime_us=950000");
  }
  const double share = *runtime / *period;
  const std::string observation = fmt::format("real-time threads get {:.0f} % of each CPU", 100.0 * share);
  if (share >= kEnoughCpuShare) return good(subject, observation);
  return problem(subject, observation + ": the loop is stopped for the rest of each second",
                 "sudo sysctl -w kernel.sched_rt_runtime_us=950000");
}

// With control groups version 1 each group has its own share of real time, which is zero unless it was set.
std::optional<Finding> check_group_share(const Machine& machine) {
  const std::string groups = machine.read("/proc/self/cgroup").value_or("");
  for (const std::string_view line : split_lines(groups)) {
    const std::size_t begin = line.find(':') + 1;
    const std::size_t end = line.find(':', begin);
    if (begin == 0 || end == line.npos) continue;
    const std::string controllers = fmt::format(",{},", line.substr(begin, end - begin));
    if (controllers.find(",cpu,") == controllers.npos) continue;
    const std::string file = fmt::format("/sys/fs/cgroup/{}{}/cpu.rt_runtime_us", line.substr(begin, end - begin), line.substr(end + 1));
    if (machine.read_number(file) != 0.0) continue;
    return problem("real time of the control group",
                   fmt::format("{} is 0: real-time priority is denied in it, whatever the limits say", file),
                   fmt::format("echo 950000 | sudo tee {}", file));
  }
  return std::nullopt;
}

// The sleep states of the first CPU that are in use, and how long it takes to wake up from the deepest.
struct SleepStates {
  std::string deepest;
  double latency_us = 0.0;
  int count = 0;
};

SleepStates read_sleep_states(const Machine& machine) {
  SleepStates states;
  const std::string folder = "/sys/devices/system/cpu/cpu0/cpuidle";
  for (const std::string& name : machine.list(folder)) {
    if (!name.starts_with("state") || machine.read_number(folder + "/" + name + "/disable").value_or(0.0) != 0.0) continue;
    ++states.count;
    const double latency_us = machine.read_number(folder + "/" + name + "/latency").value_or(0.0);
    if (latency_us < states.latency_us) continue;
    states.latency_us = latency_us;
    states.deepest = machine.read(folder + "/" + name + "/name").value_or(name);
  }
  return states;
}

}  // namespace

std::string line_that_grants_realtime(const Machine& machine) {
  const auto group = machine.find_group("hapton");
  if (machine.exists(kLimitsFile) && group) {
    if (group->has_user) return "log out and in again: the group hapton has the rights, but this session is older";
    return fmt::format("sudo adduser {} hapton   # then log out and in again", machine.user().name);
  }
  return fmt::format(
      "sudo groupadd -f hapton && sudo adduser {} hapton && printf '@hapton - rtprio 90\\n@hapton - memlock unlimited\\n' | sudo tee {}   "
      "# "
      "then log out and in again",
      machine.user().name, kLimitsFile);
}

Findings check_rights(const Machine& machine) {
  Findings findings = {check_priority(machine), check_memory_lock(machine), check_throttling(machine)};
  if (auto group = check_group_share(machine)) findings.push_back(std::move(*group));
  return findings;
}

Findings check_sleep(const Machine& machine) {
  constexpr const char* kNode = "/dev/cpu_dma_latency";
  const std::string subject = "CPU sleep";
  const SleepStates states = read_sleep_states(machine);
  if (states.count == 0) return {good(subject, "this kernel sees no sleep states (a virtual machine, or cpuidle is off)")};
  const std::string deepest = fmt::format("the deepest state in use is {}, {:g} us to wake up", states.deepest, states.latency_us);
  if (machine.may_use(kNode)) return {good(subject, fmt::format("{}; io_node keeps CPUs out of it by {}", deepest, kNode))};
  if (states.latency_us <= kMaxWakeUpUs) return {good(subject, deepest)};
  const std::string observation = fmt::format("{}, and {} is closed to {}", deepest, kNode, machine.user().name);
  if (!machine.exists(kNode))
    return {problem(subject, fmt::format("{}, and this kernel has no {}", deepest, kNode), "boot with the kernel parameter cpuidle.off=1")};
  const auto group = machine.find_group("hapton");
  const auto facts = machine.facts(kNode);
  if (group && facts && facts->gid == group->gid) return {problem(subject, observation, line_that_grants_realtime(machine))};
  return {
      problem(subject, observation,
              fmt::format("sudo groupadd -f hapton && sudo adduser {} hapton && echo 'KERNEL==\"cpu_dma_latency\", GROUP=\"hapton\", "
                          "MODE=\"0660\"' | sudo tee /etc/udev/rules.d/60-hapton.rules && sudo udevadm control --reload && sudo udevadm "
                          "trigger --action=change --sysname-match=cpu_dma_latency   # then log out and in again",
                          machine.user().name))};
}

}  // namespace hapton::doctor
