#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <string_view>
#include <thread>

#include "core/force/force_fade.h"
#include "python/fields.h"
#include "python/node_link.h"
#include "runtime/clock.h"

namespace hapton::python {

// State of a field node and its newest sample. Frame W.
struct FieldNodeState {
  std::uint64_t sample = 0;
  double t_s = 0.0;  // time of the sample by the hub's clock, since the node's first sample; continues when that clock steps back
  Vec3 p_WD = Vec3::Zero();
  Vec3 v_WD = Vec3::Zero();
  Vec3 force_n = Vec3::Zero();  // requested; the governor limits it
  std::uint32_t buttons = 0;
  bool is_joined = false;
  std::uint64_t replies = 0;
  std::uint64_t superseded = 0;
  std::uint64_t changes = 0;         // number of calls of set() that took effect
  std::uint64_t changed_sample = 0;  // the first sample that was replied to with the present fields
  bool has_watch_expired = false;    // no force: Python has called neither set, mark nor state for watch_s
  double rate_hz = 0.0;              // mean number of replies a second since the first one
  double compute_p50_us = 0.0;
  double compute_p99_us = 0.0;
};

// A haptics node whose thread replies to each sample with the sum of fields. Python sets the fields, and the thread never waits for it. A
// change of fields begins at one sample for all of them, and fades (core/force/force_fade.h). At the end the hub gets Bye, and the force is
// released. Threads: any.
class FieldNode {
 public:
  // watch_s: the force fades to zero when neither set, mark nor state has been called for that long; infinite: it never does.
  FieldNode(std::unique_ptr<NodeLink> link, double watch_s);
  ~FieldNode();
  FieldNode(const FieldNode&) = delete;
  FieldNode& operator=(const FieldNode&) = delete;

  // Error, one line: this node is closed.
  Result<void> set(std::vector<Field> fields);
  // Marks the recording once the fields set before are in use, and waits until it is marked. Returns the number of the marked sample: the
  // first one that was replied to with those fields, or one soon after. Error, one line: this node is closed, or as LiveClient::mark.
  Result<std::uint64_t> mark(std::string_view text);
  FieldNodeState state();
  void stop();

 private:
  void run();
  void reply(const DeviceState& state) noexcept;
  void follow_clock_back(std::int64_t sample_time_ns) noexcept;
  bool take_law() noexcept;  // true: the fields have changed
  void note(const DeviceState& state, const Vec3& force_n) noexcept;
  // Python has called: watch_s begins anew.
  void rewind_watch() noexcept { watched_ns_.store(clock_.now_ns(), std::memory_order_relaxed); }
  bool has_watch_expired() const noexcept;

  SteadyClock clock_;
  double watch_s_;
  std::atomic<std::int64_t> watched_ns_;
  bool had_watch_expired_ = false;
  std::unique_ptr<NodeLink> link_;
  std::shared_ptr<Markers> markers_;
  std::unique_ptr<FieldLaw> law_ = std::make_unique<FieldLaw>();
  ForceFade fade_;
  std::int64_t first_ns_ = 0;
  std::int64_t last_ns_ = 0;
  std::uint64_t changes_ = 0;
  std::uint64_t changed_sample_ = 0;

  std::mutex mutex_;                // for next_ to compute_times_; the node's thread only tries to lock it
  std::unique_ptr<FieldLaw> next_;  // fields that were set and are not in use yet
  std::unique_ptr<FieldLaw> old_;   // fields that were replaced, for Python's thread to free
  std::atomic<bool> is_law_waiting_{false};
  FieldNodeState state_;
  LatencyHistogram compute_times_;
  std::int64_t histogram_ns_ = 0;

  std::atomic<bool> is_stopping_{false};
  std::mutex stop_mutex_;  // of two threads that close this at once, one waits for the other
  std::thread thread_;
};

}  // namespace hapton::python
