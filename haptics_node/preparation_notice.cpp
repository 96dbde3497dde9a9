#include "haptics_node/preparation_notice.h"

#include <chrono>
#include <optional>
#include <thread>

#include "runtime/start_thread.h"

namespace hapton {
namespace {

constexpr std::int64_t kNotifyEveryNs = 200 * kNanosecondsPerMillisecond;  // often enough to show progress
constexpr std::int64_t kPollNs = 20 * kNanosecondsPerMillisecond;          // the end of the preparation is noticed within this time

}  // namespace

void DoneSignal::set() {
  const std::lock_guard lock(mutex_);
  is_done_ = true;
  changed_.notify_all();
}

bool DoneSignal::wait_ns(std::int64_t longest_ns) {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, std::chrono::nanoseconds(longest_ns), [this] { return is_done_; });
}

void notify_preparation(HubClient& hub, const Clock& clock, SceneFacts scene, std::int64_t began_ns, DoneSignal& done) {
  Datagram received;
  std::int64_t next_ns = 0;
  while (!done.wait_ns(0)) {
    const std::int64_t now_ns = clock.now_ns();
    if (hub.state() == JoinState::joined && now_ns >= next_ns) {
      scene.preparing_s = static_cast<float>(static_cast<double>(now_ns - began_ns) * 1e-9);
      hub.send(scene);
      next_ns = now_ns + kNotifyEveryNs;
    }
    // Drops the device's states: they are for the node that starts afterwards.
    (void)hub.receive(received, now_ns + kPollNs);
  }
}

Result<std::unique_ptr<ForceMethod>> build_and_notify(const std::function<Result<std::unique_ptr<ForceMethod>>()>& build,
                                                      const std::function<void(DoneSignal&)>& notify, std::int64_t report_after_ns) {
  std::optional<Result<std::unique_ptr<ForceMethod>>> built;
  DoneSignal done;
  std::thread builder = start_thread([&] {
    built.emplace(build());
    done.set();
  });
  if (!done.wait_ns(report_after_ns)) notify(done);
  builder.join();
  return std::move(*built);
}

}  // namespace hapton
