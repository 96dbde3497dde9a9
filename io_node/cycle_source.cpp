#include "io_node/cycle_source.h"

#include <algorithm>
#include <cmath>

#include "runtime/spin_pause.h"

namespace hapton {
namespace {

// After this many cycles in a row that were already waiting, this thread sleeps for a moment: if it never slept, LimitRTTIME would end the
// program, and the kernel would throttle the thread.
constexpr std::uint32_t kMaxCyclesBehind = 8;
constexpr std::int64_t kMinDatagrams = 32;  // smallest budget of a cycle, however high the rate

}  // namespace

bool CycleSource::await(const DeviceCycle& last, double rate_hz, std::int64_t rest_ns) noexcept {
  // The rest ends in the middle of a period, when the device side has made its cycle: the two sides may share a CPU.
  const std::int64_t rest_end_ns = last.tick_ns + rest_ns + (last.next_tick_ns - last.tick_ns) / 2;
  if (has_device_thread_ && rests(last, rest_ns) && clock_.now_ns() < rest_end_ns) {
    renew_budget(rest_ns);
    cycles_behind_ = 0;
    receiver_.receive_until(rest_end_ns);
    return loop_.has_cycle();
  }
  renew_budget(std::llround(1e9 / rate_hz));
  if (has_device_thread_) return await_device_thread(last);
  run_device_cycle();
  return true;
}

void CycleSource::renew_budget(std::int64_t period_ns) noexcept {
  if (budget_ == nullptr) return;
  budget_->renew(static_cast<std::uint32_t>(std::max(kDatagramsPerMs * period_ns / kNanosecondsPerMillisecond, kMinDatagrams)));
}

// Waits at the socket until shortly before the tick. Then the device loop spins, because no sleep ends with the accuracy of a microsecond.
void CycleSource::run_device_cycle() noexcept {
  const bool is_behind = clock_.now_ns() >= loop_.tick_ns();
  loop_.note_behind(is_behind);
  if (is_behind) receiver_.drain();
  const std::int64_t wake_ns = loop_.wake_ns();
  if (clock_.now_ns() < wake_ns) {
    receiver_.receive_until(wake_ns);
    loop_.note_wake_up(clock_.now_ns() - wake_ns);
  }
  loop_.begin_cycle();
  loop_.run_cycle();
}

bool CycleSource::await_device_thread(const DeviceCycle& last) noexcept {
  if (loop_.has_cycle()) {
    receiver_.drain();
    if (++cycles_behind_ % kMaxCyclesBehind == 0 && budget_ != nullptr) budget_->rest();
    return true;
  }
  cycles_behind_ = 0;
  // The device side wakes at the same moment: one interrupt ends both sleeps before the tick, so none disturbs it while it takes a sample.
  const std::int64_t wake_ns = last.next_wake_ns;
  const std::int64_t now_ns = clock_.now_ns();
  receiver_.receive_until(now_ns < wake_ns ? wake_ns : now_ns + kLongestSpinNs);
  const std::int64_t end_ns = std::max(last.next_tick_ns, clock_.now_ns()) + kLongestSpinNs;
  while (!loop_.has_cycle() && clock_.now_ns() < end_ns) spin_pause();
  return loop_.has_cycle();
}

void CycleSource::prepare_next_wait(const DeviceCycle& cycle, std::int64_t rest_ns) noexcept {
  if (!has_device_thread_ || rests(cycle, rest_ns)) return;
  peers_.prepare_wait(cycle.next_wake_ns);
  peers_.prepare_wait(cycle.next_tick_ns + (cycle.next_tick_ns - cycle.tick_ns) / 2);
}

}  // namespace hapton
