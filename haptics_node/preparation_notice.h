#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>

#include "core/base/result.h"
#include "core/force/force_method.h"
#include "link/hub_client.h"
#include "link/messages.h"
#include "runtime/clock.h"

namespace hapton {

// A signal that one thread sets once and others wait for. Threads: any.
class DoneSignal {
 public:
  void set();
  // Waits at most this long. True: the signal is set.
  bool wait_ns(std::int64_t longest_ns);

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool is_done_ = false;
};

// Joins the hub and notifies vision nodes, by SceneFacts, that the haptic scene is still being built and for how long it has been, until
// `done` is set. Sends no force. began_ns: when the build began, by `clock`. RT: no.
void notify_preparation(HubClient& hub, const Clock& clock, SceneFacts scene, std::int64_t began_ns, DoneSignal& done);

// A preparation that takes no longer than this is not reported.
inline constexpr std::int64_t kReportPreparationAfterNs = 300 * kNanosecondsPerMillisecond;

// Builds a method in a thread of its own and returns it. If that takes longer than report_after_ns, calls `notify` once meanwhile; `notify`
// must return when its signal is set. RT: set-up only.
Result<std::unique_ptr<ForceMethod>> build_and_notify(const std::function<Result<std::unique_ptr<ForceMethod>>()>& build,
                                                      const std::function<void(DoneSignal&)>& notify,
                                                      std::int64_t report_after_ns = kReportPreparationAfterNs);

}  // namespace hapton
