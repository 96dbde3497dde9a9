// hapton_watchdog: started by io_node, one for each device. It watches io_node's device side from a process of its own and releases
// the force when io_node is frozen, killed, or holds a force for too long. It needs no network, no key and no configuration. It checks from
// two threads: one with SCHED_FIFO, which no ordinary load delays, and one with SCHED_DEADLINE or, where that is denied, an ordinary one,
// which runs when the kernel throttles the first or another real-time program uses all CPU time. With PRIORITY 0 both are ordinary threads.
#include <poll.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <thread>

#include "runtime/clock.h"
#include "runtime/deadline_thread.h"
#include "runtime/realtime.h"
#include "runtime/standard_streams.h"
#include "runtime/start_thread.h"
#include "watchdog/heartbeat_memory.h"
#include "watchdog/outer_watchdog.h"

namespace {

using namespace hapton;

// Number of cuts after io_node has ended, one check period apart: it may have had one more force in transit.
constexpr int kCutsAfterEnd = 3;
// Runtime of SCHED_DEADLINE in each period: far more than a check and a cut need, and little of a CPU. A choice.
constexpr std::int64_t kRuntimeNs = 100'000;
constexpr std::int64_t kPeriodNs = 1'000'000;

bool is_gone(int process_file) {
  pollfd ended = {.fd = process_file, .events = POLLIN, .revents = 0};
  return ::poll(&ended, 1, 0) > 0 && (ended.revents & POLLIN) != 0;
}

// Sleeps until the next check, or until the process ends.
void await_next_check(int process_file) {
  pollfd ended = {.fd = process_file, .events = POLLIN, .revents = 0};
  const timespec every = {.tv_sec = 0, .tv_nsec = OuterWatchdog::kCheckPeriodNs};
  ::ppoll(&ended, 1, &every, nullptr);
}

void note_cut(HeartbeatPage& page, const OuterWatchdog& watchdog) {
  if (page.is_cut.exchange(1) != 0) return;
  page.cuts.fetch_add(1);
  if (watchdog.force_age_ns() > page.longest_force_ns.load()) page.longest_force_ns.store(watchdog.force_age_ns());
}

void report(std::string_view what, const OuterWatchdog& watchdog, const ForceCutter& cutter) {
  print_text(stderr, "hapton_watchdog: io_node {} (last cycle {:.1f} ms ago, force on the motors {:.1f} ms after its sample): {}\n", what,
             1e-6 * static_cast<double>(watchdog.silence_ns()), 1e-6 * static_cast<double>(watchdog.force_age_ns()), cutter.describe());
}

void watch(HeartbeatPage& page, WatchedProcess& process, bool must_report) {
  SteadyClock clock;
  OuterWatchdog watchdog;
  ForceCutter cutter(page, process);
  bool is_reported = false;
  while (true) {
    const bool has_ended = is_gone(process.file);
    const OuterWatchdog::Verdict verdict = watchdog.check(page, has_ended, clock.now_ns());
    page.watchdog_beat_ns.store(clock.now_ns(), std::memory_order_release);
    if (verdict == OuterWatchdog::Verdict::fine) {
      if (has_ended) return;
      is_reported = false;
      cutter.prepare();
      await_next_check(process.file);
      continue;
    }
    // Repeated at every check: a frozen process may have had one more force in transit.
    note_cut(page, watchdog);
    cutter.cut();
    if (verdict == OuterWatchdog::Verdict::gone) {
      for (int n = 1; n < kCutsAfterEnd; ++n) {
        clock.sleep_until_ns(clock.now_ns() + OuterWatchdog::kCheckPeriodNs);
        cutter.cut();
      }
      if (must_report) report("has ended", watchdog, cutter);
      return;
    }
    if (must_report && !is_reported)
      report(verdict == OuterWatchdog::Verdict::frozen ? "is frozen" : "holds a force for too long", watchdog, cutter);
    is_reported = true;
    await_next_check(process.file);
  }
}

// For a watchdog that was started in the place of another one, when io_node has ended before this one could watch it.
void cut_after_end(HeartbeatPage& page) {
  WatchedProcess none;
  ForceCutter cutter(page, none);
  SteadyClock clock;
  if (page.is_cut.exchange(1) == 0) page.cuts.fetch_add(1);
  for (int n = 0; n < kCutsAfterEnd; ++n) {
    cutter.cut();
    clock.sleep_until_ns(clock.now_ns() + OuterWatchdog::kCheckPeriodNs);
  }
  print_text(stderr, "hapton_watchdog: io_node has ended before it was watched: {}\n", cutter.describe());
}

}  // namespace

int main(int argc, char** argv) {
  const std::string_view first = argc > 1 ? argv[1] : "";
  const int io_node_pid = argc > 1 ? std::atoi(argv[1]) : 0;
  const int priority = argc > 2 ? std::atoi(argv[2]) : 0;
  if (first == "--help" || first == "-h") {
    print_text(
        "hapton_watchdog PROCESS PRIORITY\n"
        "Started by io_node, which shares memory with it as descriptor {}. Releases the force of io_node's device\n"
        "when io_node is frozen, killed, or holds a force for too long (docs/safety-case.md).\n",
        kHeartbeatDescriptor);
    return 0;
  }
  HeartbeatMemory memory;
  if (const auto opened = memory.open(kHeartbeatDescriptor); !opened || io_node_pid <= 0) {
    print_text(stderr, "hapton_watchdog: {}\n", opened ? "process id missing; this program is started by io_node" : opened.error().what);
    return 2;
  }
  // This process must outlive io_node briefly: it ignores the signals that end io_node's unit or terminal, SIGPIPE, because its stderr may
  // be closed, and SIGABRT, which systemd sends to a unit that hangs.
  for (const int signal : {SIGTERM, SIGINT, SIGHUP, SIGPIPE, SIGABRT}) ::signal(signal, SIG_IGN);
  WatchedProcess process{.file = static_cast<int>(::syscall(SYS_pidfd_open, io_node_pid, 0))};
  if (::getppid() != io_node_pid) {  // io_node has ended already, and its id may be another process's
    if (memory.page().force_sample_ns.load() != 0) cut_after_end(memory.page());
    return 0;
  }
  if (process.file < 0) {
    print_text(stderr, "hapton_watchdog: cannot watch process {}: {}\n", io_node_pid, std::strerror(errno));
    return 2;
  }
  // Both ignore whether they got their scheduling: io_node has the same rights, and logs what its own threads did not get.
  std::thread second = start_thread([&] {
    if (priority > 0) (void)enter_deadline(kRuntimeNs, kPeriodNs);
    watch(memory.page(), process, false);
  });
  (void)enter_realtime({.mode = priority > 0 ? RealtimeMode::attempt : RealtimeMode::off, .priority = priority, .low_dma_latency = false});
  watch(memory.page(), process, true);
  second.join();
  return 0;
}
