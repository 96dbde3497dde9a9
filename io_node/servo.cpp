#include "io_node/servo.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "io_node/safety/reset_right.h"
#include "io_node/session_fault_of.h"
#include "link/link_key.h"

namespace hapton {
namespace {

constexpr std::int64_t kViewRepeatNs = 250 * kNanosecondsPerMillisecond;  // a lost transform is mended so soon
constexpr std::int64_t kFiguresNs = 250 * kNanosecondsPerMillisecond;     // as often as a person reads them
constexpr std::int64_t kStatusNs = 100 * kNanosecondsPerMillisecond;      // a device is away for so long before it is told
// Tells the CPU that this thread only waits.
void relax() noexcept {
#ifdef __x86_64__
  __builtin_ia32_pause();
#endif
}

constexpr int kMostPolls = 32;  // datagrams taken in a cycle that is late already

}  // namespace

Servo::Servo(Device& device, HubPeers& peers, const Clock& clock, const Options& options, EchoProbe* echo, ServoTap* tap)
    : device_(device),
      peers_(peers),
      clock_(clock),
      echo_(echo),
      tap_(tap),
      policy_(options.overrun),
      governor_(device.limits()),
      pace_(options.vision_rate_hz),
      spin_(options.spin_share) {
  governor_.tighten(options.tighter);
  governor_.require_button(options.hold_button);
  stats_.rate_hz = options.rate_hz;
  peers_.set_tap(tap_);
  start();
}

std::int64_t Servo::period_ns() const noexcept { return std::llround(1e9 / stats_.rate_hz); }

void Servo::start() noexcept {
  tick_ns_ = clock_.now_ns() + period_ns();
  stats_.start_ns = stats_.end_ns = tick_ns_;
  next_view_repeat_ns_ = tick_ns_;
  figures_since_ns_ = status_since_ns_ = stats_.start_ns;
  next_figures_ns_ = stats_.start_ns + kFiguresNs;
}

void Servo::step() noexcept {
  is_behind_ = clock_.now_ns() >= tick_ns_;
  if (is_behind_) drain();
  wait_for_tick();
  begin_cycle();
  sample_device();
  const std::int64_t period = period_ns();
  const std::int64_t middle_ns = tick_ns_ + period / 2;
  await_force(middle_ns);
  do_spare_work();
  if (echo_ != nullptr && (ledger_.is_newest_answered() || !peers_.has_haptics())) {
    receive_until(middle_ns);
    const std::int64_t end_ns = tick_ns_ + period - period / 8;
    echo_->probe(end_ns);
    note_waited(end_ns, clock_.now_ns());
  }
  tick_ns_ += period_ns();
}

// Sleeps in the socket until shortly before the tick, then spins: no sleep ends to the microsecond.
void Servo::wait_for_tick() noexcept {
  const std::int64_t wake_ns = tick_ns_ - spin_.margin_ns(period_ns());
  std::int64_t now_ns = clock_.now_ns();
  if (now_ns < wake_ns) {
    receive_until(wake_ns);
    now_ns = clock_.now_ns();
    spin_.note_wake_up(now_ns - wake_ns);
  }
  const std::int64_t begin_ns = now_ns;
  for (; now_ns < tick_ns_; now_ns = clock_.now_ns()) relax();
  spin_.note_spun(now_ns - begin_ns);
}

void Servo::begin_cycle() noexcept {
  const std::int64_t late_ns = clock_.now_ns() - tick_ns_;
  const std::int64_t period = period_ns();
  stats_.wake_lateness.record(late_ns);
  cycle_.late_ns = late_ns;
  // A period changed while waiting may put the tick into the future: then this cycle is simply early.
  if (late_ns >= period) {
    overrun(late_ns);
  } else {
    cycle_.missed = 0;
    cycle_.cause = MissCause::none;
  }
  device_ns_ = 0;
  overslept_ns_ = 0;
  stats_.end_ns = tick_ns_ + period;
}

// One cycle or more is missed.
void Servo::overrun(std::int64_t late_ns) noexcept {
  const bool is_catching_up = policy_ == OverrunPolicy::catch_up && cycle_.cause != MissCause::none;
  if (!is_catching_up) cycle_.cause = cause_of(late_ns);
  const std::int64_t missed = late_ns / period_ns();
  const std::int64_t kept = policy_ == OverrunPolicy::catch_up ? std::min(missed, kMostCaughtUp) : 0;
  tick_ns_ += (missed - kept) * period_ns();
  cycle_.missed = static_cast<std::uint32_t>(missed - kept);
  stats_.missed_cycles += static_cast<std::uint64_t>(missed - kept);
  stats_.caught_up_cycles += kept > 0 ? 1 : 0;
  stats_.missed_by_cause[static_cast<std::size_t>(cycle_.cause)] += static_cast<std::uint64_t>(missed - kept) + (kept > 0 ? 1 : 0);
  has_overrun_ = has_overrun_ || policy_ == OverrunPolicy::stop;
}

// By the clock readings of the cycle before alone: nothing is asked of the system.
MissCause Servo::cause_of(std::int64_t late_ns) const noexcept {
  if (device_ns_ > period_ns() / 2) return MissCause::device_slow;
  if (late_ns >= kStallNs) return MissCause::machine_stalled;
  return is_behind_ && overslept_ns_ <= period_ns() / 2 ? MissCause::work_long : MissCause::late_wake_up;
}

void Servo::sample_device() noexcept {
  const std::int64_t begin_ns = clock_.now_ns();
  sample_ = device_.read(begin_ns);
  // A sample is taken when the device has given it; how long that takes is a figure of its own.
  sample_.time_ns = clock_.now_ns();
  stats_.device_read.record(sample_.time_ns - begin_ns);
  device_ns_ += sample_.time_ns - begin_ns;
  governor_.observe(sample_, device_.status());
  ++sample_number_;
  ++stats_.samples;
  const bool is_expected =
      haptics_alive(sample_.time_ns) && sample_.time_ns - peers_.peer(HubPeers::kHapticsPlace).joined_ns >= SampleLedger::kWarmUpNs;
  ledger_.take(sample_number_, sample_.time_ns, is_expected);
  poses_[sample_number_ % poses_.size()] = {sample_.time_ns, sample_.p_WD, sample_.q_WT};
  DeviceState state{sample_number_, sample_.time_ns, sample_.p_WD, sample_.q_WT, sample_.buttons};
  state.is_resumed = is_haptics_new_ && p_WP_ && (*p_WP_ - sample_.p_WD).norm() <= kResumeReachM;
  if (state.is_resumed) state.p_WP = *p_WP_;
  const std::size_t reached = peers_.send_to_role(NodeRole::haptics, state);
  stats_.states_sent += reached;
  if (ways_ != nullptr && reached > 0) ways_->on_state_sent(sample_number_, sample_.time_ns);
  if (!std::exchange(is_force_new_, false)) hold_force();
}

// Without news the governor may still have to let the force sink or rise. With news every cycle it must not be asked in between: it would
// spend the cycle's share of the slew on nothing.
void Servo::hold_force() noexcept {
  const Wrench& held = governor_.step(std::nullopt, clock_.now_ns());
  if (held.force_n != written_.force_n || held.torque_nm != written_.torque_nm) write(held);
}

// A node that has not been heard for so long gives up its place to the first who asks: it counts as gone.
bool Servo::haptics_alive(std::int64_t now_ns) const noexcept {
  return peers_.has_haptics() && now_ns - peers_.peer(HubPeers::kHapticsPlace).last_heard_ns < HubPeers::kHapticsSilenceNs;
}

void Servo::write(const Wrench& wrench) noexcept {
  const std::int64_t begin_ns = clock_.now_ns();
  device_.write(wrench, begin_ns);
  device_ns_ += clock_.now_ns() - begin_ns;
  const bool is_let_go = !is_finished_ && wrench.force_n == Vec3::Zero() && written_.force_n != Vec3::Zero() && governor_.is_silent();
  if (is_let_go) stats_.longest_release_ns = std::max(stats_.longest_release_ns, begin_ns - accepted_ns_);
  written_ = wrench;
  stats_.max_force_n = std::max(stats_.max_force_n, wrench.force_n.norm());
}

void Servo::receive_one(std::int64_t deadline_ns) noexcept {
  const PeerEvent event = peers_.receive(incoming_, deadline_ns);
  if (event.kind != PeerEvent::Kind::none) hear(event, incoming_);
}

void Servo::receive_until(std::int64_t deadline_ns) noexcept {
  std::int64_t now_ns = clock_.now_ns();
  if (now_ns >= deadline_ns) return;
  for (; now_ns < deadline_ns; now_ns = clock_.now_ns()) receive_one(deadline_ns);
  note_waited(deadline_ns, now_ns);
}

void Servo::note_waited(std::int64_t deadline_ns, std::int64_t woke_ns) noexcept {
  overslept_ns_ = std::max(overslept_ns_, woke_ns - deadline_ns);
}

// A loop too late to wait still hears what has come; not without end, or strangers could hold it up.
void Servo::drain() noexcept {
  for (int polls = 0; polls < kMostPolls; ++polls) {
    const std::uint64_t before = peers_.counts().received;
    receive_one(0);
    if (peers_.counts().received == before) return;
  }
}

void Servo::await_force(std::int64_t deadline_ns) noexcept {
  while (!ledger_.is_newest_answered() && peers_.has_haptics()) {
    const std::int64_t now_ns = clock_.now_ns();
    if (now_ns >= deadline_ns) return note_waited(deadline_ns, now_ns);
    receive_one(deadline_ns);
  }
}

void Servo::hear(const PeerEvent& event, const Datagram& datagram) noexcept {
  switch (event.kind) {
    case PeerEvent::Kind::none:
      return;
    case PeerEvent::Kind::message:
      return hear_message(event, datagram);
    case PeerEvent::Kind::joined:
      return on_joined(event);
    case PeerEvent::Kind::left:
      return on_left(event);
    case PeerEvent::Kind::refused:
      return tell(ServoEvent::Kind::refused, event.role, {});
  }
}

void Servo::hear_message(const PeerEvent& event, const Datagram& datagram) noexcept {
  if (const auto* force = std::get_if<ForceCommand>(&datagram.message)) return on_force(*force);
  // Of these the newest wins; an overtaken one says what is no longer so.
  if (event.arrival != Arrival::newest) return;
  if (const auto* view = std::get_if<ViewTransform>(&datagram.message)) return on_view(*view);
  if (const auto* drawn = std::get_if<Drawn>(&datagram.message)) return on_drawn(*drawn, event.peer);
  if (const auto* hand = std::get_if<HandTarget>(&datagram.message)) return on_hand(*hand, event.peer);
  if (const auto* settings = std::get_if<Settings>(&datagram.message)) return on_settings(*settings, event);
  if (std::holds_alternative<HapticsSetup>(datagram.message)) peers_.send_to_role(NodeRole::tool, datagram.message);
  if (const auto* ask = std::get_if<ReportAsk>(&datagram.message); ask != nullptr && desk_ != nullptr) desk_->ask(event.peer, *ask);
}

void Servo::on_force(const ForceCommand& command) noexcept {
  const SampleLedger::Verdict verdict = ledger_.answer(command);
  if (verdict == SampleLedger::Verdict::duplicate || verdict == SampleLedger::Verdict::unknown) return;
  const bool is_newest = verdict != SampleLedger::Verdict::reordered;
  if (is_newest) governor_.step(WantedWrench{{.force_n = command.force_n}, command.echo_sample_time_ns}, clock_.now_ns());
  const std::int64_t ready_ns = clock_.now_ns();
  const std::int64_t round_trip_ns = ready_ns - command.echo_sample_time_ns;
  if (is_newest) {
    if (!governor_.is_silent()) accepted_ns_ = ready_ns;
    write(governor_.output());
    is_force_new_ = true;
    const std::int64_t written_ns = clock_.now_ns();
    stats_.force_age.record(written_ns - command.echo_sample_time_ns);
    if (ways_ != nullptr) ways_->on_force_written(ready_ns, written_ns);
    last_force_ = command;
    remember_probe(command);
  }
  if (ways_ != nullptr) ways_->on_force(incoming_.header, command, ready_ns);
  stats_.round_trip.record(round_trip_ns);
  stats_.haptics_compute.record(command.compute_ns);
  stats_.wire.record(round_trip_ns - static_cast<std::int64_t>(command.compute_ns));
  ++stats_.forces;
  stats_.contact_samples += command.contact ? 1 : 0;
}

// So that a haptics node that comes in its stead can go on from there.
void Servo::remember_probe(const ForceCommand& command) noexcept {
  is_haptics_new_ = false;
  const bool is_known = command.contact && is_pose_known(command.echo_sample);
  p_WP_ = is_known ? std::optional<Vec3>(poses_[command.echo_sample % poses_.size()].p_WD + command.visual_offset_m) : std::nullopt;
}

void Servo::on_view(const ViewTransform& view) noexcept {
  if (!view_ || view_->revision != view.revision) p_WP_.reset();
  view_ = view;
  stats_.views_forwarded += peers_.send_to_role(NodeRole::haptics, view);
  next_view_repeat_ns_ = clock_.now_ns() + kViewRepeatNs;
}

void Servo::on_drawn(const Drawn& drawn, std::size_t peer) noexcept {
  const std::int64_t age_ns = clock_.now_ns() - drawn.echo_sample_time_ns;
  const bool is_ours =
      drawn.echo_sample != 0 && drawn.echo_sample <= sample_number_ && age_ns >= 0 && drawn.echo_sample_time_ns >= stats_.start_ns;
  if (!is_ours) return;
  pace_.on_drawn(peer, drawn, clock_.now_ns());
  if (drawn.unchanged) return;
  ++stats_.drawn;
  stats_.device_to_drawn.record(age_ns);
  if (ways_ != nullptr) ways_->on_drawn(incoming_.header, drawn, peer);
  stats_.frame_rate_hz = static_cast<double>(drawn.frame_rate_hz);
}

void Servo::on_hand(const HandTarget& hand, std::size_t peer) noexcept {
  if (!hand.active && hand_leader_ != peer) return;
  hand_leader_ = hand.active ? peer : kNobody;
  device_.lead_hand(hand.active ? std::optional(hand.p_WH) : std::nullopt);
}

void Servo::on_settings(const Settings& settings, const PeerEvent& event) noexcept {
  const NodeRole role = event.role;
  if (settings.servo_rate_hz >= kLowestRateHz && settings.servo_rate_hz <= kHighestRateHz) {
    stats_.rate_hz = settings.servo_rate_hz;
    peers_.set_servo_rate_hz(settings.servo_rate_hz);
    events_.push({ServoEvent::Kind::rate_changed, role, {}, settings.servo_rate_hz, {}, {}});
  } else if (settings.servo_rate_hz != 0.0) {
    ++stats_.bad_settings;
  }
  if (settings.method[0] != '\0') {
    peers_.send_to_role(NodeRole::haptics, Settings{0.0, settings.method, false, false, settings.method_ask});
    events_.push({ServoEvent::Kind::method_asked, role, {}, 0.0, settings.method, {}});
  }
  if (settings.reset_faults && role == NodeRole::tool) reset_faults(peers_.peer(event.peer));
  if (settings.report_now) report_wished_.store(true, std::memory_order_release);
}

void Servo::reset_faults(const Peer& asker) noexcept {
  const SafetyFault fault = governor_.fault();
  if (fault == SafetyFault::none) return;
  const ResetVerdict verdict = judge_reset(asker.key_role, is_loopback(asker.address), governor_.is_switch_held());
  if (verdict != ResetVerdict::granted) {
    ++stats_.resets_denied;
    if (clock_.now_ns() < next_denial_ns_) return;
    next_denial_ns_ = clock_.now_ns() + kNanosecondsPerSecond;
    const bool lacks_right = verdict == ResetVerdict::no_right;
    return tell(lacks_right ? ServoEvent::Kind::reset_without_right : ServoEvent::Kind::reset_without_person, asker.role, asker.address);
  }
  const auto kind = governor_.reset_faults() ? ServoEvent::Kind::reset : ServoEvent::Kind::reset_refused;
  events_.push({kind, NodeRole::tool, {}, 0.0, {}, fault});
}

void Servo::on_joined(const PeerEvent& event) noexcept {
  tell(ServoEvent::Kind::joined, event.role, peers_.peer(event.peer).address);
  if (ways_ != nullptr) ways_->on_joined(event.peer, peers_.peer(event.peer).address);
  if (event.peer == hand_leader_) on_hand({}, event.peer);
  pace_.on_joined(event.peer);
  if (event.role != NodeRole::haptics) return;
  is_haptics_new_ = true;
  ledger_.excuse_waiting();
  if (!view_) return;
  stats_.views_forwarded += peers_.send_to(event.peer, *view_) ? 1 : 0;
  next_view_repeat_ns_ = clock_.now_ns() + kViewRepeatNs;
}

void Servo::on_left(const PeerEvent& event) noexcept {
  tell(ServoEvent::Kind::left, event.role, peers_.peer(event.peer).address);
  if (event.peer == hand_leader_) on_hand({}, event.peer);
  if (event.role == NodeRole::haptics) ledger_.excuse_waiting();
}

void Servo::tell(ServoEvent::Kind kind, NodeRole role, const Address& address) noexcept {
  events_.push({kind, role, address, 0.0, {}, {}});
}

// Once a cycle, when the force path is done.
void Servo::do_spare_work() noexcept {
  const std::int64_t now_ns = clock_.now_ns();
  ledger_.settle(now_ns);
  if (peers_.count(NodeRole::vision) > 0) tell_vision(now_ns);
  if (view_ && now_ns >= next_view_repeat_ns_) {
    next_view_repeat_ns_ = now_ns + kViewRepeatNs;
    peers_.send_to_role(NodeRole::haptics, *view_);
  }
  if (now_ns >= next_figures_ns_) {
    refresh_figures(now_ns);
    tell_of_strangers(now_ns);
  }
  if (desk_ != nullptr) desk_->serve(peers_);
  tell_of_safety(now_ns);
  if (snapshot_asked_.exchange(false, std::memory_order_acq_rel)) snapshots_.publish(collect_stats());
}

void Servo::tell_tap(std::int64_t now_ns) noexcept {
  cycle_.sample = sample_number_;
  cycle_.written_n = written_.force_n;
  tap_->on_cycle(cycle_, now_ns);
  const GovernorCounters& governor = governor_.counters();
  // A node that has said goodbye is no fault.
  const bool is_missed = last_force_.contact && peers_.has_haptics();
  tell_fault(SessionFault::silence, governor.silences > governor_told_.silences && is_missed, now_ns);
  tell_fault(SessionFault::not_finite, governor.not_finite > governor_told_.not_finite, now_ns);
  tell_fault(SessionFault::refused_future, governor.refused_future > governor_told_.refused_future, now_ns);
  tell_fault(SessionFault::clamped, governor.clamped > governor_told_.clamped, now_ns);
  tell_fault(SessionFault::stalled, cycle_.late_ns >= kSilenceLimitNs, now_ns);
  tell_fault(SessionFault::overrun, has_overrun_, now_ns);
  tell_fault(SessionFault::energy, governor_.is_energy_gone(), now_ns);
  if (governor.latched > governor_told_.latched) tap_->on_fault(session_fault_of(governor_.fault()), now_ns);
}

// People first: they may have to do something about it.
void Servo::tell_of_safety(std::int64_t now_ns) noexcept {
  if (governor_.counters().latched > governor_told_.latched) events_.push({ServoEvent::Kind::latched, {}, {}, 0.0, {}, governor_.fault()});
  const DeviceStatus status = device_.status();
  if (status == status_told_) status_since_ns_ = now_ns;
  if (now_ns - status_since_ns_ >= kStatusNs) {
    if (status == DeviceStatus::away) tell(ServoEvent::Kind::away, NodeRole::io, {});
    if (status == DeviceStatus::calibrating) tell(ServoEvent::Kind::calibrating, NodeRole::io, {});
    if (status == DeviceStatus::ready) tell(ServoEvent::Kind::back, NodeRole::io, {});
    status_told_ = status;
  }
  if (tap_ != nullptr) tell_tap(now_ns);
  governor_told_ = governor_.counters();
}

// Once when it begins: a force that stays above the limit is one fault.
void Servo::tell_fault(SessionFault fault, bool is_there, std::int64_t now_ns) noexcept {
  const std::uint32_t bit = std::uint32_t{1} << static_cast<unsigned>(fault);
  if (is_there && (faults_ & bit) == 0) tap_->on_fault(fault, now_ns);
  faults_ = is_there ? faults_ | bit : faults_ & ~bit;
}

bool Servo::is_pose_known(std::uint64_t sample) const noexcept { return sample != 0 && sample_number_ - sample < poses_.size(); }

// Pose and visual offset are one sample's: the newest that was answered. An older answer's offset beside the newest pose would draw the
// probe beside the surface by what the device moved meanwhile. While nobody answers it is the newest sample, as it is.
void Servo::fill_probe() noexcept {
  const bool is_live = !governor_.is_silent() && is_pose_known(last_force_.echo_sample);
  const std::uint64_t shown = is_live ? last_force_.echo_sample : sample_number_;
  if (shown >= probe_.sample) {  // an answer to a sample before the silence comes too late for the picture
    const Pose& pose = poses_[shown % poses_.size()];
    probe_.sample = shown;
    probe_.sample_time_ns = pose.time_ns;
    probe_.p_WD = pose.p_WD;
    probe_.q_WT = pose.q_WT;
    probe_.contact = is_live && last_force_.contact;
    probe_.visual_offset_m = is_live ? last_force_.visual_offset_m : Vec3(Vec3::Zero());
  }
  probe_.buttons = sample_.buttons;
  probe_.force_n = written_.force_n;
  probe_.view_revision = view_ ? view_->revision : 0;
}

void Servo::tell_vision(std::int64_t now_ns) noexcept {
  fill_probe();
  std::size_t reached = 0;
  for (std::size_t place = 0; place < HubPeers::kCapacity; ++place) {
    const Peer& peer = peers_.peer(place);
    if (!peer.present || peer.role != NodeRole::vision) continue;
    const VisionPace::Verdict verdict = pace_.judge(place, probe_, now_ns);
    stats_.probe_states_spared += verdict == VisionPace::Verdict::spare ? 1 : 0;
    if (verdict == VisionPace::Verdict::send) reached += peers_.send_to(place, probe_) ? 1 : 0;
  }
  stats_.probe_states_sent += reached;
  if (ways_ != nullptr && reached > 0) ways_->on_probe_sent(probe_.sample);
}

void Servo::refresh_figures(std::int64_t now_ns) noexcept {
  next_figures_ns_ = now_ns + kFiguresNs;
  const double passed_s = 1e-9 * static_cast<double>(now_ns - figures_since_ns_);
  if (passed_s > 0.0) probe_.servo_rate_hz = static_cast<float>(static_cast<double>(stats_.samples - figures_samples_) / passed_s);
  figures_since_ns_ = now_ns;
  figures_samples_ = stats_.samples;
  governor_.observe_temperature(device_.condition().motor_temperature);
  probe_.round_trip_p50_us = static_cast<float>(1e-3 * stats_.round_trip.quantile_ns(0.5));
  probe_.round_trip_p99_us = static_cast<float>(1e-3 * stats_.round_trip.quantile_ns(0.99));
}

// Who lacks the key is told nothing; the person at the hub is, now and then.
void Servo::tell_of_strangers(std::int64_t now_ns) noexcept {
  if (const auto flood = peers_.take_flood(now_ns)) {
    ServoEvent event{ServoEvent::Kind::flood, NodeRole::tool, flood->from, flood->per_second, {}, {}};
    event.flood = flood->refusal;
    event.is_from_several = flood->is_from_several;
    events_.push(event);
  }
  strangers_.look(peers_.seal_counts(), peers_.counts(), now_ns, [&](ServoEvent::Kind kind) { tell(kind, NodeRole::tool, {}); });
}

void Servo::finish() noexcept {
  constexpr std::int64_t kStepNs = kNanosecondsPerMillisecond;
  stats_.governor = governor_.figures();
  is_finished_ = true;
  if (tap_ != nullptr && device_.status() == DeviceStatus::fault) tap_->on_fault(SessionFault::device, clock_.now_ns());
  const std::int64_t end_ns = clock_.now_ns() + kSilenceLimitNs + 2 * kStepNs;
  for (std::int64_t now_ns = clock_.now_ns(); now_ns < end_ns; now_ns = clock_.now_ns()) {
    receive_until(now_ns + kStepNs);
    hold_force();
  }
  write({});
  ledger_.close(haptics_alive(sample_.time_ns));
}

const ServoStats& Servo::collect_stats() noexcept {
  stats_.device_status = device_.status();
  stats_.device = device_.condition();
  stats_.ledger = ledger_.counts();
  // The silence at the end is our own doing.
  if (!is_finished_) stats_.governor = governor_.figures();
  stats_.hub = peers_.counts();
  stats_.seal = peers_.seal_counts();
  stats_.events_dropped = events_.dropped();
  if (ways_ != nullptr) stats_.ways = ways_->collect(clock_.now_ns());
  for (std::size_t place = 0; place < HubPeers::kCapacity; ++place) {
    const Peer& peer = peers_.peer(place);
    stats_.peers[place] = {peer.present, peer.role, peer.address, peer.joined_ns, peer.sent, peer.send_failures, peer.tracker.counts()};
  }
  if (echo_ != nullptr) {
    stats_.bare_echo = echo_->round_trip();
    stats_.echo = echo_->counts();
  }
  return stats_;
}

}  // namespace hapton
