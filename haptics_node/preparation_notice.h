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

// Whether something that another thread does is done. Threads: any.
class DoneSignal {
 public:
  void set();
  // True when it is done; false after the given time.
  bool wait_ns(std::int64_t longest_ns);

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool is_done_ = false;
};

// Joins the hub and notifies vision nodes, by SceneFacts, that the haptic scene is still being built and for how long, until it is done.
// Commands nothing. began_ns: of the clock. RT: no.
void notify_preparation(HubClient& hub, const Clock& clock, SceneFacts scene, std::int64_t began_ns, DoneSignal& done);

// A shorter preparation is not reported.
inline constexpr std::int64_t kPreparationMomentNs = 300 * kNanosecondsPerMillisecond;

// Builds a method in its own thread. If that takes longer than a moment, calls `notify` once meanwhile, which must return when the given
// signal is set. RT: set-up only.
Result<std::unique_ptr<ForceMethod>> build_and_notify(const std::function<Result<std::unique_ptr<ForceMethod>>()>& build,
                                                      const std::function<void(DoneSignal&)>& notify,
                                                      std::int64_t moment_ns = kPreparationMomentNs);

}  // namespace hapton
