#include "io_node/servo.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "link/link_key.h"
#include "safety/reset_right.h"

namespace hapton {
namespace {

constexpr std::int64_t kViewRepeatNs = 250 * kNanosecondsPerMillisecond;  // a lost transform is mended so soon
constexpr std::int64_t kFiguresNs = 250 * kNanosecondsPerMillisecond;     // as often as a person reads them

// Tells the CPU that this thread only waits.
void relax() noexcept {
#ifdef __x86_64__
  __builtin_ia32_pause();
#endif
}

// Cycles in a row that found the next one there already: then this thread sleeps for a moment all the same. One that never does is ended by
// LimitRTTIME, and throttled.
constexpr std::uint32_t kMostBehind = 8;
constexpr int kMostPolls = 32;  // datagrams taken in a cycle that is late already

}  // namespace

Servo::Servo(Device& device, HubPeers& peers, const Clock& clock, const Options& options, EchoProbe* echo, ServoTap* tap)
    : loop_(device, clock,
            {.rate_hz = options.rate_hz,
             .tighter = options.tighter,
             .forbids_force = options.forbids_force,
             .hold_button = options.hold_button,
             .overrun = options.overrun,
             .spin_share = options.spin_share}),
      peers_(peers),
      clock_(clock),
      echo_(echo),
      tap_(tap),
      vision_(peers, stats_, options.vision_rate_hz),
      rate_hz_(options.rate_hz),
      safety_(events_, tap) {
  peers_.set_tap(tap_);
  start();
}

std::int64_t Servo::period_ns() const noexcept { return std::llround(1e9 / rate_hz_); }

void Servo::start() noexcept {
  if (!has_device_thread_) loop_.start();
  cycle_.next_wake_ns = cycle_.next_tick_ns = stats_.start_ns = clock_.now_ns() + period_ns();
  next_view_repeat_ns_ = stats_.start_ns;
  vision_.start(stats_.start_ns);
  safety_.start(stats_.start_ns);
  next_figures_ns_ = stats_.start_ns + kFiguresNs;
}

void Servo::step() noexcept {
  renew_budget();
  if (!has_device_thread_) run_device_cycle();
  if (has_device_thread_ && !await_cycle()) return;
  take_cycles();
  send_state();
  const std::int64_t period = cycle_.next_tick_ns - cycle_.tick_ns;
  const std::int64_t middle_ns = cycle_.tick_ns + period / 2;
  await_force(middle_ns);
  do_spare_work();
  if (echo_ != nullptr && (ledger_.is_newest_answered() || !peers_.has_haptics())) {
    receive_until(middle_ns);
    const std::int64_t end_ns = cycle_.tick_ns + period - period / 8;
    echo_->probe(end_ns);
    note_waited(end_ns, clock_.now_ns());
  }
  if (!has_device_thread_) return;
  // Here, where nobody waits: setting a timer is dear.
  peers_.prepare_wait(cycle_.next_wake_ns);
  peers_.prepare_wait(cycle_.next_tick_ns + period / 2);
}

void Servo::renew_budget() noexcept {
  if (budget_ == nullptr) return;
  budget_->renew(static_cast<std::uint32_t>(std::max(kDatagramsPerMs * period_ns() / kNanosecondsPerMillisecond, std::int64_t{32})));
}

// The device side in this thread. Sleeps in the socket until shortly before the tick, then the device side spins: no sleep ends to the
// microsecond.
void Servo::run_device_cycle() noexcept {
  const bool is_behind = clock_.now_ns() >= loop_.tick_ns();
  loop_.note_behind(is_behind);
  if (is_behind) drain();
  const std::int64_t wake_ns = loop_.wake_ns();
  if (clock_.now_ns() < wake_ns) {
    receive_until(wake_ns);
    loop_.note_wake_up(clock_.now_ns() - wake_ns);
  }
  loop_.begin_cycle();
  loop_.run_cycle();
}

// Until the device side has made a cycle; false: it is late, and meanwhile there is other work.
bool Servo::await_cycle() noexcept {
  if (loop_.has_cycle()) {
    drain();
    if (++cycles_behind_ % kMostBehind == 0 && budget_ != nullptr) budget_->rest();
    return true;
  }
  cycles_behind_ = 0;
  // The same moment at which the device side wakes: one interrupt ends both sleeps, before the tick and not in the midst of its sample.
  const std::int64_t wake_ns = cycle_.next_wake_ns;
  const std::int64_t now_ns = clock_.now_ns();
  receive_until(now_ns < wake_ns ? wake_ns : now_ns + kLongestSpinNs);
  const std::int64_t end_ns = std::max(cycle_.next_tick_ns, clock_.now_ns()) + kLongestSpinNs;
  while (!loop_.has_cycle() && clock_.now_ns() < end_ns) relax();
  return loop_.has_cycle();
}

// Up to the one that is newest now: it is sent, whatever the device side does meanwhile.
void Servo::take_cycles() noexcept {
  bool is_newest = false;
  while (!is_newest && loop_.take_cycle(cycle_)) {
    is_newest = !loop_.has_cycle();
    on_cycle(is_newest);
  }
}

// A sample that a newer one has overtaken before it was sent is answered by nobody.
void Servo::on_cycle(bool is_newest) noexcept {
  const DeviceSample& sample = cycle_.sample;
  if (is_newest) {
    const bool is_expected =
        haptics_alive(sample.time_ns) && sample.time_ns - peers_.peer(HubPeers::kHapticsPlace).joined_ns >= SampleLedger::kWarmUpNs;
    ledger_.take(cycle_.number, sample.time_ns, is_expected);
  } else {
    ledger_.withhold(cycle_.number, sample.time_ns);
  }
  probe_memory_.note_sample(cycle_.number, sample);
  if (!is_newest && tap_ != nullptr) safety_.note_cycle(loop_.look(), cycle_, sample.time_ns);
}

void Servo::send_state() noexcept {
  const DeviceSample& sample = cycle_.sample;
  DeviceState state{cycle_.number, sample.time_ns, sample.p_WD, sample.q_WT, sample.buttons};
  const std::optional<Vec3> p_WP = probe_memory_.find_resume_point(sample.p_WD);
  state.is_resumed = p_WP.has_value();
  if (p_WP) state.p_WP = *p_WP;
  const std::size_t reached = peers_.send_to_role(NodeRole::haptics, state);
  stats_.states_sent += reached;
  if (ways_ != nullptr && reached > 0) ways_->on_state_sent(cycle_.number, sample.time_ns);
}

// A node that has not been heard for so long gives up its place to the first who asks: it counts as gone.
bool Servo::haptics_alive(std::int64_t now_ns) const noexcept {
  return peers_.has_haptics() && now_ns - peers_.peer(HubPeers::kHapticsPlace).last_heard_ns < HubPeers::kHapticsSilenceNs;
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
  if (!has_device_thread_) loop_.note_overslept(woke_ns - deadline_ns);
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
      if (refusals_.is_news(event.role, event.receive_time_ns)) tell(ServoEvent::Kind::refused, event.role, {});
      return;
  }
}

void Servo::hear_message(const PeerEvent& event, const Datagram& datagram) noexcept {
  if (const auto* force = std::get_if<ForceCommand>(&datagram.message)) return on_force(*force);
  // Of these the newest wins; an overtaken one says what is no longer so.
  if (event.arrival != Arrival::newest) return;
  if (const auto* view = std::get_if<ViewTransform>(&datagram.message)) return on_view(*view);
  if (const auto* drawn = std::get_if<Drawn>(&datagram.message)) {
    return vision_.on_drawn(datagram.header, *drawn, event.peer, cycle_.number, clock_.now_ns());
  }
  if (const auto* hand = std::get_if<HandTarget>(&datagram.message)) return on_hand(*hand, event.peer);
  if (const auto* settings = std::get_if<Settings>(&datagram.message)) return on_settings(*settings, event);
  if (const auto* setup = std::get_if<HapticsSetup>(&datagram.message)) return on_setup(*setup);
  if (const auto* scene = std::get_if<SceneFacts>(&datagram.message)) return on_scene(*scene, event.role);
  if (const auto* ask = std::get_if<ReportAsk>(&datagram.message); ask != nullptr && desk_ != nullptr) desk_->ask(event.peer, *ask);
}

void Servo::on_force(const ForceCommand& command) noexcept {
  const SampleLedger::Verdict verdict = ledger_.answer(command);
  if (verdict == SampleLedger::Verdict::duplicate || verdict == SampleLedger::Verdict::unknown) return;
  const bool is_newest = verdict != SampleLedger::Verdict::reordered;
  if (is_newest) {
    note_written();
    posted_number_ = loop_.post({{.force_n = command.force_n}, command.echo_sample_time_ns});
    posted_ = command;
    note_written();
    probe_memory_.note_answer(command);
  } else {
    note_round_trip(command, clock_.now_ns());
  }
  ++stats_.forces;
  stats_.contact_samples += command.contact ? 1 : 0;
}

// The device side has governed and written the force that was posted last: as a rule it is so when post returns.
void Servo::note_written() noexcept {
  const DeviceSide& side = loop_.look();
  if (!posted_ || side.command != posted_number_) return;
  stats_.force_age.record(side.written_ns - posted_->echo_sample_time_ns);
  if (ways_ != nullptr) ways_->on_force_written(side.ready_ns, side.written_ns);
  note_round_trip(*posted_, side.ready_ns);
  posted_.reset();
}

void Servo::note_round_trip(const ForceCommand& command, std::int64_t ready_ns) noexcept {
  const std::int64_t round_trip_ns = ready_ns - command.echo_sample_time_ns;
  if (ways_ != nullptr) ways_->on_force(incoming_.header, command, ready_ns);
  stats_.round_trip.record(round_trip_ns);
  stats_.haptics_compute.record(command.compute_ns);
  stats_.wire.record(round_trip_ns - static_cast<std::int64_t>(command.compute_ns));
}

void Servo::on_view(const ViewTransform& view) noexcept {
  const bool is_news = !view_ || view_->revision != view.revision;
  if (is_news) probe_memory_.forget_rest();
  view_ = view;
  if (is_news) place_scene();
  stats_.views_forwarded += peers_.send_to_role(NodeRole::haptics, view);
  next_view_repeat_ns_ = clock_.now_ns() + kViewRepeatNs;
}

void Servo::on_setup(const HapticsSetup& setup) noexcept {
  stats_.setup = setup;
  peers_.send_to_role(NodeRole::tool, setup);
  peers_.send_to_role(NodeRole::vision, setup);  // it draws the probe as large as it is felt
}

// Each side hears of the other's, and compares.
void Servo::on_scene(const SceneFacts& scene, NodeRole role) noexcept {
  if (role != NodeRole::haptics) {
    peers_.send_to_role(NodeRole::haptics, scene);
    return;
  }
  peers_.send_to_role(NodeRole::vision, scene);
  const bool is_news = !scene_ || scene_->given_hash != scene.given_hash || scene_->points_m != scene.points_m;
  scene_ = scene;
  if (is_news) place_scene();
}

// Where it is now, as the hand and whoever wonders at feeling nothing are to know.
void Servo::place_scene() noexcept {
  if (!scene_) return;
  const Pose X_WS = view_ ? pose_of(*view_) : Pose(Pose::Identity());
  std::array<Vec3, SceneFacts::kMostPoints> p_WA;
  for (std::size_t i = 0; i < scene_->point_count; ++i) p_WA[i] = point_in_world(*scene_, X_WS, i);
  loop_.aim_hand(std::span(p_WA).first(scene_->point_count));
  const SceneReach before = std::exchange(reach_, judge_reach(*scene_, X_WS, limits()));
  stats_.reach = reach_;
  if (reach_ == before) return;
  if (reach_ == SceneReach::out_of_reach) tell(ServoEvent::Kind::out_of_reach, NodeRole::haptics, {});
  if (reach_ == SceneReach::too_small) tell(ServoEvent::Kind::too_small, NodeRole::haptics, {});
  const bool was_lost = before == SceneReach::out_of_reach || before == SceneReach::too_small;
  if (was_lost && reach_ == SceneReach::in_reach) tell(ServoEvent::Kind::in_reach, NodeRole::haptics, {});
}

ProbeStatus Servo::status_now() noexcept {
  const DeviceSide& side = loop_.look();
  if (side.governor.fault != SafetyFault::none) return ProbeStatus::fault_latched;
  if (side.status == DeviceStatus::away || side.status == DeviceStatus::fault) return ProbeStatus::device_away;
  if (side.status == DeviceStatus::calibrating) return ProbeStatus::calibrating;
  if (!peers_.has_haptics() || side.is_silent) return ProbeStatus::no_haptics;
  if (reach_ == SceneReach::out_of_reach) return ProbeStatus::out_of_reach;
  return reach_ == SceneReach::too_small ? ProbeStatus::too_small : ProbeStatus::ok;
}

void Servo::on_hand(const HandTarget& hand, std::size_t peer) noexcept {
  if (!hand.active && hand_leader_ != peer) return;
  hand_leader_ = hand.active ? peer : kNobody;
  loop_.lead_hand(hand.active ? std::optional(hand.p_WH) : std::nullopt);
}

void Servo::on_settings(const Settings& settings, const PeerEvent& event) noexcept {
  const NodeRole role = event.role;
  if (settings.servo_rate_hz >= kLowestRateHz && settings.servo_rate_hz <= kHighestRateHz) {
    rate_hz_ = settings.servo_rate_hz;
    loop_.set_rate_hz(rate_hz_);
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
  const DeviceSide& side = loop_.look();
  if (side.governor.fault == SafetyFault::none) return;
  const bool is_from_this_host = is_loopback(asker.address);
  const ResetVerdict verdict = judge_reset(asker.key_role, is_from_this_host, side.is_switch_held);
  if (verdict != ResetVerdict::granted) {
    ++resets_denied_;
    if (clock_.now_ns() < next_denial_ns_) return;
    next_denial_ns_ = clock_.now_ns() + kNanosecondsPerSecond;
    const bool lacks_right = verdict == ResetVerdict::no_right;
    return tell(lacks_right ? ServoEvent::Kind::reset_without_right : ServoEvent::Kind::reset_without_person, asker.role, asker.address);
  }
  loop_.reset_faults(is_from_this_host ? ResetPresence::known : ResetPresence::while_held);
}

void Servo::on_joined(const PeerEvent& event) noexcept {
  tell(ServoEvent::Kind::joined, event.role, peers_.peer(event.peer).address);
  if (ways_ != nullptr) ways_->on_joined(event.peer, peers_.peer(event.peer).address);
  if (event.peer == hand_leader_) on_hand({}, event.peer);
  vision_.on_joined(event.peer);
  if (event.role != NodeRole::haptics) return;
  probe_memory_.note_new_haptics();
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
  stats_.status = status_now();
  if (peers_.count(NodeRole::vision) > 0) {
    vision_.tell(probe_memory_, loop_.look(), cycle_, view_ ? view_->revision : 0, stats_.status, now_ns);
  }
  if (view_ && now_ns >= next_view_repeat_ns_) {
    next_view_repeat_ns_ = now_ns + kViewRepeatNs;
    peers_.send_to_role(NodeRole::haptics, *view_);
  }
  if (now_ns >= next_figures_ns_) {
    next_figures_ns_ = now_ns + kFiguresNs;
    vision_.refresh_figures(cycle_.number, now_ns);
    tell_of_strangers(now_ns);
  }
  if (desk_ != nullptr) desk_->serve(peers_);
  // A node that has said goodbye is no fault.
  safety_.look(loop_.look(), cycle_, probe_memory_.last_answer().contact && peers_.has_haptics(), now_ns);
  note_written();
  hand_out_snapshot();
}

// What the device side has measured comes with its next cycle.
void Servo::hand_out_snapshot() noexcept {
  if (snapshot_asked_.exchange(false, std::memory_order_acq_rel)) {
    is_snapshot_due_ = true;
    if (has_device_thread_) return loop_.ask_for_stats();
  }
  if (!is_snapshot_due_ || (has_device_thread_ && !loop_.take_stats())) return;
  is_snapshot_due_ = false;
  snapshots_.publish(fill_stats(has_device_thread_ ? loop_.stats_copy() : loop_.collect_stats()));
}

// Who lacks the key is told nothing; the person at the hub is, now and then.
void Servo::tell_of_strangers(std::int64_t now_ns) noexcept {
  if (const auto flood = peers_.take_flood(now_ns)) {
    ServoEvent event{ServoEvent::Kind::flood, NodeRole::tool, flood->from, flood->per_second, {}, {}};
    event.flood = flood->refusal;
    event.is_from_several = flood->is_from_several;
    event.is_kept_out = flood->is_kept_out;
    events_.push(event);
  }
  strangers_.look(peers_.seal_counts(), peers_.counts(), now_ns, [&](ServoEvent::Kind kind) { tell(kind, NodeRole::tool, {}); });
}

void Servo::finish() noexcept {
  constexpr std::int64_t kStepNs = kNanosecondsPerMillisecond;
  loop_.end();
  is_finished_ = true;
  const std::int64_t end_ns = clock_.now_ns() + kSilenceLimitNs + 2 * kStepNs;
  for (std::int64_t now_ns = clock_.now_ns(); now_ns < end_ns; now_ns = clock_.now_ns()) {
    if (!has_device_thread_) loop_.hold();
    receive_until(now_ns + kStepNs);
  }
  if (!has_device_thread_) loop_.finish();
  if (tap_ != nullptr && loop_.status() == DeviceStatus::fault) tap_->on_fault(SessionFault::device, clock_.now_ns());
  note_written();
  ledger_.close(haptics_alive(cycle_.sample.time_ns));
}

const ServoStats& Servo::collect_stats() noexcept { return fill_stats(loop_.collect_stats()); }

const ServoStats& Servo::fill_stats(const DeviceLoopStats& device) noexcept {
  stats_.start_ns = device.start_ns;
  stats_.end_ns = device.end_ns;
  stats_.rate_hz = device.rate_hz;
  stats_.wake_lateness = device.wake_lateness;
  stats_.device_read = device.device_read;
  stats_.samples = device.samples;
  stats_.missed_cycles = device.missed_cycles;
  stats_.caught_up_cycles = device.caught_up_cycles;
  stats_.missed_by_cause = device.missed_by_cause;
  stats_.max_force_n = device.max_force_n;
  stats_.longest_release_ns = device.longest_release_ns;
  stats_.governor = device.governor;
  stats_.device_status = device.status;
  stats_.device = device.condition;
  stats_.resets_denied = resets_denied_ + device.resets_denied;
  stats_.cuts = device.cuts;
  stats_.cycles_untold = device.cycles_untold;
  stats_.ledger = ledger_.counts();
  stats_.hub = peers_.counts();
  stats_.seal = peers_.seal_counts();
  if (budget_ != nullptr) {
    stats_.socket = budget_->socket_counts();
    stats_.budget_spent = budget_->spent();
  }
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
