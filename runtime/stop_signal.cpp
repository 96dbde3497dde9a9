#include "runtime/stop_signal.h"

#include <array>
#include <atomic>
#include <csignal>
#include <cstddef>

namespace hapton {
namespace {

std::atomic<bool> stop_flag{false};
std::atomic<std::uint32_t> reports{0};
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<std::uint32_t>::is_always_lock_free,
              "a signal handler may only touch lock-free atomics");

constexpr std::array<int, 3> kSignals = {SIGINT, SIGTERM, SIGUSR1};
std::array<struct sigaction, kSignals.size()> previous_actions = {};

void on_signal(int signal) {
  if (signal == SIGUSR1) {
    reports.fetch_add(1, std::memory_order_relaxed);
  } else if (stop_flag.exchange(true, std::memory_order_relaxed)) {
    // A second request: the orderly stop hangs. signal and raise are safe in a handler; the signal takes effect when the handler returns.
    std::signal(signal, SIG_DFL);
    std::raise(signal);
  }
}

}  // namespace

StopSignal::StopSignal() {
  stop_flag.store(false);
  reports.store(0);
  struct sigaction action = {};
  action.sa_handler = on_signal;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  for (std::size_t i = 0; i < kSignals.size(); ++i) {
    sigaction(kSignals[i], &action, &previous_actions[i]);  // fails only for invalid signal numbers
  }
}

StopSignal::~StopSignal() {
  for (std::size_t i = 0; i < kSignals.size(); ++i) {
    sigaction(kSignals[i], &previous_actions[i], nullptr);
  }
}

bool StopSignal::stop_requested() const noexcept { return stop_flag.load(std::memory_order_relaxed); }

void StopSignal::request_stop() noexcept { stop_flag.store(true, std::memory_order_relaxed); }

std::uint32_t StopSignal::report_requests() const noexcept { return reports.load(std::memory_order_relaxed); }

}  // namespace hapton
