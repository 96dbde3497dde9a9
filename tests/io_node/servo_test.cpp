#include "io_node/servo.h"

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

#include "devices/simulated_phantom.h"
#include "link/bare_echo_endpoint.h"
#include "tests/io_node/scripted_endpoint.h"

namespace hapton {
namespace {

constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kUs = 1000;
constexpr std::uint64_t kSession = 77;

// A device that stands still and remembers what was put on its motors.
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
    return {now_ns, place, Quat::Identity(), 5, is_held};
  }
  void write(const Wrench& wrench, std::int64_t now_ns) noexcept override { written.push_back({wrench.force_n, now_ns}); }
  DeviceStatus status() const noexcept override { return state; }
  DeviceCondition condition() const noexcept override { return condition_now; }
  bool lead_hand(const std::optional<Vec3>& p_WH) noexcept override {
    hand = p_WH;
    return true;
  }
  Vec3 place = Vec3(0.01, 0.02, 0.03);
  Vec3 drift = Vec3::Zero();  // from one read to the next
  SimulatedClock* clock = nullptr;
  std::int64_t slow_read_ns = 0;  // of the next one
  DeviceStatus state = DeviceStatus::ready;
  bool is_held = true;
  DeviceCondition condition_now;
  std::vector<Written> written;
  std::vector<std::int64_t> reads;
  bool aim_hand(std::span<const Vec3> p_WA) noexcept override {
    aims.assign(p_WA.begin(), p_WA.end());
    return true;
  }
  std::optional<Vec3> hand;
  std::vector<Vec3> aims;

 private:
  DeviceLimits limits_;
};

struct Servos : testing::Test {
  SimulatedClock clock{1'000'000'000};
  ScriptedEndpoint endpoint{clock};
  BenchDevice device;
  HubPeers peers{endpoint, clock, kSession, 1000.0};
  std::unique_ptr<Servo> servo;
  std::map<std::uint16_t, std::uint64_t> sequences;
  // What the nodes heard.
  std::vector<DeviceState> states;
  std::vector<ProbeState> probes;
  std::vector<ViewTransform> views;
  std::vector<Settings> settings;
  std::vector<std::pair<Address, HapticsSetup>> setups;
  std::vector<std::pair<Address, SceneFacts>> scenes;
  // How the haptics node answers; -1: not at all.
  std::int64_t answer_delay_ns = 100 * kUs;
  ForceCommand answer;
  std::optional<double> floor_z_m;  // set: what is touched, so that each answer has its own sample's visual offset
  // How long the vision node draws at a state; -1: it never says.
  std::int64_t draw_ns = 0;
  std::deque<std::pair<std::int64_t, Drawn>> drawing;

  static Address at(std::uint16_t port) { return {{9}, port}; }
  static constexpr std::uint16_t kHaptics = 1, kVision = 2, kTool = 3;

  void SetUp() override {
    answer.force_n = Vec3(0, 0, 2);
    answer.contact = true;
    answer.compute_ns = 7000;
    answer.visual_offset_m = Vec3(0, 0, 0.001);
    endpoint.on_send = [this](const Address& to, const Datagram& datagram) { hear(to, datagram); };
  }

  void make(Servo::Options options = {}, EchoProbe* echo = nullptr, ServoTap* tap = nullptr) {
    servo = std::make_unique<Servo>(device, peers, clock, options, echo, tap);
  }

  void hear(const Address& to, const Datagram& datagram) {
    if (const auto* state = std::get_if<DeviceState>(&datagram.message)) {
      states.push_back(*state);
      if (answer_delay_ns >= 0) force(*state, answer_delay_ns);
    }
    if (const auto* probe = std::get_if<ProbeState>(&datagram.message)) {
      probes.push_back(*probe);
      if (draw_ns >= 0) drawing.emplace_back(clock.now_ns() + draw_ns, Drawn{probe->sample, probe->sample_time_ns, 60.0F});
    }
    if (const auto* view = std::get_if<ViewTransform>(&datagram.message)) views.push_back(*view);
    if (const auto* setting = std::get_if<Settings>(&datagram.message)) settings.push_back(*setting);
    if (const auto* setup = std::get_if<HapticsSetup>(&datagram.message)) setups.emplace_back(to, *setup);
    if (const auto* scene = std::get_if<SceneFacts>(&datagram.message)) scenes.emplace_back(to, *scene);
  }

  void force(const DeviceState& state, std::int64_t delay_ns) {
    ForceCommand command = answer;
    command.echo_sample = state.sample;
    command.echo_sample_time_ns = state.sample_time_ns;
    if (floor_z_m) command.visual_offset_m.z() = *floor_z_m - state.p_WD.z();
    say(kHaptics, command, delay_ns);
  }

  // From the node at this port, to arrive after delay_ns. Sequences count in the order of saying.
  void say(std::uint16_t port, const Message& message, std::int64_t delay_ns = 0) {
    endpoint.arrive(clock.now_ns() + delay_ns, at(port), {{kSession, 1000ULL + port, ++sequences[port], clock.now_ns()}, message});
  }
  void join(std::uint16_t port, NodeRole role) { say(port, Hello{role}); }

  void run(int cycles) {
    for (int n = 0; n < cycles; ++n) {
      if (n % 100 == 50) {
        for (const auto& [port, unused] : std::map(sequences)) say(port, Hello{roles.at(port)});
      }
      for (; !drawing.empty() && drawing.front().first <= clock.now_ns(); drawing.pop_front()) say(kVision, drawing.front().second);
      servo->step();
    }
  }
  const std::map<std::uint16_t, NodeRole> roles = {{kHaptics, NodeRole::haptics}, {kVision, NodeRole::vision}, {kTool, NodeRole::tool}};
  const ServoStats& stats() { return servo->collect_stats(); }
};

TEST_F(Servos, ticks_on_absolute_time_and_writes_the_matching_force_at_once) {
  make();
  join(kHaptics, NodeRole::haptics);
  run(500);
  ASSERT_EQ(device.reads.size(), 500U);
  for (std::size_t n = 1; n < 500; ++n) ASSERT_EQ(device.reads[n] - device.reads[0], static_cast<std::int64_t>(n) * kMs);
  EXPECT_EQ(states.back().p_WD, device.place);
  EXPECT_EQ(states.back().buttons, 5U);
  EXPECT_EQ(device.written.back().force_n, answer.force_n);
  EXPECT_EQ(device.written.back().time_ns, states.back().sample_time_ns + 100 * kUs);
  EXPECT_EQ(stats().round_trip.max_ns(), 100 * kUs);
  EXPECT_EQ(stats().haptics_compute.max_ns(), 7 * kUs);
  EXPECT_EQ(stats().wire.max_ns(), 93 * kUs);
  EXPECT_EQ(stats().force_age.max_ns(), 100 * kUs);
  EXPECT_EQ(stats().wake_lateness.max_ns(), 0);
  EXPECT_EQ(stats().samples, 500U);
  EXPECT_EQ(stats().forces, states.size());
  EXPECT_EQ(stats().contact_samples, states.size());
  EXPECT_EQ(stats().ledger.lost + stats().ledger.late + stats().missed_cycles, 0U);
  EXPECT_NEAR(stats().seconds(), 0.5, 1e-12);
}

TEST_F(Servos, force_begins_with_a_ramp) {
  make();
  join(kHaptics, NodeRole::haptics);
  run(52);
  EXPECT_NEAR(device.written.back().force_n.z(), 1.0, 0.1);
}

TEST_F(Servos, the_whole_slew_of_a_cycle_is_there_for_its_force) {
  make();
  join(kHaptics, NodeRole::haptics);
  run(300);
  answer.force_n = Vec3(0, 0, 3.9);  // 1.9 N in a cycle; the device bears 2 N
  servo->step();
  EXPECT_EQ(device.written.back().force_n, answer.force_n);
  EXPECT_EQ(stats().governor.counters.slewed, 0U);
  answer.force_n = Vec3(0, 0, 6.5);
  servo->step();
  EXPECT_NEAR(device.written.back().force_n.z(), 5.9, 1e-9);
  EXPECT_EQ(stats().governor.counters.slewed, 1U);
}

TEST_F(Servos, late_forces_are_counted_and_the_newest_wins) {
  make();
  join(kHaptics, NodeRole::haptics);
  run(200);
  answer_delay_ns = 1300 * kUs;
  run(100);
  EXPECT_NEAR(static_cast<double>(stats().ledger.late), 100.0, 2.0);
  EXPECT_EQ(stats().round_trip.max_ns(), 1300 * kUs);
  EXPECT_EQ(device.written.back().force_n, answer.force_n);
  EXPECT_EQ(stats().ledger.lost, 0U);
}

TEST_F(Servos, an_overtaken_force_is_not_written) {
  make();
  join(kHaptics, NodeRole::haptics);
  run(200);
  answer_delay_ns = -1;
  servo->step();
  const DeviceState slow = states.back();
  servo->step();
  force(states.back(), 0);
  answer.force_n = Vec3(7, 0, 0);
  force(slow, 100);
  run(3);
  EXPECT_EQ(device.written.back().force_n, Vec3(0, 0, 2));
  EXPECT_EQ(stats().ledger.reordered, 1U);
}

TEST_F(Servos, silence_lets_go_and_the_force_ramps_back_in) {
  make();
  join(kHaptics, NodeRole::haptics);
  run(300);
  answer_delay_ns = -1;
  run(19);
  EXPECT_NE(device.written.back().force_n, Vec3::Zero());
  run(3);
  EXPECT_EQ(device.written.back().force_n, Vec3::Zero());
  EXPECT_EQ(stats().governor.counters.silences, 1U);
  answer_delay_ns = 50 * kUs;
  run(10);
  EXPECT_LT(device.written.back().force_n.z(), 0.3);
  run(120);
  EXPECT_EQ(device.written.back().force_n, answer.force_n);
  EXPECT_EQ(stats().ledger.lost, 0U);  // they wait for the patience to end
  run(250);
  EXPECT_NEAR(static_cast<double>(stats().ledger.lost), 22.0, 1.0);
}

TEST_F(Servos, a_haptics_node_that_died_loses_nothing_and_its_successor_gets_the_view) {
  make();
  join(kHaptics, NodeRole::haptics);
  join(kVision, NodeRole::vision);
  ViewTransform view;
  view.revision = 4;
  view.X_WS[3] = 0.5F;
  say(kVision, view);
  run(300);
  ASSERT_FALSE(views.empty());
  EXPECT_EQ(views.front().X_WS[3], 0.5F);
  EXPECT_EQ(probes.back().view_revision, 4U);
  // Killed: neither answers nor heartbeats; then another at another port.
  answer_delay_ns = -1;
  sequences.erase(kHaptics);
  run(1200);
  EXPECT_EQ(stats().hub.timeouts, 1U);
  views.clear();
  answer_delay_ns = 100 * kUs;
  sequences[kHaptics] = 0;
  endpoint.arrive(clock.now_ns(), at(kHaptics), {{0, 2000, 1, 0}, Hello{NodeRole::haptics}});
  servo->step();
  EXPECT_EQ(views.size(), 1U);
  run(300);
  servo->finish();
  EXPECT_EQ(stats().ledger.lost, 0U);
  EXPECT_GT(stats().ledger.excused, 1000U);
}

TEST_F(Servos, a_slow_haptics_node_that_skips_samples_supersedes_them) {
  make();
  join(kHaptics, NodeRole::haptics);
  run(200);
  answer_delay_ns = -1;
  run(4);
  answer_delay_ns = 100 * kUs;
  answer.skipped_samples = 4;
  servo->step();
  answer.skipped_samples = 0;
  run(400);
  EXPECT_EQ(stats().ledger.superseded, 4U);
  EXPECT_EQ(stats().ledger.lost, 0U);
}

// The device side is ahead of the network side by three cycles, twice; between the two the haptics node falls behind by a sample.
TEST_F(Servos, samples_that_a_late_network_side_never_sent_are_not_lost) {
  make();
  join(kHaptics, NodeRole::haptics);
  servo->use_device_thread();
  const auto cycles = [&](int count) {
    for (int n = 0; n < count; ++n) {
      clock.sleep_until_ns(servo->device_loop().tick_ns());
      servo->device_loop().begin_cycle();
      ASSERT_TRUE(servo->device_loop().run_cycle());
    }
    servo->step();
  };
  for (int n = 0; n < 200; ++n) {
    if (n % 100 == 50) say(kHaptics, Hello{NodeRole::haptics});
    cycles(1);
  }
  answer_delay_ns = -1;
  cycles(1);
  cycles(3);
  answer_delay_ns = 100 * kUs;
  answer.skipped_samples = 2;
  cycles(3);
  answer.skipped_samples = 0;
  for (int n = 0; n < 400; ++n) {
    if (n % 100 == 50) say(kHaptics, Hello{NodeRole::haptics});
    cycles(1);
  }
  EXPECT_EQ(stats().ledger.superseded, 2U);
  EXPECT_EQ(stats().ledger.lost, 0U);
}

TEST_F(Servos, hostile_forces_never_reach_the_motors_as_they_are) {
  make();
  join(kHaptics, NodeRole::haptics);
  run(200);
  for (const double bad : {1e8, -1e8, 1e9, 8.1}) {
    answer.force_n = Vec3(bad, bad, -bad);
    run(20);
  }
  Vec3 last = Vec3::Zero();
  std::int64_t last_ns = 0;
  for (const auto& written : device.written) {
    ASSERT_TRUE(written.force_n.allFinite());
    ASSERT_LE(written.force_n.norm(), 8.0);
    const double reach_n = last_ns > 0 ? 2000.0e-9 * static_cast<double>(written.time_ns - last_ns) : 8.0;
    ASSERT_LE((written.force_n - last).norm(), reach_n + 1e-9);
    last = written.force_n;
    last_ns = written.time_ns;
  }
  EXPECT_GT(stats().governor.counters.clamped, 60U);
  EXPECT_GT(stats().governor.counters.slewed, 0U);
}

TEST_F(Servos, duplicates_and_forged_echoes_are_ignored) {
  make();
  join(kHaptics, NodeRole::haptics);
  run(200);
  const std::size_t written = device.written.size();
  ForceCommand forged = answer;
  forged.force_n = Vec3(8, 0, 0);
  forged.echo_sample = states.back().sample;
  forged.echo_sample_time_ns = states.back().sample_time_ns;
  say(kHaptics, forged);
  forged.echo_sample += 100;
  say(kHaptics, forged);
  forged.echo_sample_time_ns = std::numeric_limits<std::int64_t>::max();
  say(kHaptics, forged);
  answer_delay_ns = -1;
  servo->step();
  EXPECT_EQ(device.written.size(), written);
  EXPECT_EQ(stats().ledger.duplicate, 1U);
  EXPECT_EQ(stats().ledger.unknown, 2U);
}

TEST_F(Servos, vision_hears_the_probe_at_its_rate_with_offset_and_figures) {
  make({.vision_rate_hz = 50.0});
  device.drift.x() = 1e-6;
  join(kHaptics, NodeRole::haptics);
  join(kVision, NodeRole::vision);
  run(1000);
  EXPECT_NEAR(static_cast<double>(probes.size()), 50.0, 2.0);
  const ProbeState& probe = probes.back();
  EXPECT_EQ(probe.visual_offset_m, answer.visual_offset_m);
  EXPECT_TRUE(probe.contact);
  EXPECT_EQ(probe.force_n, answer.force_n);
  EXPECT_NEAR(probe.servo_rate_hz, 1000.0, 5.0);
  EXPECT_NEAR(probe.round_trip_p50_us, 100.0, 2.0);
  EXPECT_EQ(stats().probe_states_sent, probes.size());
}

// 0.5 m/s into a floor, each answer 1.3 ms late: an offset beside another sample's pose would be off by what the device moved meanwhile.
TEST_F(Servos, vision_hears_a_pose_and_the_offset_of_the_same_sample) {
  make();
  device.drift.z() = -0.5e-3;
  floor_z_m = 0.0;
  answer_delay_ns = 1300 * kUs;
  join(kHaptics, NodeRole::haptics);
  join(kVision, NodeRole::vision);
  run(300);
  double most_m = 0.0;
  std::size_t in_contact = 0;
  std::uint64_t last = 0;
  for (const ProbeState& probe : probes) {
    const DeviceState& state = states.at(states.size() - 1 - (states.back().sample - std::max(probe.sample, states.front().sample)));
    EXPECT_GE(probe.sample, last);
    last = probe.sample;
    if (!probe.contact) continue;
    ++in_contact;
    EXPECT_EQ(probe.p_WD, state.p_WD);
    EXPECT_EQ(probe.sample_time_ns, state.sample_time_ns);
    most_m = std::max(most_m, std::fabs((probe.p_WD + probe.visual_offset_m).z() - *floor_z_m));
  }
  EXPECT_GT(in_contact, 40U);
  EXPECT_LE(most_m, 1e-12) << "the probe is drawn beside the surface";
}

TEST_F(Servos, vision_hears_the_newest_sample_while_nobody_answers) {
  make();
  device.drift.z() = -0.5e-3;
  join(kHaptics, NodeRole::haptics);
  join(kVision, NodeRole::vision);
  run(200);
  answer_delay_ns = -1;
  run(60);
  EXPECT_FALSE(probes.back().contact);
  EXPECT_EQ(probes.back().visual_offset_m, Vec3(Vec3::Zero()));
  EXPECT_LE(states.back().sample - probes.back().sample, 10U) << "the picture stands still";
}

TEST_F(Servos, vision_is_served_without_haptics_too) {
  make();
  device.drift.x() = 1e-6;
  join(kVision, NodeRole::vision);
  run(1000);
  EXPECT_NEAR(static_cast<double>(probes.size()), 240.0, 5.0);
  EXPECT_FALSE(probes.back().contact);
}

TEST_F(Servos, what_has_not_changed_is_told_to_vision_ten_times_a_second_and_at_once_when_it_does) {
  make();
  join(kVision, NodeRole::vision);
  run(1000);
  EXPECT_NEAR(static_cast<double>(probes.size()), 12.0, 4.0);  // the figures change now and then
  EXPECT_NEAR(static_cast<double>(stats().probe_states_spared), 228.0, 6.0);
  const std::size_t before = probes.size();
  device.place.x() += 0.001;
  run(6);
  ASSERT_GT(probes.size(), before);
  EXPECT_EQ(probes.back().p_WD, device.place);
}

TEST_F(Servos, vision_gets_no_more_than_it_draws) {
  make();
  device.drift.x() = 1e-6;
  draw_ns = 20 * kMs;
  join(kVision, NodeRole::vision);
  run(1000);
  EXPECT_NEAR(static_cast<double>(probes.size()), 1000.0 / 21.0, 3.0);
  EXPECT_NEAR(static_cast<double>(stats().drawn), static_cast<double>(probes.size()), 1.0);
  EXPECT_LE(stats().device_to_drawn.max_ns(), 21 * kMs);
}

TEST_F(Servos, drawn_gives_the_age_of_the_picture) {
  make();
  draw_ns = -1;
  join(kVision, NodeRole::vision);
  run(100);
  const ProbeState probe = probes.back();
  say(kVision, Drawn{probe.sample, probe.sample_time_ns, 57.0F}, 15 * kMs);
  say(kVision, Drawn{probe.sample + 1'000'000, probe.sample_time_ns, 57.0F}, 15 * kMs);
  say(kVision, Drawn{probe.sample, -5, 57.0F}, 15 * kMs);
  const std::int64_t expected = clock.now_ns() + 15 * kMs - probe.sample_time_ns;
  run(30);
  EXPECT_EQ(stats().drawn, 1U);
  EXPECT_EQ(stats().device_to_drawn.max_ns(), expected);
  EXPECT_EQ(stats().frame_rate_hz, 57.0);
}

TEST_F(Servos, rate_changes_while_running_and_nonsense_is_refused) {
  make();
  join(kTool, NodeRole::tool);
  run(10);
  for (const double rate : {249.0, 10'001.0, -1.0, 1e300}) say(kTool, Settings{rate, {}, false});
  servo->step();
  EXPECT_EQ(servo->rate_hz(), 1000.0);
  EXPECT_GE(stats().bad_settings + stats().hub.undecodable, 4U);
  say(kTool, Settings{4000.0, {}, false});
  run(3);
  EXPECT_EQ(servo->rate_hz(), 4000.0);
  device.reads.clear();
  run(20);
  for (std::size_t n = 1; n < device.reads.size(); ++n) ASSERT_EQ(device.reads[n] - device.reads[n - 1], 250 * kUs);
  ServoEvent event;
  ASSERT_TRUE(servo->events().pop(event));
  EXPECT_EQ(event.kind, ServoEvent::Kind::joined);
  ASSERT_TRUE(servo->events().pop(event));
  EXPECT_EQ(event.rate_hz, 4000.0);
}

TEST_F(Servos, strangers_are_told_of_but_not_all_the_time) {
  make();
  run(1000);
  ServoEvent event;
  EXPECT_FALSE(servo->events().pop(event));
  int told_of_key = 0;
  int told_of_version = 0;
  for (int second = 0; second < 30; ++second) {
    endpoint.seal.wrong_key += 20;
    endpoint.seal.wrong_version += second == 0 ? 1 : 0;
    run(1000);
    while (servo->events().pop(event)) {
      told_of_key += event.kind == ServoEvent::Kind::wrong_key ? 1 : 0;
      told_of_version += event.kind == ServoEvent::Kind::wrong_version ? 1 : 0;
    }
  }
  EXPECT_EQ(told_of_key, 3);
  EXPECT_EQ(told_of_version, 1);
}

TEST_F(Servos, a_method_goes_on_to_haptics_and_a_report_wish_to_the_other_thread) {
  make();
  join(kHaptics, NodeRole::haptics);
  join(kTool, NodeRole::tool);
  Settings wish;
  std::copy_n("sweep", 5, wish.method.begin());
  wish.report_now = true;
  wish.method_ask = 77;
  run(5);
  say(kTool, wish);
  run(2);
  ASSERT_EQ(settings.size(), 1U);
  EXPECT_STREQ(settings[0].method.data(), "sweep");
  EXPECT_EQ(settings[0].servo_rate_hz, 0.0);
  EXPECT_EQ(settings[0].method_ask, 77U);
  EXPECT_FALSE(settings[0].report_now);
  EXPECT_TRUE(servo->take_report_wish());
  EXPECT_FALSE(servo->take_report_wish());
  servo->ask_for_snapshot();
  EXPECT_FALSE(servo->take_snapshot());
  servo->step();
  ASSERT_TRUE(servo->take_snapshot());
  EXPECT_EQ(servo->snapshot().samples, 8U);
}

TEST_F(Servos, what_haptics_says_of_its_method_is_heard_by_tools_and_vision) {
  make();
  join(kHaptics, NodeRole::haptics);
  join(kVision, NodeRole::vision);
  join(kTool, NodeRole::tool);
  run(5);
  HapticsSetup refused{.method_ask = 77};
  std::copy_n("no", 2, refused.refusal.begin());
  say(kHaptics, refused);
  say(kTool, HapticsSetup{.method_ask = 78});
  run(2);
  ASSERT_EQ(setups.size(), 2U);
  EXPECT_EQ(setups[0].first, at(kTool));
  EXPECT_EQ(setups[1].first, at(kVision)) << "it draws the probe as large as it is felt";
  for (const auto& [to, setup] : setups) {
    EXPECT_EQ(setup.method_ask, 77U);
    EXPECT_STREQ(setup.refusal.data(), "no");
  }
}

TEST_F(Servos, haptics_and_vision_hear_of_each_others_scene) {
  make();
  join(kHaptics, NodeRole::haptics);
  join(kVision, NodeRole::vision);
  join(kTool, NodeRole::tool);
  run(5);
  say(kHaptics, SceneFacts{.given_hash = 1});
  run(2);
  say(kVision, SceneFacts{.given_hash = 2});
  run(2);
  say(kTool, SceneFacts{.given_hash = 3});
  run(2);
  ASSERT_EQ(scenes.size(), 2U);
  EXPECT_EQ(scenes[0].first, at(kVision));
  EXPECT_EQ(scenes[0].second.given_hash, 1U);
  EXPECT_EQ(scenes[1].first, at(kHaptics));
  EXPECT_EQ(scenes[1].second.given_hash, 2U);
}

TEST_F(Servos, the_hand_is_told_where_the_scene_is_and_where_it_was_turned_to) {
  make();
  join(kHaptics, NodeRole::haptics);
  join(kVision, NodeRole::vision);
  run(5);
  say(kHaptics,
      SceneFacts{.given_hash = 1, .lowest_m = {0, 0, 0}, .highest_m = {0.08F, 0, 0}, .point_count = 1, .points_m = {{{0.08F, 0, 0}}}});
  run(3);
  ASSERT_EQ(device.aims.size(), 1U);
  EXPECT_LT((device.aims[0] - Vec3(0.08, 0, 0)).norm(), 1e-6);
  EXPECT_EQ(servo->collect_stats().reach, SceneReach::in_reach);
  say(kVision, ViewTransform{.revision = 1, .X_WS = {0, -1, 0, 0, 1, 0, 0, 0.5F, 0, 0, 1, 0}});
  run(3);
  EXPECT_LT((device.aims[0] - Vec3(0, 0.58, 0)).norm(), 1e-6);
  EXPECT_EQ(servo->collect_stats().reach, SceneReach::out_of_reach);
  ASSERT_FALSE(probes.empty());
  EXPECT_EQ(probes.back().status, ProbeStatus::out_of_reach);
}

TEST_F(Servos, vision_is_told_why_there_is_no_force) {
  make();
  join(kVision, NodeRole::vision);
  run(200);
  ASSERT_FALSE(probes.empty());
  EXPECT_EQ(probes.back().status, ProbeStatus::no_haptics);
  join(kHaptics, NodeRole::haptics);
  run(500);
  EXPECT_EQ(probes.back().status, ProbeStatus::ok);
  device.state = DeviceStatus::calibrating;
  run(200);
  EXPECT_EQ(probes.back().status, ProbeStatus::calibrating);
  device.state = DeviceStatus::away;
  run(200);
  EXPECT_EQ(probes.back().status, ProbeStatus::device_away);
  device.state = DeviceStatus::ready;
  run(1000);
  EXPECT_EQ(probes.back().status, ProbeStatus::ok);
  answer_delay_ns = -1;
  run(200);
  EXPECT_EQ(probes.back().status, ProbeStatus::no_haptics);
  answer_delay_ns = 100 * kUs;
  run(500);
  servo->device_loop().latch_again(SafetyFault::speed);
  run(200);
  EXPECT_EQ(probes.back().status, ProbeStatus::fault_latched);
}

TEST_F(Servos, remembers_what_the_haptics_node_works_with) {
  make();
  join(kHaptics, NodeRole::haptics);
  run(5);
  HapticsSetup setup{.scene_hash = 0xABCD};
  std::copy_n("car.toml", 8, setup.scene.begin());
  say(kHaptics, setup);
  run(2);
  EXPECT_EQ(servo->collect_stats().setup.scene_hash, 0xABCDU);
  EXPECT_STREQ(servo->collect_stats().setup.scene.data(), "car.toml");
}

TEST_F(Servos, the_mouse_leads_the_hand_until_it_lets_go_or_leaves) {
  make();
  join(kVision, NodeRole::vision);
  run(2);
  say(kVision, HandTarget{true, Vec3(0.01, 0, 0)});
  run(2);
  ASSERT_TRUE(device.hand);
  EXPECT_EQ(*device.hand, Vec3(0.01, 0, 0));
  say(kVision, HandTarget{});
  run(2);
  EXPECT_FALSE(device.hand);
  say(kVision, HandTarget{true, Vec3(0.01, 0, 0)});
  run(2);
  ASSERT_TRUE(device.hand);
  say(kVision, Bye{});
  run(2);
  EXPECT_FALSE(device.hand);
}

TEST_F(Servos, a_cycle_that_comes_too_late_skips_whole_periods_and_counts_them) {
  make();
  join(kHaptics, NodeRole::haptics);
  run(100);
  const std::int64_t before = device.reads.back();
  clock.advance_ns(7 * kMs + 300 * kUs);
  run(5);
  // A cycle is over when its force is written, 100 us after its tick: the next tick was missed by 6.4 ms.
  EXPECT_EQ(stats().missed_cycles, 6U);
  EXPECT_EQ(stats().wake_lateness.max_ns(), 6400 * kUs);
  const std::size_t n = device.reads.size();
  EXPECT_EQ(device.reads[n - 1] - before, 11 * kMs);
  EXPECT_EQ(device.reads[n - 1] - device.reads[n - 2], kMs);
  EXPECT_NEAR(stats().seconds(), 0.111, 1e-12);
}

std::uint64_t missed_by(const ServoStats& stats, MissCause cause) { return stats.missed_by_cause[static_cast<std::size_t>(cause)]; }

TEST_F(Servos, every_missed_cycle_has_its_cause) {
  make();
  device.clock = &clock;
  join(kHaptics, NodeRole::haptics);
  run(100);
  device.slow_read_ns = 3 * kMs;
  run(5);
  EXPECT_EQ(missed_by(stats(), MissCause::device_slow), 2U);
  clock.advance_ns(3 * kMs);  // between a cycle's force and the wait for the next tick
  run(5);
  EXPECT_EQ(missed_by(stats(), MissCause::work_long), 2U);
  clock.advance_ns(30 * kMs);
  run(5);
  EXPECT_EQ(missed_by(stats(), MissCause::machine_stalled), 29U);
  EXPECT_EQ(stats().missed_cycles, 33U);
}

TEST_F(Servos, a_wait_that_ends_late_is_a_late_wake_up) {
  class Oversleeping final : public Endpoint {
   public:
    explicit Oversleeping(SimulatedClock& c) : clock(c) {}
    bool send(const Address&, std::span<const std::byte>) noexcept override { return true; }
    Received receive(std::span<std::byte>, std::int64_t deadline_ns) noexcept override {
      clock.sleep_until_ns(deadline_ns + std::exchange(too_long_ns, 0));
      return {};
    }
    Address local_address() const override { return {}; }
    SimulatedClock& clock;
    std::int64_t too_long_ns = 0;
  };
  Oversleeping sleepy(clock);
  HubPeers nobody(sleepy, clock, kSession, 1000.0);
  Servo alone(device, nobody, clock, {});
  for (int n = 0; n < 10; ++n) alone.step();
  sleepy.too_long_ns = 2 * kMs + 1;
  for (int n = 0; n < 10; ++n) alone.step();
  EXPECT_EQ(missed_by(alone.collect_stats(), MissCause::late_wake_up), 2U);
  EXPECT_EQ(alone.collect_stats().missed_cycles, 2U);
}

TEST_F(Servos, a_wait_for_the_echo_that_ends_late_is_a_late_wake_up) {
  ScriptedEndpoint echo_endpoint(clock);
  std::int64_t late_ns = 0;
  echo_endpoint.on_send_raw = [&](const Address& to, std::span<const std::byte> bytes) {
    if (late_ns > 0) clock.advance_ns(std::exchange(late_ns, 0));
    echo_endpoint.arrive_raw(clock.now_ns() + 30 * kUs, to, bytes);
  };
  EchoProbe echo(echo_endpoint, clock, {{5}, 5});
  make({}, &echo);
  join(kHaptics, NodeRole::haptics);
  run(100);
  late_ns = 3 * kMs;
  run(5);
  EXPECT_EQ(missed_by(stats(), MissCause::late_wake_up), stats().missed_cycles);
  EXPECT_GT(stats().missed_cycles, 1U);
}

TEST_F(Servos, a_loop_that_wakes_late_learns_to_wake_early_and_begins_on_time) {
  class Late final : public Endpoint {
   public:
    explicit Late(SimulatedClock& c) : clock(c) {}
    bool send(const Address&, std::span<const std::byte>) noexcept override { return true; }
    Received receive(std::span<std::byte>, std::int64_t deadline_ns) noexcept override {
      if (deadline_ns > clock.now_ns()) clock.sleep_until_ns(deadline_ns + 20 * kUs);
      return {};
    }
    Address local_address() const override { return {}; }
    SimulatedClock& clock;
  };
  // Time passes with every look at it, so that spinning ends.
  class Ticking final : public Clock {
   public:
    explicit Ticking(SimulatedClock& c) : clock(c) {}
    std::int64_t now_ns() const noexcept override {
      clock.advance_ns(50);
      return clock.now_ns();
    }
    void sleep_until_ns(std::int64_t deadline_ns) noexcept override { clock.sleep_until_ns(deadline_ns); }
    SimulatedClock& clock;
  };
  Late late(clock);
  Ticking ticking(clock);
  HubPeers nobody(late, ticking, kSession, 1000.0);
  Servo alone(device, nobody, ticking, {.spin_share = 0.1});
  for (int n = 0; n < 3000; ++n) alone.step();
  const ServoStats& measured = alone.collect_stats();
  EXPECT_LT(measured.wake_lateness.quantile_ns(0.5), 1000.0);
  EXPECT_GT(measured.wake_lateness.max_ns(), 19 * kUs);  // before it had learnt
  EXPECT_GT(alone.spin().spun_ns(), 0);
  EXPECT_LT(alone.spin().spun_ns(), 3000 * 20 * kUs);
  EXPECT_EQ(measured.missed_cycles, 0U);
}

TEST_F(Servos, catching_up_runs_every_missed_cycle_at_once) {
  make({.overrun = OverrunPolicy::catch_up});
  join(kHaptics, NodeRole::haptics);
  run(100);
  const std::size_t before = device.reads.size();
  const std::int64_t next_tick_ns = device.reads.back() + kMs;
  clock.advance_ns(5 * kMs);
  run(20);
  EXPECT_EQ(stats().missed_cycles, 0U);
  EXPECT_EQ(missed_by(stats(), MissCause::work_long), stats().caught_up_cycles);
  EXPECT_GE(stats().caught_up_cycles, 4U);
  // On time again, and none was left out.
  EXPECT_EQ(device.reads.back(), next_tick_ns + static_cast<std::int64_t>(device.reads.size() - 1 - before) * kMs);
}

TEST_F(Servos, catching_up_has_an_end) {
  make({.overrun = OverrunPolicy::catch_up});
  run(10);
  clock.advance_ns(1000 * kMs);
  run(1000);
  EXPECT_GT(stats().missed_cycles, 980U);
  EXPECT_LE(stats().caught_up_cycles, 11U);
}

TEST_F(Servos, a_missed_cycle_stops_the_session_where_that_is_asked_for) {
  make({.overrun = OverrunPolicy::stop});
  run(100);
  EXPECT_FALSE(servo->has_overrun());
  clock.advance_ns(3 * kMs);
  run(1);
  EXPECT_TRUE(servo->has_overrun());
}

// Remembers what it heard.
class Heard final : public ServoTap {
 public:
  void on_received(const Address&, std::span<const std::byte>, std::int64_t) noexcept override { ++received; }
  void on_sent(const Address&, std::span<const std::byte>, std::int64_t) noexcept override { ++sent; }
  void on_cycle(const CycleNote& note, std::int64_t) noexcept override { cycles.push_back(note); }
  void on_fault(SessionFault fault, std::int64_t) noexcept override { faults.push_back(fault); }
  int received = 0;
  int sent = 0;
  std::vector<CycleNote> cycles;
  std::vector<SessionFault> faults;
};

TEST_F(Servos, a_tap_hears_datagrams_and_cycles) {
  Heard tap;
  make({}, nullptr, &tap);
  join(kHaptics, NodeRole::haptics);
  run(200);
  ASSERT_EQ(tap.cycles.size(), 200U);
  EXPECT_EQ(tap.cycles.back().sample, states.back().sample);
  EXPECT_EQ(tap.cycles.back().written_n, answer.force_n);
  EXPECT_EQ(static_cast<std::uint64_t>(tap.received), stats().hub.received);
  EXPECT_GE(tap.sent, 200);
  EXPECT_TRUE(tap.faults.empty());
  clock.advance_ns(3 * kMs);
  run(1);
  EXPECT_EQ(tap.cycles.back().missed, 2U);
  peers.set_tap(nullptr);
}

TEST_F(Servos, a_tap_hears_each_fault_once) {
  Heard tap;
  make({}, nullptr, &tap);
  join(kHaptics, NodeRole::haptics);
  run(200);
  answer_delay_ns = -1;
  run(40);
  EXPECT_EQ(tap.faults, std::vector{SessionFault::silence});
  answer_delay_ns = 100 * kUs;
  run(10);
  tap.faults.clear();
  answer.force_n = Vec3(0, 0, 100);
  run(10);
  EXPECT_EQ(tap.faults, std::vector{SessionFault::clamped});
  answer.force_n = Vec3(0, 0, 1);
  run(5);
  tap.faults.clear();
  clock.advance_ns(25 * kMs);
  run(1);
  EXPECT_EQ(tap.faults.back(), SessionFault::stalled);
  tap.faults.clear();
  device.state = DeviceStatus::fault;
  servo->finish();
  EXPECT_EQ(tap.faults, std::vector{SessionFault::device});
  peers.set_tap(nullptr);
}

// The events that came since, of these kinds.
std::vector<ServoEvent> events_of(Servo& servo, std::initializer_list<ServoEvent::Kind> kinds) {
  std::vector<ServoEvent> events;
  for (ServoEvent event; servo.events().pop(event);) {
    if (std::find(kinds.begin(), kinds.end(), event.kind) != kinds.end()) events.push_back(event);
  }
  return events;
}

TEST_F(Servos, a_latched_fault_is_told_recorded_and_reset_by_a_tool_alone) {
  Heard tap;
  make({.hold_button = 2}, nullptr, &tap);  // held: someone is at the device
  join(kHaptics, NodeRole::haptics);
  join(kVision, NodeRole::vision);
  join(kTool, NodeRole::tool);
  run(300);
  device.place.x() += 0.05;
  run(20);
  EXPECT_EQ(device.written.back().force_n, Vec3::Zero());
  EXPECT_EQ(tap.faults, std::vector{SessionFault::jump});
  const auto latched = events_of(*servo, {ServoEvent::Kind::latched});
  ASSERT_EQ(latched.size(), 1U);
  EXPECT_EQ(latched[0].fault, SafetyFault::jump);
  EXPECT_EQ(stats().governor.fault, SafetyFault::jump);
  EXPECT_EQ(stats().governor.state, GovernorState::latched);
  Settings reset;
  reset.reset_faults = true;
  say(kVision, reset);
  run(300);
  EXPECT_EQ(device.written.back().force_n, Vec3::Zero());
  EXPECT_TRUE(events_of(*servo, {ServoEvent::Kind::reset}).empty());
  say(kTool, reset);
  run(20);
  EXPECT_EQ(events_of(*servo, {ServoEvent::Kind::reset}).size(), 1U);
  EXPECT_LT(device.written.back().force_n.z(), 0.6);
  run(150);
  EXPECT_EQ(device.written.back().force_n, answer.force_n);
  EXPECT_EQ(tap.faults, std::vector{SessionFault::jump});
  peers.set_tap(nullptr);
}

TEST_F(Servos, a_reset_is_refused_while_the_cause_is_there) {
  make({.hold_button = 2});
  join(kHaptics, NodeRole::haptics);
  join(kTool, NodeRole::tool);
  run(300);
  device.condition_now.motor_temperature = 1.0;
  run(600);
  EXPECT_EQ(stats().governor.fault, SafetyFault::thermal);
  EXPECT_EQ(device.written.back().force_n, Vec3::Zero());
  Settings reset;
  reset.reset_faults = true;
  say(kTool, reset);
  run(10);
  EXPECT_EQ(events_of(*servo, {ServoEvent::Kind::reset_refused}).size(), 1U);
  device.condition_now.motor_temperature = 0.5;
  run(600);
  say(kTool, reset);
  run(300);
  EXPECT_EQ(device.written.back().force_n, answer.force_n);
}

TEST_F(Servos, a_reset_takes_an_operators_key_and_a_person_at_the_device) {
  KeyRole tools_key = KeyRole::tool;
  endpoint.key_role_of = [&](const Address& from) {
    return from.port == kTool ? tools_key : from.port == kVision ? KeyRole::vision : KeyRole::haptics;
  };
  Settings reset;
  reset.reset_faults = true;
  const auto reset_by = [&](KeyRole key_role, int hold_button) {
    tools_key = key_role;
    make({.hold_button = hold_button});
    join(kHaptics, NodeRole::haptics);
    join(kTool, NodeRole::tool);
    run(300);
    device.place.x() = -device.place.x() + 0.05;
    run(20);
    EXPECT_NE(stats().governor.fault, SafetyFault::none);
    events_of(*servo, {});
    say(kTool, reset);
    run(20);
    const auto told =
        events_of(*servo, {ServoEvent::Kind::reset, ServoEvent::Kind::reset_without_right, ServoEvent::Kind::reset_without_person});
    EXPECT_EQ(told.size(), 1U);
    const bool is_reset = !told.empty() && told[0].kind == ServoEvent::Kind::reset;
    EXPECT_EQ(stats().governor.fault == SafetyFault::none, is_reset);
    EXPECT_EQ(stats().resets_denied, is_reset ? 0U : 1U);
    say(kTool, Bye{});
    run(2);
    return told.empty() ? ServoEvent::Kind::joined : told[0].kind;
  };
  // From another host, with no dead man's switch, or with one that is held.
  EXPECT_EQ(reset_by(KeyRole::tool, -1), ServoEvent::Kind::reset_without_right);
  EXPECT_EQ(reset_by(KeyRole::tool, 2), ServoEvent::Kind::reset_without_right);
  EXPECT_EQ(reset_by(KeyRole::operator_role, -1), ServoEvent::Kind::reset_without_person);
  EXPECT_EQ(reset_by(KeyRole::operator_role, 2), ServoEvent::Kind::reset);
}

TEST_F(Servos, resets_that_are_denied_are_all_counted_and_told_once_a_second) {
  endpoint.key_role_of = [](const Address& from) { return from.port == kTool ? KeyRole::tool : KeyRole::haptics; };
  make();
  join(kHaptics, NodeRole::haptics);
  join(kTool, NodeRole::tool);
  run(300);
  device.place.x() = -device.place.x() + 0.05;
  run(20);
  Settings reset;
  reset.reset_faults = true;
  std::size_t told = 0;
  for (int n = 0; n < 1500; ++n) {
    say(kTool, reset);
    run(1);
    told += events_of(*servo, {ServoEvent::Kind::reset_without_right}).size();
  }
  EXPECT_GE(stats().resets_denied, 1499U);
  EXPECT_EQ(told, 2U);
}

TEST_F(Servos, a_key_that_does_not_allow_a_role_is_told_of) {
  endpoint.key_role_of = [](const Address& from) { return from.port == kTool ? KeyRole::vision : KeyRole::haptics; };
  make();
  join(kHaptics, NodeRole::haptics);
  run(300);
  EXPECT_TRUE(events_of(*servo, {ServoEvent::Kind::role_violation}).empty());
  for (int n = 0; n < 500; ++n) {
    say(kTool, Hello{.role = NodeRole::haptics});
    run(1);
  }
  run(300);
  EXPECT_EQ(events_of(*servo, {ServoEvent::Kind::role_violation}).size(), 1U);
  EXPECT_GE(stats().hub.role_violations, 499U);
}

TEST_F(Servos, a_flood_is_told_of_with_where_it_comes_from) {
  make();
  run(100);
  endpoint.flood = Flood{Refusal::replayed_handshake, at(66), true, 200'000.0};
  run(300);
  const auto told = events_of(*servo, {ServoEvent::Kind::flood});
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0].flood, Refusal::replayed_handshake);
  EXPECT_EQ(told[0].address, at(66));
  EXPECT_TRUE(told[0].is_from_several);
  EXPECT_EQ(told[0].rate_hz, 200'000.0);
}

TEST_F(Servos, a_device_that_is_away_is_told_of_and_its_force_ramps_in_on_return) {
  make();
  join(kHaptics, NodeRole::haptics);
  run(300);
  for (const DeviceStatus status : {DeviceStatus::away, DeviceStatus::calibrating}) {
    device.state = status;
    run(500);
    EXPECT_EQ(device.written.back().force_n, Vec3::Zero());
    device.place.x() = -device.place.x();
    device.state = DeviceStatus::ready;
    run(20);
    EXPECT_LT(device.written.back().force_n.z(), 0.6);
    run(250);
    EXPECT_EQ(device.written.back().force_n, answer.force_n);
  }
  std::vector<ServoEvent::Kind> kinds;
  for (const ServoEvent& event : events_of(*servo, {ServoEvent::Kind::away, ServoEvent::Kind::calibrating, ServoEvent::Kind::back})) {
    kinds.push_back(event.kind);
  }
  EXPECT_EQ(kinds, (std::vector{ServoEvent::Kind::away, ServoEvent::Kind::back, ServoEvent::Kind::calibrating, ServoEvent::Kind::back}));
  EXPECT_EQ(stats().governor.fault, SafetyFault::none);
}

TEST_F(Servos, the_dead_mans_switch_lets_go) {
  make({.hold_button = 1});
  join(kHaptics, NodeRole::haptics);
  run(300);  // the device holds buttons 0 and 2
  EXPECT_TRUE(device.written.empty() || device.written.back().force_n == Vec3::Zero());
  make({.hold_button = 2});
  run(300);
  EXPECT_EQ(device.written.back().force_n, answer.force_n);
  device.is_held = false;
  run(20);
  EXPECT_EQ(device.written.back().force_n, Vec3::Zero());
}

TEST_F(Servos, a_haptics_node_that_says_goodbye_in_contact_is_no_fault) {
  Heard tap;
  make({}, nullptr, &tap);
  join(kHaptics, NodeRole::haptics);
  run(200);
  say(kHaptics, Bye{});
  for (int n = 0; n < 40; ++n) servo->step();
  EXPECT_EQ(stats().governor.counters.silences, 1U);
  EXPECT_TRUE(tap.faults.empty());
  peers.set_tap(nullptr);
}

TEST_F(Servos, a_silence_in_free_space_is_no_fault) {
  Heard tap;
  make({}, nullptr, &tap);
  join(kHaptics, NodeRole::haptics);
  answer.contact = false;
  answer.force_n = Vec3::Zero();
  run(200);
  answer_delay_ns = -1;
  run(40);
  EXPECT_EQ(stats().governor.counters.silences, 1U);
  EXPECT_TRUE(tap.faults.empty());
  peers.set_tap(nullptr);
}

TEST_F(Servos, a_flood_of_rubbish_does_not_hold_up_the_loop) {
  make();
  join(kHaptics, NodeRole::haptics);
  run(200);
  // More than a late loop looks at in a cycle, all of it there already, and the clock stands still while it is read.
  const std::byte rubbish[] = {std::byte{1}, std::byte{2}, std::byte{3}};
  clock.advance_ns(5 * kMs);
  for (int n = 0; n < 500; ++n) endpoint.arrive_raw(clock.now_ns(), at(66), rubbish);
  const std::size_t reads = device.reads.size();
  const std::uint64_t heard = stats().hub.undecodable;
  servo->step();
  EXPECT_EQ(device.reads.size(), reads + 1);
  run(100);
  EXPECT_EQ(stats().hub.undecodable, heard + 500);
  EXPECT_EQ(stats().governor.counters.silences, 0U);
}

TEST_F(Servos, echo_is_measured_halfway_and_leaves_the_force_path_alone) {
  ScriptedEndpoint echo_endpoint(clock);
  const Address responder{{5}, 5};
  std::vector<std::int64_t> sent;
  echo_endpoint.on_send_raw = [&](const Address& to, std::span<const std::byte> bytes) {
    sent.push_back(clock.now_ns());
    std::vector<std::byte> reply(bytes.begin(), bytes.end());
    std::memcpy(reply.data(), kEchoReply.data(), kEchoMarkBytes);
    if (sent.size() % 10 != 0) echo_endpoint.arrive_raw(clock.now_ns() + 30 * kUs, to, reply);
  };
  EchoProbe echo(echo_endpoint, clock, responder);
  make({}, &echo);
  join(kHaptics, NodeRole::haptics);
  run(500);
  EXPECT_EQ(stats().round_trip.max_ns(), 100 * kUs);
  EXPECT_EQ(stats().wake_lateness.max_ns(), 0);
  EXPECT_EQ(stats().missed_cycles, 0U);
  EXPECT_EQ(sent.size(), 500U);
  for (std::size_t n = 0; n < sent.size(); ++n) ASSERT_EQ(sent[n] - device.reads[n], 500 * kUs);
  EXPECT_EQ(stats().echo.answered, 450U);
  EXPECT_EQ(stats().bare_echo.max_ns(), 30 * kUs);
}

TEST_F(Servos, finish_lets_the_device_go) {
  make();
  join(kHaptics, NodeRole::haptics);
  run(300);
  EXPECT_EQ(device.written.back().force_n, answer.force_n);
  servo->finish();
  EXPECT_EQ(device.written.back().force_n, Vec3::Zero());
  EXPECT_EQ(stats().ledger.lost, 0U);
  EXPECT_EQ(stats().governor.counters.silences, 0U);
  EXPECT_NEAR(stats().seconds(), 0.3, 1e-12);
}

TEST_F(Servos, a_limit_of_zero_gives_no_force_and_all_the_rest) {
  make({.forbids_force = true});
  join(kHaptics, NodeRole::haptics);
  run(300);
  EXPECT_EQ(stats().max_force_n, 0.0);
  EXPECT_GT(stats().forces, 200U);
  EXPECT_EQ(device.written.back().force_n, Vec3::Zero());
}

TEST_F(Servos, tighter_limits_hold) {
  make({.tighter = {.max_force_n = 1.5}});
  join(kHaptics, NodeRole::haptics);
  run(300);
  EXPECT_NEAR(device.written.back().force_n.z(), 1.5, 1e-9);
}

}  // namespace
}  // namespace hapton
