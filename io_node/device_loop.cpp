#include "io_node/device_loop.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/button_bit.h"
#include "runtime/spin_pause.h"

namespace hapton {
namespace {

// Period at which the temperature of the motors is read. Our choice: a motor heats up over seconds.
constexpr std::int64_t kTemperatureCheckNs = 250 * kNanosecondsPerMillisecond;

}  // namespace

DeviceLoop::DeviceLoop(Device& device, const Clock& clock, const Options& options)
    : device_(device),
      clock_(clock),
      policy_(options.overrun),
      governor_(device.limits()),
      clutch_(button_bit(options.clutch_button)),
      spin_(options.spin_share) {
  governor_.tighten(options.tighter_limits);
  if (options.forbids_force) governor_.forbid_force();
  if (options.forbids_torque) governor_.forbid_torque();
  governor_.require_button(options.dead_mans_switch);
  if (options.passive_mechanics) governor_.keep_passive(*options.passive_mechanics);
  stats_.rate_hz = options.rate_hz;
  start();
}

std::int64_t DeviceLoop::period_ns() const noexcept { return std::llround(1e9 / stats_.rate_hz); }

void DeviceLoop::start() noexcept {
  tick_ns_ = clock_.now_ns() + period_ns();
  stats_.start_ns = stats_.end_ns = tick_ns_;
  next_temperature_check_ns_ = tick_ns_ + kTemperatureCheckNs;
}

void DeviceLoop::begin_cycle() noexcept {
  std::int64_t now_ns = clock_.now_ns();
  const std::int64_t begin_ns = now_ns;
  for (; now_ns < tick_ns_; now_ns = clock_.now_ns()) spin_pause();
  spin_.note_spun(now_ns - begin_ns);
  const std::int64_t late_ns = now_ns - tick_ns_;
  stats_.wake_lateness.record(late_ns);
  cycle_.late_ns = late_ns;
  if (late_ns >= period_ns()) {
    handle_overrun(late_ns);
  } else {
    cycle_.missed = 0;
    cycle_.cause = MissCause::none;
  }
  overslept_ns_ = 0;
}

// Handles one or more missed cycles according to the policy.
void DeviceLoop::handle_overrun(std::int64_t late_ns) noexcept {
  const bool is_catching_up = policy_ == OverrunPolicy::catch_up && cycle_.cause != MissCause::none;
  if (!is_catching_up) cycle_.cause = cause_of(late_ns);
  const std::int64_t missed = late_ns / period_ns();
  const std::int64_t caught_up = policy_ == OverrunPolicy::catch_up ? std::min(missed, kMaxCaughtUp) : 0;
  tick_ns_ += (missed - caught_up) * period_ns();
  cycle_.missed = static_cast<std::uint32_t>(missed - caught_up);
  stats_.missed_cycles += static_cast<std::uint64_t>(missed - caught_up);
  stats_.caught_up_cycles += caught_up > 0 ? 1 : 0;
  stats_.missed_by_cause[static_cast<std::size_t>(cycle_.cause)] +=
      static_cast<std::uint64_t>(missed - caught_up) + (caught_up > 0 ? 1 : 0);
  if (policy_ == OverrunPolicy::stop) has_overrun_.store(true, std::memory_order_release);
}

// The cause of a late cycle, from the clock readings of the last cycle alone, without a system call.
MissCause DeviceLoop::cause_of(std::int64_t late_ns) const noexcept {
  if (device_call_ns_.load(std::memory_order_relaxed) > period_ns() / 2) return MissCause::device_slow;
  if (late_ns >= kStallNs) return MissCause::machine_stalled;
  return is_behind_ && overslept_ns_ <= period_ns() / 2 ? MissCause::work_long : MissCause::late_wake_up;
}

bool DeviceLoop::claim() noexcept {
  bool expected = false;
  return claimed_.compare_exchange_strong(expected, true);
}

bool DeviceLoop::run_cycle() noexcept {
  if (!claim()) {
    (void)cut_if_older(kCommandTimeoutNs);
    return false;
  }
  device_call_ns_.store(0, std::memory_order_relaxed);
  stats_.end_ns = tick_ns_ + period_ns();
  // Before the device is read, which may take long: release a force that the governor would no longer output.
  const std::int64_t now_ns = clock_.now_ns();
  if (force_sample_ns() != 0 && now_ns - accepted_sample_ns_ >= kCommandTimeoutNs) hold_force();
  sample_device();
  if (local_touch_ != nullptr) step_locally();
  // A force that came since the last tick has used this cycle's share of the slew limit; one from before a stall has not.
  const bool has_fresh_force = force_written_ns_ >= 0 && clock_.now_ns() - force_written_ns_ < period_ns() + period_ns() / 2;
  force_written_ns_ = -1;
  // After a cut by any thread the force is ramped to zero before the device is restored.
  const bool is_ramping_down = is_cut() && force_sample_ns() != 0;
  if (is_ramping_down) governor_.interrupt();
  if (!has_fresh_force || is_ramping_down) hold_force();
  cut_or_restore();
  // Before apply_requests(), which may raise the rate: the thread may have set its timer for this tick already, so no tick may come sooner.
  tick_ns_ += period_ns();
  apply_requests();
  cycle_.next_tick_ns = tick_ns_;
  cycle_.written = written_;
  cycle_.next_wake_ns = wake_ns();
  const std::size_t end = cycles_end_.load(std::memory_order_relaxed);
  if (end - cycles_begin_.load(std::memory_order_acquire) < kMaxQueuedCycles) {
    cycles_[end % kMaxQueuedCycles] = cycle_;
    cycles_end_.store(end + 1, std::memory_order_release);
  } else {
    ++stats_.cycles_unreported;
  }
  publish_side();
  release_claim();
  serve();
  const std::int64_t done_ns = clock_.now_ns();
  heartbeat_ns_.store(done_ns, std::memory_order_release);
  if (heartbeat_page_ != nullptr) heartbeat_page_->heartbeat_ns.store(done_ns, std::memory_order_release);
  return true;
}

// True: the cycle, another thread of this process or the watchdog process has cut the device. A cut for a latched fault does not count.
bool DeviceLoop::is_cut() const noexcept {
  return is_cut_by_process_.load(std::memory_order_acquire) ||
         (heartbeat_page_ != nullptr && heartbeat_page_->is_cut.load(std::memory_order_acquire) != 0);
}

// Once the commanded force is zero: cuts the device while a fault is latched, so that its driver adds nothing by itself either; restores
// it otherwise, so that the force returns with the governor's ramp and not with a jump.
void DeviceLoop::cut_or_restore() noexcept {
  if (force_sample_ns() != 0) return;
  if (governor_.fault() != SafetyFault::none) {
    if (!std::exchange(is_cut_for_fault_, true)) device_.cut();
    return;
  }
  if (!is_cut() && !is_cut_for_fault_) return;
  is_cut_for_fault_ = false;
  is_cut_by_process_.store(false, std::memory_order_release);
  if (heartbeat_page_ != nullptr) heartbeat_page_->is_cut.store(0, std::memory_order_release);
  device_.restore();  // last: the flag of a cut that comes meanwhile stays set, so a later cycle restores the device
}

void DeviceLoop::set_force_sample(std::int64_t sample_ns) noexcept {
  force_sample_ns_.store(sample_ns, std::memory_order_release);
  if (heartbeat_page_ != nullptr) heartbeat_page_->force_sample_ns.store(sample_ns, std::memory_order_release);
}

// A thread without the claim cannot write a force, but it can cut the device: that is atomic and needs no claim.
bool DeviceLoop::cut_if_older(std::int64_t limit_ns) noexcept {
  const std::int64_t sample_ns = force_sample_ns();
  if (sample_ns == 0 || clock_.now_ns() - sample_ns < limit_ns) return false;
  const bool is_off = device_.cut();
  if (!is_cut_by_process_.exchange(true) && is_off) cuts_.fetch_add(1, std::memory_order_relaxed);
  return is_off;
}

void DeviceLoop::sample_device() noexcept {
  const std::int64_t begin_ns = clock_.now_ns();
  cycle_.tick_ns = tick_ns_;
  cycle_.sample = device_.read(begin_ns);
  // The time of a sample is the time at which the device returned it; how long the read took is measured separately.
  cycle_.sample.time_ns = clock_.now_ns();
  stats_.device_read.record(cycle_.sample.time_ns - begin_ns);
  device_call_ns_.fetch_add(cycle_.sample.time_ns - begin_ns, std::memory_order_relaxed);
  const DeviceStatus status = device_.status();
  status_.store(status, std::memory_order_release);
  // The governor protects the hardware, so it gets the true position. All others get the position shifted by the clutch.
  governor_.observe(cycle_.sample, status);
  cycle_.sample = clutch_.move(cycle_.sample);
  cycle_.number = ++stats_.samples;
}

// Without a new command the governor may still have to ramp the force. If a command comes in every cycle, the governor must not run between
// two of them: it would use up the cycle's share of the slew limit.
void DeviceLoop::hold_force() noexcept {
  const Wrench& held = governor_.step(std::nullopt, clock_.now_ns());
  if (held.force_n != written_.force_n || held.torque_nm != written_.torque_nm) write(held);
}

void DeviceLoop::write(const Wrench& wrench) noexcept {
  const std::int64_t begin_ns = clock_.now_ns();
  const bool is_zero = wrench.force_n == Vec3::Zero();
  // force_sample_ns is set before a force is written, and cleared after zero is written: an interruption in between errs on the safe side.
  const bool is_off = is_zero && wrench.torque_nm == Vec3::Zero();
  if (!is_off) set_force_sample(accepted_sample_ns_);
  device_.write(wrench, begin_ns);
  if (is_off) set_force_sample(0);
  device_call_ns_.fetch_add(clock_.now_ns() - begin_ns, std::memory_order_relaxed);
  const bool is_released = !is_finished_ && is_zero && written_.force_n != Vec3::Zero() && governor_.has_timed_out();
  if (is_released) stats_.longest_release_ns = std::max(stats_.longest_release_ns, begin_ns - accepted_sample_ns_);
  written_ = wrench;
  stats_.max_force_n = std::max(stats_.max_force_n, wrench.force_n.norm());
  stats_.max_torque_nm = std::max(stats_.max_torque_nm, wrench.torque_nm.norm());
}

void DeviceLoop::apply_requests() noexcept {
  const std::int64_t now_ns = clock_.now_ns();
  if (now_ns >= next_temperature_check_ns_) {
    next_temperature_check_ns_ = now_ns + kTemperatureCheckNs;
    governor_.observe_temperature(device_.condition().motor_temperature);
  }
  if (!request_mailbox_.take()) return;
  const Requests& requests = request_mailbox_.value();
  if (requests.rate_hz > 0.0) stats_.rate_hz = requests.rate_hz;
  if (std::exchange(hand_target_serial_, requests.hand_target_serial) != requests.hand_target_serial) {
    device_.set_hand_target(requests.p_WH ? std::optional<Vec3>(*requests.p_WH - clutch_.offset_m()) : std::nullopt);
    device_.press_hand_buttons(requests.p_WH ? requests.buttons : 0);
    device_.turn_hand(requests.p_WH ? requests.turn_rad : Vec3(Vec3::Zero()));
  }
  if (std::exchange(aim_serial_, requests.aim_serial) != requests.aim_serial) {
    std::array<Vec3, Device::kMaxAims> aims = requests.p_WA;
    for (Vec3& aim : aims) aim -= clutch_.offset_m();
    device_.aim_hand(std::span(aims).first(requests.aim_count));
  }
  const bool is_reset = std::exchange(reset_serial_, requests.reset_serial) != requests.reset_serial;
  const bool is_reset_if_held = std::exchange(reset_if_held_serial_, requests.reset_if_held_serial) != requests.reset_if_held_serial;
  if (is_reset || (is_reset_if_held && governor_.is_switch_held())) {
    governor_.reset_faults();
  } else if (is_reset_if_held) {
    ++stats_.resets_denied;
  }
  if (requests.ends && !std::exchange(is_finished_, true)) stats_.governor = governor_.stats();
  if (std::exchange(stats_serial_, requests.stats_serial) != requests.stats_serial) stats_copies_.publish(collect_stats());
}

const DeviceLoopStats& DeviceLoop::collect_stats() noexcept {
  stats_.status = device_.status();
  stats_.cuts = cuts_.load(std::memory_order_relaxed);
  stats_.condition = device_.condition();
  // The command timeout at the end of a session is intended and not counted.
  if (!is_finished_) stats_.governor = governor_.stats();
  return stats_;
}

// Repeats while a command is waiting: a thread that finds the claim taken leaves its command to the holder of the claim, which checks again
// after it has released the claim.
void DeviceLoop::serve() noexcept {
  while (served_.load() < posted_.load()) {
    if (!claim()) return;
    if (commands_.take()) serve_command(commands_.value());
    served_.store(commands_.value().number);
    publish_side();
    release_claim();
  }
}

void DeviceLoop::serve_command(const Command& command) noexcept {
  command_number_ = command.number;
  if (is_local_) {
    ++stats_.commands_unused;
    return;
  }
  WrenchCommand wrench_command = command.wrench_command;
  const std::int64_t now_ns = clock_.now_ns();
  if (local_touch_ != nullptr)
    wrench_command.wrench.force_n = fade_force(wrench_command.wrench.force_n, wrench_command.wrench.force_n != Vec3::Zero(), false, now_ns);
  govern(wrench_command, now_ns);
  command_ready_ns_ = force_ready_ns_;
  command_written_ns_ = force_written_ns_;
  ++stats_.commands;
}

void DeviceLoop::govern(const WrenchCommand& wrench_command, std::int64_t now_ns) noexcept {
  const std::uint64_t accepted = governor_.counters().accepted;
  WrenchCommand scaled = wrench_command;
  if (clutch_.force_factor() < 1.0)
    scaled.wrench = {clutch_.force_factor() * wrench_command.wrench.force_n, clutch_.force_factor() * wrench_command.wrench.torque_nm};
  governor_.step(scaled, now_ns);
  force_ready_ns_ = clock_.now_ns();
  if (governor_.counters().accepted != accepted) accepted_sample_ns_ = wrench_command.sample_time_ns;
  write(governor_.output());
  force_written_ns_ = clock_.now_ns();
}

void DeviceLoop::step_locally() noexcept {
  cycle_.local = local_touch_->step(cycle_.sample);
  const bool was_local = std::exchange(is_local_, cycle_.local.has_value());
  if (was_local && !cycle_.local) fade_.begin();
  if (!cycle_.local) return;
  const LocalForce& local = *cycle_.local;
  fade_.begin_from(local.difference_n);
  const Vec3 force_n = fade_force(local.force_n, local.contact, local.is_handed_over || !was_local, cycle_.sample.time_ns);
  govern({{.force_n = force_n}, cycle_.sample.time_ns}, clock_.now_ns());
  ++stats_.local_forces;
}

// When the source of the force changes, fades the difference between the two forces. After a released force there is nothing to fade.
Vec3 DeviceLoop::fade_force(const Vec3& force_n, bool contact, bool is_new_source, std::int64_t now_ns) noexcept {
  const std::int64_t passed_ns = now_ns - std::exchange(last_fade_ns_, now_ns);
  if (passed_ns >= kCommandTimeoutNs) fade_.forget();
  if (is_new_source) fade_.begin();
  return fade_.step(force_n, contact, 1e-9 * static_cast<double>(std::max<std::int64_t>(passed_ns, 1)));
}

void DeviceLoop::publish_side() noexcept {
  DeviceSide& side = sides_.draft();
  side.written = written_;
  side.status = status();
  side.governor = governor_.stats();
  side.has_timed_out = governor_.has_timed_out();
  side.is_energy_gone = governor_.is_energy_gone();
  side.is_switch_held = governor_.is_switch_held();
  side.has_overrun = has_overrun();
  side.command_number = command_number_;
  side.ready_ns = command_ready_ns_;
  side.written_ns = command_written_ns_;
  sides_.publish_draft();
}

bool DeviceLoop::hold() noexcept {
  if (!claim()) {
    (void)cut_if_older(kCommandTimeoutNs);
    return false;
  }
  status_.store(device_.status(), std::memory_order_release);
  apply_requests();
  hold_force();
  publish_side();
  release_claim();
  return true;
}

bool DeviceLoop::finish() noexcept {
  if (!claim()) {
    (void)cut_if_older(kCommandTimeoutNs);
    return false;
  }
  write({});
  publish_side();
  release_claim();
  return true;
}

bool DeviceLoop::take_cycle(DeviceCycle& cycle) noexcept {
  const std::size_t begin = cycles_begin_.load(std::memory_order_relaxed);
  if (begin == cycles_end_.load(std::memory_order_acquire)) return false;
  cycle = cycles_[begin % kMaxQueuedCycles];
  cycles_begin_.store(begin + 1, std::memory_order_release);
  return true;
}

std::uint64_t DeviceLoop::post(const WrenchCommand& wrench_command) noexcept {
  const std::uint64_t number = posted_.load(std::memory_order_relaxed) + 1;
  commands_.publish({wrench_command, number});
  posted_.store(number);
  serve();
  return number;
}

void DeviceLoop::set_hand_target(const std::optional<Vec3>& p_WH, std::uint32_t buttons, const Vec3& turn_rad) noexcept {
  requests_.p_WH = p_WH;
  requests_.buttons = buttons;
  requests_.turn_rad = turn_rad;
  ++requests_.hand_target_serial;
  request_mailbox_.publish(requests_);
}

void DeviceLoop::aim_hand(std::span<const Vec3> p_WA) noexcept {
  requests_.aim_count = std::min(p_WA.size(), requests_.p_WA.size());
  std::copy_n(p_WA.begin(), requests_.aim_count, requests_.p_WA.begin());
  ++requests_.aim_serial;
  request_mailbox_.publish(requests_);
}

void DeviceLoop::reset_faults(ResetPresence presence) noexcept {
  ++(presence == ResetPresence::known ? requests_.reset_serial : requests_.reset_if_held_serial);
  request_mailbox_.publish(requests_);
}

void DeviceLoop::set_rate_hz(double rate_hz) noexcept {
  requests_.rate_hz = rate_hz;
  request_mailbox_.publish(requests_);
}

void DeviceLoop::end() noexcept {
  requests_.ends = true;
  request_mailbox_.publish(requests_);
}

void DeviceLoop::request_stats() noexcept {
  ++requests_.stats_serial;
  request_mailbox_.publish(requests_);
}

}  // namespace hapton
