#include "runtime/realtime.h"

#include <fcntl.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>

#include "runtime/thread_usage.h"

namespace hapton {
namespace {

constexpr unsigned long kTimerSlackNs = 1;  // the smallest slack: 0 would select the default of 50 us

std::string describe(int error) { return std::strerror(error); }

RealtimeItem set_timer_slack() {
  RealtimeItem item{.name = "timer slack", .requested = "1 ns", .obtained = false, .reason = {}, .remedy = {}};
  if (prctl(PR_SET_TIMERSLACK, kTimerSlackNs, 0, 0, 0) == 0) {
    item.obtained = true;
  } else {
    item.reason = describe(errno);
    item.remedy = "timers fire up to 50 us late; use a kernel that has PR_SET_TIMERSLACK";
  }
  return item;
}

RealtimeItem set_priority(int priority) {
  RealtimeItem item{.name = "priority", .requested = fmt::format("SCHED_FIFO {}", priority), .obtained = false, .reason = {}, .remedy = {}};
  sched_param parameters = {};
  parameters.sched_priority = priority;
  if (const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters); error == 0) {
    item.obtained = true;
  } else {
    item.reason = describe(error);
    item.remedy = fmt::format(
        "allow it with 'ulimit -r {0}' (rtprio {0} in /etc/security/limits.d), LimitRTPRIO={0} in the unit, "
        "or setcap cap_sys_nice+ep",
        priority);
  }
  return item;
}

RealtimeItem set_cpu(int cpu) {
  RealtimeItem item{.name = "CPU", .requested = fmt::format("{}", cpu), .obtained = false, .reason = {}, .remedy = {}};
  if (cpu >= CPU_SETSIZE) {
    item.reason = "no such number";
    item.remedy = "choose a CPU below the number that nproc prints";
    return item;
  }
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(static_cast<std::size_t>(cpu), &set);
  if (const int error = pthread_setaffinity_np(pthread_self(), sizeof set, &set); error == 0) {
    item.obtained = true;
  } else {
    item.reason = describe(error);
    item.remedy = fmt::format("choose one of the CPUs this process may use (taskset -p {}), counted from 0", getpid());
  }
  return item;
}

// Under a finite limit, locking future memory would make a later allocation fail; then only present mappings are locked.
int memory_lock_flags() {
  rlimit limit = {};
  const bool is_unlimited = geteuid() == 0 || (getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur == RLIM_INFINITY);
  return is_unlimited ? MCL_CURRENT | MCL_FUTURE : MCL_CURRENT;
}

RealtimeItem lock_memory() {
  const int flags = memory_lock_flags();
  RealtimeItem item{
      .name = "memory lock", .requested = (flags & MCL_FUTURE) != 0 ? "all" : "present", .obtained = false, .reason = {}, .remedy = {}};
  if (mlockall(flags) == 0) {
    item.obtained = true;
  } else {
    item.reason = describe(errno);
    item.remedy = "allow it with 'ulimit -l unlimited' (memlock in /etc/security/limits.d) or LimitMEMLOCK=infinity in the unit";
  }
  return item;
}

RealtimeItem hold_low_latency() {
  RealtimeItem item{.name = "wake-up latency", .requested = "0 us", .obtained = false, .reason = {}, .remedy = {}};
  // The request holds as long as the file is open. A process opens it once; the end of the process closes it.
  static std::atomic<int> held = -1;
  if (held >= 0) {
    item.obtained = true;
    return item;
  }
  const int file = open("/dev/cpu_dma_latency", O_RDWR | O_CLOEXEC);
  const std::int32_t target_us = 0;
  if (file >= 0 && write(file, &target_us, sizeof target_us) == static_cast<ssize_t>(sizeof target_us)) {
    held = file;
    item.obtained = true;
    return item;
  }
  item.reason = describe(errno);
  item.remedy = "allow this user to write /dev/cpu_dma_latency (udev rule), or boot with cpuidle.off=1";
  if (file >= 0) {
    close(file);
  }
  return item;
}

std::string item_text(const RealtimeItem& item) {
  if (item.obtained) {
    return fmt::format("{} {}: granted", item.name, item.requested);
  }
  return fmt::format("{} {}: denied ({}; {})", item.name, item.requested, item.reason, item.remedy);
}

}  // namespace

Result<RealtimeMode> parse_realtime_mode(std::string_view text) {
  if (text == "off") return RealtimeMode::off;
  if (text == "try") return RealtimeMode::attempt;
  if (text == "require") return RealtimeMode::require;
  return fail("real-time mode '{}' is not known; use off, try or require", text);
}

bool RealtimeReport::complete() const {
  return std::all_of(items.begin(), items.end(), [](const RealtimeItem& item) { return item.obtained; });
}

std::string RealtimeReport::to_text() const {
  std::string text = "real time: ";
  for (const RealtimeItem& item : items) {
    text += (&item == items.data() ? "" : "; ") + item_text(item);
  }
  if (allowed_share) text += fmt::format("; the kernel allows real-time threads {:.0f} % of each CPU", 100.0 * *allowed_share);
  return text;
}

std::vector<std::string> RealtimeReport::to_lines() const {
  std::vector<std::string> lines(1, "real time: ");
  for (const RealtimeItem& item : items) {
    lines[0] +=
        fmt::format("{}{} {}: {}", &item == items.data() ? "" : "; ", item.name, item.requested, item.obtained ? "granted" : "denied");
    if (!item.obtained) lines.push_back(fmt::format("not granted: {} {} ({}); {}", item.name, item.requested, item.reason, item.remedy));
  }
  if (allowed_share) lines[0] += fmt::format("; the kernel allows real-time threads {:.0f} % of each CPU", 100.0 * *allowed_share);
  return lines;
}

Result<RealtimeReport> enter_realtime(const RealtimeSettings& settings) {
  if (settings.priority < 0 || settings.priority > kMaxRealtimePriority) {
    return fail("real-time priority {} is out of range; use 1 to 99, or 0 for none", settings.priority);
  }
  RealtimeReport report;
  report.items.push_back(set_timer_slack());
  if (settings.mode != RealtimeMode::off) {
    // The CPU first: a thread must not be moved once it has priority over the others.
    if (settings.cpu >= 0) report.items.push_back(set_cpu(settings.cpu));
    if (settings.lock_memory) report.items.push_back(lock_memory());
    if (settings.low_dma_latency) report.items.push_back(hold_low_latency());
    if (settings.priority > 0) {
      report.items.push_back(set_priority(settings.priority));
      if (report.items.back().obtained) report.allowed_share = read_realtime_share();
    }
  }
  if (settings.mode == RealtimeMode::require && !report.complete()) {
    std::string rejected;
    for (const RealtimeItem& item : report.items) {
      if (!item.obtained) rejected += (rejected.empty() ? "" : "; ") + item_text(item);
    }
    return fail("real time is required, but was not granted: {}; or start with --rt try", rejected);
  }
  return report;
}

int find_shared_cpu() {
  cpu_set_t set;
  CPU_ZERO(&set);
  if (sched_getaffinity(0, sizeof set, &set) != 0 || CPU_COUNT(&set) < 2) return -1;
  int cpu = CPU_SETSIZE - 1;
  while (!CPU_ISSET(static_cast<std::size_t>(cpu), &set)) --cpu;
  return cpu;
}

}  // namespace hapton
