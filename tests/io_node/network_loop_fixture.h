#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <deque>
#include <initializer_list>
#include <limits>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "devices/device.h"
#include "io_node/network_loop.h"
#include "link/bare_echo_endpoint.h"
#include "tests/io_node/scripted_endpoint.h"
#include "tests/support/time_units.h"

namespace hapton {

constexpr std::uint64_t kSession = 77;

// A device that does not move and records the forces on its motors.
class BenchDevice final : public Device {
 public:
  struct Written {
    Vec3 force_n;
    std::int64_t time_ns;
  };
  BenchDevice() {
    limits_ = {8.0, 2000.0, 1000.0, Vec3::Constant(-0.1), Vec3::Constant(0.1)};
    written.reserve(100'000);
  }
  std::string_view name() const noexcept override { return "bench"; }
  const DeviceLimits& limits() const noexcept override { return limits_; }
  DeviceSample read(std::int64_t now_ns) noexcept override {
    reads.push_back(now_ns);
    if (clock != nullptr) clock->advance_ns(std::exchange(slow_read_ns, 0));
    place += drift;
    return {now_ns, place, Quat::Identity(), stylus_buttons, is_held};
  }
  void write(const Wrench& wrench, std::int64_t now_ns) noexcept override { written.push_back({wrench.force_n, now_ns}); }
  DeviceStatus status() const noexcept override { return device_status; }
  DeviceCondition condition() const noexcept override { return condition_now; }
  bool set_hand_target(const std::optional<Vec3>& p_WH) noexcept override {
    hand_target = p_WH;
    return true;
  }
  bool press_hand_buttons(std::uint32_t pressed) noexcept override {
    hand_buttons = pressed;
    return true;
  }
  bool turn_hand(const Vec3& turn) noexcept override {
    turn_rad = turn;
    return true;
  }
  // Gives the device motors that turn the stylus. Pre: the network loop is not made yet.
  void give_torque(double max_torque_nm) noexcept { limits_.max_torque_nm = limits_.max_torque_slew_nm_per_s = max_torque_nm; }
  Vec3 turn_rad = Vec3::Zero();
  std::uint32_t hand_buttons = 0;    // of the simulated hand, pressed by the node that leads it
  std::uint32_t stylus_buttons = 5;  // held down, as bits
  Vec3 place = Vec3(0.01, 0.02, 0.03);
  Vec3 drift = Vec3::Zero();  // motion from one read to the next
  SimulatedClock* clock = nullptr;
  std::int64_t slow_read_ns = 0;  // how long the next read takes
  DeviceStatus device_status = DeviceStatus::ready;
  bool is_held = true;
  DeviceCondition condition_now;
  std::vector<Written> written;
  std::vector<std::int64_t> reads;
  bool aim_hand(std::span<const Vec3> p_WA) noexcept override {
    aims.assign(p_WA.begin(), p_WA.end());
    return true;
  }
  std::optional<Vec3> hand_target;
  std::vector<Vec3> aims;

 private:
  DeviceLimits limits_;
};

// A network loop with a device on simulated time; a script plays the three kinds of nodes.
struct NetworkLoops : testing::Test {
  SimulatedClock clock{1'000'000'000};
  ScriptedEndpoint endpoint{clock};
  BenchDevice device;
  HubPeers peers{endpoint, clock, kSession, 1000.0};
  std::unique_ptr<NetworkLoop> network;
  std::map<std::uint16_t, std::uint64_t> sequences;
  // Messages received by the nodes.
  std::vector<DeviceState> states;
  std::vector<ProbeState> probes;
  std::vector<ViewTransform> views;
  std::vector<Settings> settings;
  std::vector<std::pair<Address, HapticsSetup>> setups;
  std::vector<std::pair<Address, SceneFacts>> scenes;
  std::vector<std::pair<Address, MaterialRequest>> material_requests;
  std::vector<std::pair<Address, MaterialState>> material_states;
  std::vector<std::pair<Address, ObjectPose>> object_poses;
  std::vector<std::pair<Address, MoveRequest>> move_requests;
  std::vector<std::pair<Address, MoveReply>> move_replies;
  std::vector<std::pair<Address, ObjectMove>> object_moves;
  std::vector<std::pair<Address, ShapeRequest>> shape_requests;
  std::vector<std::pair<Address, ShapeReply>> shape_replies;
  std::vector<std::pair<Address, ObjectShape>> object_shapes;
  std::vector<std::pair<Address, ShapeStart>> shape_starts;
  std::vector<std::pair<Address, ShapeStatus>> shape_statuses;
  std::vector<std::pair<Address, Carves>> carves;
  std::vector<std::pair<Address, CarveStatus>> carve_statuses;
  std::vector<std::pair<Address, CarveUndo>> carve_undos;
  std::vector<std::pair<Address, MarkerReply>> marker_replies;
  std::vector<LoopFacts> loop_facts;  // these and the patch statuses are for the haptics node alone
  std::vector<std::pair<std::int64_t, PatchStatus>> patch_statuses;
  // Delay of the haptics node's reply; -1: no reply.
  std::int64_t reply_delay_ns = 100 * kUs;
  ForceCommand force_reply;
  bool replies_name_newest_view = true;  // the newest one sent to the haptics node
  std::optional<double> floor_z_m;       // if set: height of a floor, from which each reply has the visual offset of its own sample
  // How long the vision node draws a state; -1: it never reports a frame.
  std::int64_t draw_ns = 0;
  std::deque<std::pair<std::int64_t, FrameAck>> acks;  // of frames being drawn, by the time at which each is drawn

  static Address at(std::uint16_t port) { return {{9}, port}; }
  static constexpr std::uint16_t kHaptics = 1, kVision = 2, kTool = 3;

  void SetUp() override {
    force_reply.force_n = Vec3(0, 0, 2);
    force_reply.contact = true;
    force_reply.compute_ns = 7000;
    force_reply.visual_offset_m = Vec3(0, 0, 0.001);
    endpoint.on_send = [this](const Address& to, const Datagram& datagram) { receive(to, datagram); };
  }

  void make(NetworkLoop::Options options = {}, EchoProbe* echo = nullptr, ServoTap* tap = nullptr) {
    network = std::make_unique<NetworkLoop>(device, peers, clock, options, echo, tap);
  }

  void receive(const Address& to, const Datagram& datagram) {
    if (const auto* state = std::get_if<DeviceState>(&datagram.message)) {
      states.push_back(*state);
      if (reply_delay_ns >= 0) reply_with_force(*state, reply_delay_ns);
    }
    if (const auto* probe = std::get_if<ProbeState>(&datagram.message)) {
      probes.push_back(*probe);
      if (draw_ns >= 0) acks.emplace_back(clock.now_ns() + draw_ns, FrameAck{probe->sample, probe->sample_time_ns, 60.0F});
    }
    if (const auto* view = std::get_if<ViewTransform>(&datagram.message)) views.push_back(*view);
    if (const auto* setting = std::get_if<Settings>(&datagram.message)) settings.push_back(*setting);
    if (const auto* setup = std::get_if<HapticsSetup>(&datagram.message)) setups.emplace_back(to, *setup);
    if (const auto* scene = std::get_if<SceneFacts>(&datagram.message)) scenes.emplace_back(to, *scene);
    if (const auto* request = std::get_if<MaterialRequest>(&datagram.message)) material_requests.emplace_back(to, *request);
    if (const auto* state = std::get_if<MaterialState>(&datagram.message)) material_states.emplace_back(to, *state);
    if (const auto* pose = std::get_if<ObjectPose>(&datagram.message)) object_poses.emplace_back(to, *pose);
    if (const auto* request = std::get_if<MoveRequest>(&datagram.message)) move_requests.emplace_back(to, *request);
    if (const auto* reply = std::get_if<MoveReply>(&datagram.message)) move_replies.emplace_back(to, *reply);
    if (const auto* move = std::get_if<ObjectMove>(&datagram.message)) object_moves.emplace_back(to, *move);
    if (const auto* part = std::get_if<ShapeRequest>(&datagram.message)) shape_requests.emplace_back(to, *part);
    if (const auto* reply = std::get_if<ShapeReply>(&datagram.message)) shape_replies.emplace_back(to, *reply);
    if (const auto* part = std::get_if<ObjectShape>(&datagram.message)) object_shapes.emplace_back(to, *part);
    if (const auto* start = std::get_if<ShapeStart>(&datagram.message)) shape_starts.emplace_back(to, *start);
    if (const auto* status = std::get_if<ShapeStatus>(&datagram.message)) shape_statuses.emplace_back(to, *status);
    if (const auto* some = std::get_if<Carves>(&datagram.message)) carves.emplace_back(to, *some);
    if (const auto* status = std::get_if<CarveStatus>(&datagram.message)) carve_statuses.emplace_back(to, *status);
    if (const auto* undo = std::get_if<CarveUndo>(&datagram.message)) carve_undos.emplace_back(to, *undo);
    if (const auto* reply = std::get_if<MarkerReply>(&datagram.message)) marker_replies.emplace_back(to, *reply);
    if (const auto* facts = std::get_if<LoopFacts>(&datagram.message)) {
      EXPECT_EQ(to, at(kHaptics));
      loop_facts.push_back(*facts);
    }
    if (const auto* status = std::get_if<PatchStatus>(&datagram.message)) {
      EXPECT_EQ(to, at(kHaptics));
      patch_statuses.emplace_back(clock.now_ns(), *status);
    }
  }

  void reply_with_force(const DeviceState& state, std::int64_t delay_ns) {
    ForceCommand command = force_reply;
    command.echo_sample = state.sample;
    command.echo_sample_time_ns = state.sample_time_ns;
    if (replies_name_newest_view && !views.empty()) command.view_revision = views.back().revision;
    if (floor_z_m) command.visual_offset_m.z() = *floor_z_m - state.p_WD.z();
    say(kHaptics, command, delay_ns);
  }

  // Sends a message from the node at this port, to arrive after delay_ns. Sequence numbers count in the order of these calls.
  void say(std::uint16_t port, const Message& message, std::int64_t delay_ns = 0) {
    endpoint.arrive(clock.now_ns() + delay_ns, at(port), {{kSession, 1000ULL + port, ++sequences[port], clock.now_ns()}, message});
  }
  void join(std::uint16_t port, NodeRole role) { say(port, Hello{role}); }

  void run(int cycles) {
    for (int n = 0; n < cycles; ++n) {
      if (n % 100 == 50) {  // often enough for no node to time out
        for (const auto& [port, unused] : std::map(sequences)) say(port, Hello{roles.at(port)});
      }
      for (; !acks.empty() && acks.front().first <= clock.now_ns(); acks.pop_front()) say(kVision, acks.front().second);
      network->step();
    }
  }
  std::map<std::uint16_t, NodeRole> roles = {{kHaptics, NodeRole::haptics}, {kVision, NodeRole::vision}, {kTool, NodeRole::tool}};
  const ServoStats& stats() { return network->collect_stats(); }
};

// A tap that records what it receives.
class RecordingTap final : public ServoTap {
 public:
  void on_received(const Address&, std::span<const std::byte>, std::int64_t) noexcept override { ++received; }
  void on_sent(const Address&, std::span<const std::byte>, std::int64_t) noexcept override { ++sent; }
  void on_cycle(const CycleNote& note, std::int64_t) noexcept override { cycles.push_back(note); }
  void on_fault(SessionFault fault, std::int64_t) noexcept override { faults.push_back(fault); }
  bool is_recording() const noexcept override { return marker_status == MarkerStatus::recorded; }
  MarkerStatus on_marker(const MarkerNote& note, std::int64_t) noexcept override {
    markers.emplace_back(note.sample, note.text);
    return marker_status;
  }
  int received = 0;
  int sent = 0;
  std::vector<CycleNote> cycles;
  std::vector<SessionFault> faults;
  std::vector<std::pair<std::uint64_t, std::string>> markers;
  MarkerStatus marker_status = MarkerStatus::recorded;
};

// The events of these kinds since the last call.
inline std::vector<ServoEvent> events_of(NetworkLoop& network, std::initializer_list<ServoEvent::Kind> kinds) {
  std::vector<ServoEvent> events;
  for (ServoEvent event; network.events().pop(event);) {
    if (std::find(kinds.begin(), kinds.end(), event.kind) != kinds.end()) events.push_back(event);
  }
  return events;
}

inline std::uint64_t missed_by(const ServoStats& stats, MissCause cause) { return stats.missed_by_cause[static_cast<std::size_t>(cause)]; }

}  // namespace hapton
