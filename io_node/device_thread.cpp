#include "io_node/device_thread.h"

#include <pthread.h>

#include <algorithm>
#include <chrono>

#include "runtime/start_thread.h"
#include "runtime/thread_usage.h"

namespace hapton {
namespace {

// How long to sleep if a cycle is late or the network side holds the claim. A choice: that side holds it for a microsecond, but if both
// share a CPU, it can go on only while this thread sleeps.
constexpr std::int64_t kMomentNs = 20'000;

}  // namespace

Result<void> DeviceThread::start(const RealtimeSettings& network) {
  if (auto opened = timer_.open(); !opened) return opened;
  RealtimeSettings settings = network;
  if (settings.priority > 0) settings.priority = std::min(settings.priority + 1, kMaxRealtimePriority);
  thread_ = start_thread([this, settings] { run(settings); });
  while (!is_started_.load(std::memory_order_acquire)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  return started_;
}

void DeviceThread::stop() {
  ends_.store(true, std::memory_order_release);
  if (thread_.joinable()) thread_.join();
}

void DeviceThread::run(const RealtimeSettings& settings) {
  id_ = current_thread_id();
  ::pthread_setname_np(::pthread_self(), "hapton-device");
  if (const auto realtime = enter_realtime(settings); realtime) {
    realtime_lines_ = realtime->to_lines();
  } else {
    started_ = tl::unexpected(realtime.error());
    is_started_.store(true, std::memory_order_release);
    return;
  }
  loop_.start();
  timer_.set(loop_.wake_ns());
  is_started_.store(true, std::memory_order_release);
  while (!ends_.load(std::memory_order_acquire)) {
    await_tick();
    loop_.begin_cycle();
    // Set before the sample is taken: otherwise the network side would wait for it.
    timer_.set(loop_.wake_after_next_ns());
    while (!loop_.run_cycle()) SteadyClock().sleep_until_ns(clock_.now_ns() + kMomentNs);
  }
  while (!loop_.finish()) SteadyClock().sleep_until_ns(clock_.now_ns() + kMomentNs);
}

// Before a late cycle this thread still sleeps for a moment: if it never did, LimitRTTIME would end the program, the kernel would throttle
// the thread, and no other thread would get its CPU.
void DeviceThread::await_tick() noexcept {
  const std::int64_t wake_ns = loop_.wake_ns();
  const bool is_behind = clock_.now_ns() >= loop_.tick_ns();
  loop_.note_behind(is_behind);
  timer_.wait();
  const std::int64_t now_ns = clock_.now_ns();
  // timer_.wait() returns at once if the timer has expired or could not be set.
  if (is_behind) return SteadyClock().sleep_until_ns(now_ns + kMomentNs);
  if (now_ns < wake_ns) SteadyClock().sleep_until_ns(wake_ns);
  loop_.note_wake_up(clock_.now_ns() - wake_ns);
}

}  // namespace hapton
