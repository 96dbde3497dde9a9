#include "io_node/network_loop.h"

#include <algorithm>
#include <cmath>
#include <variant>

#include "core/base/button_bit.h"
#include "core/math/rotation_vector.h"

namespace hapton {
namespace {

// Period of the statistics in the drawn frame: a person cannot read the numbers more often.
constexpr std::int64_t kStatisticsNs = 250 * kNanosecondsPerMillisecond;

}  // namespace

NetworkLoop::NetworkLoop(Device& device, HubPeers& peers, const Clock& clock, const Options& options, EchoProbe* echo, ServoTap* tap)
    : loop_(device, clock,
            {.rate_hz = options.rate_hz,
             .tighter_limits = options.tighter_limits,
             .forbids_force = options.forbids_force,
             .forbids_torque = options.forbids_torque,
             .dead_mans_switch = options.dead_mans_switch,
             .clutch_button = options.clutch_button,
             .passive_mechanics = options.passive_mechanics,
             .overrun = options.overrun,
             .spin_share = options.spin_share}),
      peers_(peers),
      clock_(clock),
      echo_(echo),
      tap_(tap),
      receiver_(peers, clock, *this),
      reply_spin_(options.reply_spin_ns),
      cycles_(loop_, receiver_, peers, clock),
      forces_(loop_, peers, clock, stats_),
      view_(peers, stats_),
      scene_(loop_, peers, events_, stats_),
      vision_(peers, stats_, options.vision_rate_hz, button_bit(options.dead_mans_switch)),
      requests_(loop_, peers, clock, events_, stats_, options.rate_hz),
      loop_reporter_(peers, stats_, device.name(), loop_.limits().max_torque_nm),
      markers_(peers, tap, stats_),
      carves_(peers, tap),
      shapes_(peers, tap),
      peer_notices_(events_, peers),
      safety_(events_, tap),
      local_rest_ns_(std::llround(1e9 / std::max(kRestedHz, options.vision_rate_hz))) {
  peers_.set_tap(tap_);
  start();
}

void NetworkLoop::set_hop_meter(HopMeter* hops) noexcept {
  hops_ = hops;
  forces_.set_hop_meter(hops);
  vision_.set_hop_meter(hops);
}

void NetworkLoop::set_budget(BudgetedEndpoint* budget) noexcept {
  budget_ = budget;
  cycles_.set_budget(budget);
}

void NetworkLoop::start() noexcept {
  if (!cycles_.has_device_thread()) loop_.start();
  stats_.start_ns = clock_.now_ns() + std::llround(1e9 / rate_hz());
  cycle_.next_wake_ns = cycle_.next_tick_ns = stats_.start_ns;
  view_.start(stats_.start_ns);
  vision_.set_force_limit(loop_.limits().max_force_n);
  vision_.start(stats_.start_ns);
  safety_.start(stats_.start_ns);
  next_statistics_ns_ = stats_.start_ns + kStatisticsNs;
}

void NetworkLoop::step() noexcept {
  if (!read_cycles()) return;
  forces_.send(cycle_);
  const std::int64_t middle_ns = cycle_.tick_ns + (cycle_.next_tick_ns - cycle_.tick_ns) / 2;
  await_force(middle_ns);  // a force is governed and written when it arrives: ForceExchange::accept
  do_housekeeping();
  probe_echo(middle_ns);
  cycles_.prepare_next_wait(cycle_, rest_ns());
}

// Takes all cycles up to the one that is newest now, whose sample is then sent; later ones wait for the next call. False: no new cycle.
bool NetworkLoop::read_cycles() noexcept {
  if (!cycles_.await(cycle_, rate_hz(), rest_ns())) return false;
  bool is_newest = false;
  while (!is_newest && loop_.take_cycle(cycle_)) {
    is_newest = !loop_.has_cycle();
    forces_.add_cycle(cycle_, is_newest);
    if (cycle_.local) forces_.note_local(cycle_, view_.view() ? view_.view()->revision : 0);
    if (!is_newest) safety_.note_overtaken(cycle_, cycle_.sample.time_ns);
  }
  return true;
}

void NetworkLoop::await_force(std::int64_t deadline_ns) noexcept {
  const auto is_needed = [this] { return forces_.is_awaited() && !forces_.is_local(); };
  if (is_needed()) spin_for_force(is_needed, deadline_ns);
  receiver_.receive_while(is_needed, deadline_ns);
}

template <class IsNeeded>
void NetworkLoop::spin_for_force(IsNeeded&& is_needed, std::int64_t deadline_ns) noexcept {
  const std::int64_t begin_ns = clock_.now_ns();
  const std::int64_t end_ns = std::min(deadline_ns, reply_spin_.find_end_ns(begin_ns, cycle_.next_tick_ns - cycle_.tick_ns));
  if (end_ns <= begin_ns) return;
  receiver_.spin_while(is_needed, end_ns);
  reply_spin_.note(!is_needed(), clock_.now_ns() - begin_ns);
}

// Called in each step, after the wait for a force.
void NetworkLoop::do_housekeeping() noexcept {
  const std::int64_t now_ns = clock_.now_ns();
  forces_.settle(now_ns);
  if (patches_ != nullptr) {
    patches_->update(forces_, view_.view(), now_ns);
    touch_notices_.check(*patches_, forces_.is_local(), peers_.has_haptics(), [this](const ServoEvent& event) { events_.push(event); });
  }
  stats_.status = find_probe_status(loop_.latest(), peers_.has_haptics(), scene_.reach(), scene_.is_hand_inside());
  if (peers_.count(NodeRole::vision) > 0) {
    vision_.send(forces_.history(), loop_.latest(), cycle_, view_.revision_in_use(forces_.history()), stats_.status, now_ns);
  }
  show_proxy();
  view_.repeat_if_due(now_ns);
  // The report is about forces that cross the network. Those of a patch do not; without patches (a scene not sent in parts) all forces do.
  if (!forces_.is_local()) loop_reporter_.send_if_due(rate_hz(), now_ns);
  if (now_ns >= next_statistics_ns_) {
    next_statistics_ns_ = now_ns + kStatisticsNs;
    stats_.newest_round_trip_s = peers_.has_haptics() ? forces_.find_round_trip_s() : -1.0;
    vision_.refresh_statistics(cycle_.number, now_ns);
    peer_notices_.check(now_ns);
  }
  carves_.request_if_due(now_ns);
  shapes_.request_if_due(now_ns);
  if (report_server_ != nullptr) report_server_->serve(peers_);
  safety_.check(loop_.latest(), cycle_, forces_.is_in_contact(), now_ns);
  forces_.note_written();
  publisher_.publish_if_requested(loop_, cycles_.has_device_thread(),
                                  [this](const DeviceLoopStats& device) -> const ServoStats& { return fill_stats(device); });
}

void NetworkLoop::show_proxy() noexcept {
  if (vrpn_feed_ == nullptr || !vrpn_feed_->is_wanted()) return;
  ProbeState probe;
  forces_.history().show(loop_.latest().has_timed_out, probe);
  vrpn_feed_->show_proxy({probe.p_WD + probe.visual_offset_m, turn_by(probe.visual_turn) * probe.q_WT, probe.contact});
}

void NetworkLoop::probe_echo(std::int64_t middle_ns) noexcept {
  if (echo_ == nullptr || forces_.is_awaited()) return;
  receiver_.receive_until(middle_ns);
  // Early enough that a late echo does not delay the next cycle.
  const std::int64_t end_ns = cycle_.next_tick_ns - (cycle_.next_tick_ns - cycle_.tick_ns) / 8;
  echo_->probe(end_ns);
  receiver_.note_waited(end_ns, clock_.now_ns());
}

void NetworkLoop::handle(const PeerEvent& event, const Datagram& datagram) noexcept {
  if (event.kind == PeerEvent::Kind::message) return on_message(event, datagram);
  peer_notices_.note(event);
  if (event.kind == PeerEvent::Kind::joined) on_joined(event);
  if (event.kind == PeerEvent::Kind::left) on_left(event);
}

void NetworkLoop::on_message(const PeerEvent& event, const Datagram& datagram) noexcept {
  const Message& message = datagram.message;
  if (const auto* force = std::get_if<ForceCommand>(&message)) return forces_.accept(datagram.header, *force);
  if (patches_ != nullptr && is_scene_part(message)) return patches_->accept(message);
  if (const auto* marker = std::get_if<Marker>(&message)) return markers_.accept(*marker, event, cycle_.number, event.receive_time_ns);
  // An older message of these kinds counts as well: they are about several objects, or from several senders, and each has its own number.
  if (const auto* reply = std::get_if<MoveReply>(&message)) return requests_.accept(*reply);
  if (const auto* move = std::get_if<ObjectMove>(&message)) {
    if (patches_ != nullptr) patches_->accept(*move);
    peers_.send_to_role(NodeRole::vision, *move);
    return;
  }
  // Likewise: a shape has several parts, and starts are about several objects.
  if (const auto* part = std::get_if<ShapeRequest>(&message)) return requests_.accept(*part, event);
  if (const auto* reply = std::get_if<ShapeReply>(&message)) return requests_.accept(*reply);
  if (const auto* part = std::get_if<ObjectShape>(&message)) {
    shapes_.note(*part, event.arrival);
    if (patches_ != nullptr) patches_->accept_shape(message, event.arrival);
    peers_.send_to_role(NodeRole::vision, message);
    return;
  }
  if (const auto* start = std::get_if<ShapeStart>(&message)) {
    shapes_.note(*start, event.arrival, event.receive_time_ns);
    if (patches_ != nullptr) patches_->accept_shape(message, event.arrival);
    peers_.send_to_role(NodeRole::vision, message);
    return;
  }
  if (std::holds_alternative<ShapeStatus>(message)) {
    peers_.send_to_role(NodeRole::haptics, message);
    return;
  }
  // Carves may arrive in any order, and more than once.
  if (const auto* carves = std::get_if<Carves>(&message)) {
    carves_.note(*carves, event.arrival);
    peers_.send_to_role(NodeRole::vision, *carves);
    return;
  }
  if (event.arrival == Arrival::newest) on_newest(event, datagram);
}

// Of each of these kinds of message only the newest counts (KindOrder).
void NetworkLoop::on_newest(const PeerEvent& event, const Datagram& datagram) noexcept {
  const Message& message = datagram.message;
  if (const auto* view = std::get_if<ViewTransform>(&message)) return on_view(*view, event.peer);
  if (const auto* drawn = std::get_if<FrameAck>(&message)) {
    return vision_.on_frame_ack(datagram.header, *drawn, event.peer, cycle_.number, clock_.now_ns());
  }
  if (const auto* target = std::get_if<HandTarget>(&message)) return requests_.accept(*target, event.peer);
  if (const auto* settings = std::get_if<Settings>(&message)) return requests_.accept(*settings, event);
  if (const auto* request = std::get_if<MaterialRequest>(&message)) return requests_.accept(*request, event);
  if (const auto* request = std::get_if<MoveRequest>(&message)) return requests_.accept(*request, event);
  if (const auto* setup = std::get_if<HapticsSetup>(&message)) return on_setup(*setup);
  if (const auto* state = std::get_if<MaterialState>(&message)) {
    peers_.send_to_role(NodeRole::tool, *state);
    // Also for `hapton dynamics`, which joins as a vision node.
    peers_.send_to_role(NodeRole::vision, *state);
    return;
  }
  if (const auto* pose = std::get_if<ObjectPose>(&message)) {
    if (event.role == NodeRole::vision) {  // a request to move the object to this pose
      peers_.send_to_role(NodeRole::haptics, *pose);
      return;
    }
    peers_.send_to_role(NodeRole::vision, *pose);
    peers_.send_to_role(NodeRole::tool, *pose);
    return;
  }
  if (const auto* status = std::get_if<CarveStatus>(&message)) {
    peers_.send_to_role(NodeRole::haptics, *status);
    return;
  }
  if (const auto* undo = std::get_if<CarveUndo>(&message)) {
    peers_.send_to_role(NodeRole::haptics, *undo);
    return;
  }
  if (const auto* scene = std::get_if<SceneFacts>(&message)) return scene_.accept(*scene, event.role, view_.view());
  if (const auto* request = std::get_if<ReportRequest>(&message); request != nullptr && report_server_ != nullptr) {
    report_server_->accept(event.peer, *request);
  }
}

void NetworkLoop::on_joined(const PeerEvent& event) noexcept {
  if (hops_ != nullptr) hops_->on_joined(event.peer, peers_.peer(event.peer).address);
  requests_.on_peer_gone(event.peer);
  markers_.on_peer_gone(event.peer);
  vision_.on_joined(event.peer);
  if (event.role != NodeRole::tool) view_.on_joined(event.peer, clock_.now_ns());
  if (event.role != NodeRole::haptics) return;
  forces_.on_haptics_joined();
  if (patches_ != nullptr) patches_->on_haptics_joined();
}

void NetworkLoop::on_left(const PeerEvent& event) noexcept {
  requests_.on_peer_gone(event.peer);
  markers_.on_peer_gone(event.peer);
  view_.on_left(event.peer);
  if (event.role == NodeRole::haptics) forces_.on_haptics_left();
}

void NetworkLoop::on_view(const ViewTransform& view, std::size_t peer) noexcept {
  if (!view_.accept(view, peer, clock_.now_ns())) return;
  forces_.forget_probe_position();
  scene_.place(view_.view());
}

void NetworkLoop::on_setup(const HapticsSetup& setup) noexcept {
  stats_.setup = setup;
  if (view_.accept(setup)) scene_.place(view_.view());
  peers_.send_to_role(NodeRole::tool, setup);
  peers_.send_to_role(NodeRole::vision, setup);  // vision nodes draw the probe at its true size
}

void NetworkLoop::finish() noexcept {
  constexpr std::int64_t kStepNs = kNanosecondsPerMillisecond;
  const bool runs_device = !cycles_.has_device_thread();
  loop_.end();
  if (patches_ != nullptr) patches_->finish();
  const std::int64_t end_ns = clock_.now_ns() + kCommandTimeoutNs + 2 * kStepNs;
  for (std::int64_t now_ns = clock_.now_ns(); now_ns < end_ns; now_ns = clock_.now_ns()) {
    if (runs_device) loop_.hold();
    receiver_.receive_until(now_ns + kStepNs);
    record_remaining_cycles();
  }
  if (runs_device) loop_.finish();
  safety_.finish(loop_.latest(), loop_.status(), clock_.now_ns());
  forces_.note_written();
  forces_.close(cycle_.sample.time_ns);
}

void NetworkLoop::record_remaining_cycles() noexcept {
  for (DeviceCycle cycle; loop_.take_cycle(cycle);) safety_.note_overtaken(cycle, cycle.sample.time_ns);
}

const ServoStats& NetworkLoop::fill_stats(const DeviceLoopStats& device) noexcept {
  add_device_stats(device, stats_);
  add_peer_stats(peers_, stats_);
  stats_.resets_denied += requests_.resets_denied();
  stats_.responses = forces_.responses().counts();
  stats_.touched_object = forces_.is_in_contact() ? forces_.history().last_reply().object : -1;
  stats_.events_dropped = events_.dropped();
  if (budget_ != nullptr) {
    stats_.socket = budget_->socket_counts();
    stats_.budget_spent = budget_->spent();
  }
  if (patches_ != nullptr) {
    stats_.patch_thread = patches_->thread_counts();
    stats_.patch_touch = patches_->touch_counts();
  }
  if (hops_ != nullptr) stats_.hops = hops_->collect(clock_.now_ns());
  if (echo_ != nullptr) {
    stats_.bare_echo = echo_->round_trip();
    stats_.echo = echo_->counts();
  }
  return stats_;
}

}  // namespace hapton
