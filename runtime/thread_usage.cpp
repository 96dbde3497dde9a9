#include "runtime/thread_usage.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <sstream>

namespace hapton {
namespace {

constexpr double kSecondsPerNanosecond = 1e-9;

std::optional<double> read_number(const char* path) {
  std::ifstream file(path);
  double value = 0.0;
  return file >> value ? std::optional(value) : std::nullopt;
}

void read_switches(std::istream& status, ThreadUsage& usage) {
  for (std::string line; std::getline(status, line);) {
    std::istringstream words(line);
    std::string name;
    std::uint64_t count = 0;
    words >> name >> count;
    if (name == "voluntary_ctxt_switches:") usage.voluntary_switches = count;
    if (name == "nonvoluntary_ctxt_switches:") usage.involuntary_switches = count;
  }
}

// Line of /proc/stat: "cpu user nice system idle iowait irq softirq steal ...", in ticks.
double read_stolen_s() {
  std::ifstream stat("/proc/stat");
  std::string name;
  double ticks = 0.0;
  stat >> name;
  for (int column = 0; column < 8; ++column) stat >> ticks;
  return stat ? ticks / static_cast<double>(sysconf(_SC_CLK_TCK)) : 0.0;
}

}  // namespace

pid_t current_thread_id() { return gettid(); }

std::optional<ThreadUsage> read_thread_usage(pid_t thread) {
  std::ifstream schedstat(fmt::format("/proc/self/task/{}/schedstat", thread));
  std::ifstream status(fmt::format("/proc/self/task/{}/status", thread));
  double run_ns = 0.0;
  double waited_ns = 0.0;
  if (!(schedstat >> run_ns >> waited_ns) || !status) return std::nullopt;
  ThreadUsage usage;
  usage.run_s = kSecondsPerNanosecond * run_ns;
  usage.waited_s = kSecondsPerNanosecond * waited_ns;
  read_switches(status, usage);
  usage.stolen_s = read_stolen_s();
  return usage;
}

std::optional<double> read_realtime_share() {
  const auto runtime_us = read_number("/proc/sys/kernel/sched_rt_runtime_us");
  const auto period_us = read_number("/proc/sys/kernel/sched_rt_period_us");
  if (!runtime_us || !period_us || *period_us <= 0.0) return std::nullopt;
  return *runtime_us < 0.0 ? 1.0 : std::min(1.0, *runtime_us / *period_us);
}

}  // namespace hapton
