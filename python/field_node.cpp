#include "python/field_node.h"

#include <algorithm>
#include <utility>

#include "core/base/ns_between.h"
#include "runtime/realtime.h"
#include "runtime/start_thread.h"

namespace hapton::python {
namespace {

constexpr std::int64_t kNodeTurnNs = 20 * kNanosecondsPerMillisecond;
constexpr std::int64_t kHistogramEveryNs = 200 * kNanosecondsPerMillisecond;

}  // namespace

FieldNode::FieldNode(std::unique_ptr<NodeLink> link, double watch_s)
    : watch_s_(watch_s), watched_ns_(clock_.now_ns()), link_(std::move(link)), markers_(link_->markers()) {
  thread_ = start_thread([this] { run(); });
}

FieldNode::~FieldNode() { stop(); }

void FieldNode::stop() {
  is_stopping_.store(true);
  const std::scoped_lock lock(stop_mutex_);
  if (thread_.joinable()) thread_.join();
  link_.reset();
}

bool FieldNode::has_watch_expired() const noexcept {
  return 1e-9 * static_cast<double>(clock_.now_ns() - watched_ns_.load(std::memory_order_relaxed)) > watch_s_;
}

Result<void> FieldNode::set(std::vector<Field> fields) {
  if (is_stopping_.load()) return fail("this node is closed");
  rewind_watch();
  auto law = std::make_unique<FieldLaw>(std::move(fields));
  const std::scoped_lock lock(mutex_);
  next_ = std::move(law);
  is_law_waiting_.store(true, std::memory_order_relaxed);
  old_.reset();
  return {};
}

Result<std::uint64_t> FieldNode::mark(std::string_view text) {
  rewind_watch();
  if (is_stopping_.load()) return fail("this node is closed");
  return request_mark(*markers_, text);
}

FieldNodeState FieldNode::state() {
  rewind_watch();
  const std::scoped_lock lock(mutex_);
  FieldNodeState state = state_;
  state.compute_p50_us = 1e-3 * compute_times_.quantile_ns(0.5);
  state.compute_p99_us = 1e-3 * compute_times_.quantile_ns(0.99);
  return state;
}

void FieldNode::run() {
  // The memory is not locked, because it is that of the whole Python process. If the priority is denied, the thread runs without it.
  (void)enter_realtime({.lock_memory = false});
  while (!is_stopping_.load(std::memory_order_relaxed)) {
    if (const auto state = link_->next(link_->clock().now_ns() + kNodeTurnNs)) {
      reply(*state);
      if (!is_law_waiting_.load(std::memory_order_relaxed)) link_->send_marker();
    } else if (const std::unique_lock lock(mutex_, std::try_to_lock); lock) {
      state_.is_joined = link_->is_joined();
    }
  }
  link_->release();
}

void FieldNode::reply(const DeviceState& state) noexcept {
  if (first_ns_ == 0) first_ns_ = last_ns_ = state.sample_time_ns;
  if (take_law()) changed_sample_ = state.sample;
  // The whole time since the last sample, however long: with a shorter one, a hand that moved far meanwhile would seem fast.
  const double dt_s = seconds_between(last_ns_, state.sample_time_ns);
  if (dt_s < 0.0) follow_clock_back(state.sample_time_ns);
  last_ns_ = state.sample_time_ns;
  Vec3 requested_n = law_->step(state.p_WD, dt_s);
  const bool has_expired = has_watch_expired();
  if (has_expired) requested_n.setZero();
  if (std::exchange(had_watch_expired_, has_expired) != has_expired) fade_.begin();
  const Vec3 force_n = fade_.step(requested_n, true, std::max(dt_s, 1e-6));
  link_->reply(force_n);
  note(state, force_n);
}

// The clock has stepped back: another hub, or the hub's machine has restarted. The node's time goes on from the previous sample.
void FieldNode::follow_clock_back(std::int64_t sample_time_ns) noexcept {
  first_ns_ += ns_between(last_ns_, sample_time_ns);
  histogram_ns_ = 0;
  fade_.begin();
}

// Python holds the lock only briefly. If Python holds it now, the law is taken at the next sample.
bool FieldNode::take_law() noexcept {
  const std::unique_lock lock(mutex_, std::try_to_lock);
  if (!lock || next_ == nullptr || old_ != nullptr) return false;
  next_->take_motion(*law_);
  old_ = std::exchange(law_, std::move(next_));
  fade_.begin();
  is_law_waiting_.store(false, std::memory_order_relaxed);
  ++changes_;
  return true;
}

void FieldNode::note(const DeviceState& state, const Vec3& force_n) noexcept {
  const std::unique_lock lock(mutex_, std::try_to_lock);
  if (!lock) return;
  const double t_s = 1e-9 * static_cast<double>(state.sample_time_ns - first_ns_);
  state_.sample = state.sample;
  state_.t_s = t_s;
  state_.p_WD = state.p_WD;
  state_.v_WD = law_->velocity_m_per_s();
  state_.force_n = force_n;
  state_.buttons = state.buttons;
  state_.is_joined = true;
  state_.replies = link_->replies();
  state_.superseded = link_->superseded();
  state_.changes = changes_;
  state_.changed_sample = changed_sample_;
  state_.has_watch_expired = had_watch_expired_;
  state_.rate_hz = t_s > 0.0 ? static_cast<double>(link_->replies() - 1) / t_s : 0.0;
  if (state.sample_time_ns < histogram_ns_) return;
  histogram_ns_ = state.sample_time_ns + kHistogramEveryNs;
  compute_times_ = link_->compute_times();
}

}  // namespace hapton::python
