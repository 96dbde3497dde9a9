// Sessions with both sides in their threads, over real sockets; a class of this test plays the haptics node.
#include "io_node/io_session.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <thread>

#include "devices/replay_device.h"
#include "devices/simulated_phantom.h"
#include "io_node/latch_file.h"
#include "link/hub_client.h"
#include "link/random_id.h"
#include "link/udp_endpoint.h"
#include "tests/support/log_of.h"
#include "tests/support/patience.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

// Replies to every sample with 1 N until it is stopped.
class Replier {
 public:
  explicit Replier(const Address& hub) : thread_([this, hub] { run(hub); }) {}
  ~Replier() {
    stop_ = true;
    thread_.join();
  }

 private:
  void run(const Address& hub) {
    SteadyClock clock;
    const auto endpoint = open_udp_endpoint("127.0.0.1:0");
    HubClient client(**endpoint, clock, NodeRole::haptics, hub);
    Datagram datagram;
    while (!stop_) {
      if (!client.receive(datagram, clock.now_ns() + 10'000'000)) continue;
      const auto* state = std::get_if<DeviceState>(&datagram.message);
      if (state == nullptr) continue;
      ForceCommand force;
      force.echo_sample = state->sample;
      force.echo_sample_time_ns = state->sample_time_ns;
      force.force_n = Vec3(0, 0, 1);
      force.contact = true;
      client.send(force);
    }
  }
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

struct Sessions : testing::Test {
  void SetUp() override {
    options.realtime.mode = RealtimeMode::off;
    options.seconds = 0.5;
    options.out = folder.string();
  }

  Result<void> run(Device& device, const NetworkLoop::Options& network_options = {}) {
    const auto endpoint = open_udp_endpoint("127.0.0.1:0");
    HubPeers peers(**endpoint, clock, make_random_id(), options.rate_hz);
    const auto network = std::make_unique<NetworkLoop>(device, peers, clock, network_options);
    Replier haptics((*endpoint)->local_address());
    IoSession session(*network, clock, options);
    const auto ended = session.run(stop);
    forces = network->collect_stats().forces;
    return ended;
  }
  std::string report() {
    std::stringstream text;
    text << std::ifstream(folder / "report.json").rdbuf();
    return text.str();
  }

  ScratchFolder scratch;
  std::filesystem::path folder = scratch.path() / "out";
  IoOptions options;
  SteadyClock clock;
  StopSignal stop;
  std::uint64_t forces = 0;
};

TEST_F(Sessions, RunsForItsTimeAndLeavesAReport) {
  const auto has_scheduling = [this] { return report().find("\"loop_worked\"") != std::string::npos; };
  // On a busy machine the haptics node may come too late for a short session, or the second check of scheduling.
  for (; (forces == 0 || !has_scheduling()) && options.seconds < 30.0; options.seconds *= 2.0) {
    SimulatedPhantom device({});
    const std::int64_t begin_ns = clock.now_ns();
    const auto ended = run(device);
    ASSERT_TRUE(ended) << ended.error().what;
    EXPECT_GE(clock.now_ns() - begin_ns, static_cast<std::int64_t>(1e9 * options.seconds));
  }
  EXPECT_GT(forces, 0U);
  EXPECT_TRUE(has_scheduling());
  EXPECT_NE(report().find("\"round_trip\""), std::string::npos);
  EXPECT_TRUE(std::filesystem::exists(folder / "latency.csv"));
}

TEST_F(Sessions, EndsWithItsRecording) {
  options.seconds = 0.0;
  ReplayDevice device({{0.0, Vec3::Zero(), Quat::Identity()}, {0.1, Vec3::UnitX(), Quat::Identity()}}, {});
  EXPECT_TRUE(run(device));
}

// A device that is away for 100 reads, is calibrated for 100 more, and is ready until a force has been written; then its recording ends.
class LateReadyDevice final : public Device {
 public:
  std::string_view name() const noexcept override { return "wayward"; }
  const DeviceLimits& limits() const noexcept override { return phantom_.limits(); }
  DeviceSample read(std::int64_t now_ns) noexcept override {
    ++reads_;
    return phantom_.read(now_ns);
  }
  void write(const Wrench& wrench, std::int64_t now_ns) noexcept override {
    if (wrench.force_n != Vec3::Zero()) ++(reads_ < 200 ? forces_before_ready : forces_when_ready);
    phantom_.write(wrench, now_ns);
  }
  DeviceStatus status() const noexcept override {
    if (reads_ < 100) return DeviceStatus::away;
    if (reads_ < 200) return DeviceStatus::calibrating;
    return forces_when_ready == 0 ? DeviceStatus::ready : DeviceStatus::ended;
  }
  bool set_hand_target(const std::optional<Vec3>&) noexcept override { return false; }

  int forces_before_ready = 0;
  int forces_when_ready = 0;

 private:
  SimulatedPhantom phantom_{{}};
  int reads_ = 0;
};

TEST_F(Sessions, GoesOnWhileTheDeviceIsAwayOrBeingCalibrated) {
  options.seconds = 0.0;
  LateReadyDevice device;
  EXPECT_TRUE(run(device));
  EXPECT_EQ(device.forces_before_ready, 0);
  EXPECT_GT(device.forces_when_ready, 0);
}

// A device that returns one sample late.
class OneSlowReadDevice final : public Device {
 public:
  std::string_view name() const noexcept override { return "stumbling"; }
  const DeviceLimits& limits() const noexcept override { return phantom_.limits(); }
  DeviceSample read(std::int64_t now_ns) noexcept override {
    if (++reads_ == 50) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    return phantom_.read(now_ns);
  }
  void write(const Wrench& wrench, std::int64_t now_ns) noexcept override { phantom_.write(wrench, now_ns); }
  DeviceStatus status() const noexcept override { return DeviceStatus::ready; }
  bool set_hand_target(const std::optional<Vec3>&) noexcept override { return false; }

 private:
  SimulatedPhantom phantom_{{}};
  int reads_ = 0;
};

TEST_F(Sessions, ACycleThatIsMissedEndsItWithAnErrorWhereThatIsRequested) {
  options.seconds = 0.0;
  OneSlowReadDevice device;
  const auto ended = run(device, {.overrun = OverrunPolicy::stop});
  ASSERT_FALSE(ended);
  EXPECT_NE(ended.error().what.find("a cycle was missed"), std::string::npos) << ended.error().what;
}

TEST_F(Sessions, EndsOnRequestAndReportsOnRequest) {
  options.seconds = 0.0;
  SimulatedPhantom device({});
  std::atomic<bool> is_written{false};
  std::thread requester([&] {
    // A request from before the session began is not answered, so it is repeated.
    is_written = wait_until([&] {
      std::raise(SIGUSR1);
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      return std::filesystem::exists(folder / "report.json");
    });
    stop.request_stop();
  });
  EXPECT_TRUE(run(device));
  requester.join();
  EXPECT_TRUE(is_written);
}

TEST_F(Sessions, AReportThatCannotBeWrittenIsAnError) {
  options.out = "/proc/nowhere";
  options.seconds = 0.1;
  SimulatedPhantom device({});
  const auto ended = run(device);
  ASSERT_FALSE(ended);
  EXPECT_NE(ended.error().what.find("/proc/nowhere"), std::string::npos);
}

// What a session with these events logs for people.
struct SessionEvents : Sessions {
  std::string log_with(const std::vector<ServoEvent>& events, const LatchFile* latch_file = nullptr) {
    options.seconds = 0.01;
    return log_of([&] {
      SimulatedPhantom device({});
      const auto endpoint = open_udp_endpoint("127.0.0.1:0");
      HubPeers peers(**endpoint, clock, make_random_id(), options.rate_hz);
      const auto network = std::make_unique<NetworkLoop>(device, peers, clock, NetworkLoop::Options());
      for (const ServoEvent& event : events) network->events().push(event);
      IoSession session(*network, clock, options);
      session.set_latch_file(latch_file);
      EXPECT_TRUE(session.run(stop));
    });
  }

  static ServoEvent event_of(ServoEvent::Kind kind) {
    ServoEvent event;
    event.kind = kind;
    return event;
  }
  static ServoEvent fault_event(ServoEvent::Kind kind, SafetyFault fault = SafetyFault::speed) {
    ServoEvent event = event_of(kind);
    event.address = *parse_address("10.0.0.7:5000");
    event.fault = fault;
    return event;
  }
};

TEST_F(SessionEvents, OfFaultsAreLoggedWithTheRemedy) {
  using Kind = ServoEvent::Kind;
  const std::string log_text = log_with({fault_event(Kind::latched), fault_event(Kind::reset), fault_event(Kind::reset_rejected),
                                         fault_event(Kind::reset_without_right), fault_event(Kind::reset_without_person)});
  for (const char* line :
       {"fault latched, no force: the device moved faster than its limit; fix the cause, then: hapton set --reset-faults "
        "(docs/safety.md)\n",
        "fault reset (speed); the force ramps up\n", "fault not reset: its cause persists: the device moved faster than its limit\n",
        "fault reset rejected: the tool at 10.0.0.7:5000 has no operator's key (hapton keygen --role operator)\n",
        "fault reset rejected: the operator at 10.0.0.7:5000 is on another host and no dead man's switch is held; reset it here, or while "
        "someone holds the switch (--dead-mans-switch)\n"}) {
    EXPECT_THAT(log_text, testing::HasSubstr(line));
  }
  options.device.name = "plugin:./pen.so";
  EXPECT_THAT(log_with({fault_event(Kind::latched)}), testing::HasSubstr("than its limit (device plugin:./pen.so); fix the cause"));
}

TEST_F(SessionEvents, OfRejectedNodesAreLoggedWithTheRemedy) {
  using Kind = ServoEvent::Kind;
  ServoEvent flood = fault_event(Kind::flood);
  flood.flood = Rejection::forged;
  flood.rate_hz = 2000.4;
  ServoEvent large_flood = flood;
  large_flood.is_from_several = large_flood.is_mostly_filtered = true;
  ServoEvent rejected = event_of(Kind::rejected);
  rejected.role = NodeRole::haptics;
  const std::string log_text =
      log_with({rejected, event_of(Kind::wrong_key), event_of(Kind::wrong_version), event_of(Kind::role_violation), flood, large_flood});
  for (const char* line :
       {"a haptics node was rejected: the hub has no free slot for it; it keeps trying\n",
        "a node with another key, or none, tried to join; if it is yours, give it a key made from this hub's master key: hapton keygen "
        "--role ROLE --master MASTER FILE\n",
        "a node uses another protocol version; if it is yours, build all nodes from the same sources, and make new keys (hapton keygen) if "
        "it is older than version 3\n",
        "a node requested a role that its key does not allow; if it is yours, give it the key of its role: hapton keygen --role ROLE "
        "--master MASTER FILE\n",
        "flood of forged datagrams from 10.0.0.7:5000, 2000 a second: rejected; the force is not delayed\n",
        "flood of forged datagrams from 10.0.0.7:5000 and others, 2000 a second: dropped in the kernel (nodes may take longer to join); "
        "the "
        "force is not delayed\n"}) {
    EXPECT_THAT(log_text, testing::HasSubstr(line));
  }
}

TEST_F(SessionEvents, OfTheSceneAndTheLoopAreLogged) {
  using Kind = ServoEvent::Kind;
  ServoEvent method = event_of(Kind::method_requested);
  std::copy_n("sweep", 5, method.method.begin());
  ServoEvent parts = event_of(Kind::parts_requested);
  parts.round_trip_s = 0.0123;
  options.name = "left";
  ServoEvent rate = event_of(Kind::rate_changed);
  rate.rate_hz = 4000.0;
  std::vector<ServoEvent> events = {rate, method, parts};
  for (const Kind kind : {Kind::material_requested, Kind::out_of_reach, Kind::too_small, Kind::in_reach, Kind::force_from_parts,
                          Kind::force_from_haptics, Kind::away, Kind::calibrating, Kind::back}) {
    events.push_back(event_of(kind));
  }
  const std::string log_text = log_with(events);
  for (const char* line :
       {"left: servo rate now 4000 Hz\n", "left: method requested: sweep\n", "left: change of a material requested\n",
        "left: the scene is out of the device's reach: give its --unit, place it with a scene file (docs/scene-files.md), or leave out "
        "--no-fit\n",
        "left: the scene is far too small for the device's workspace: give its --unit, scale it in a scene file, or leave out --no-fit\n",
        "left: the scene is within the device's reach\n",
        "left: touch, round trip 12.3 ms: requesting the scene in parts, to compute the force here (docs/remote.md)\n",
        "left: touch: the force is computed here, from parts of the scene\n",
        "left: touch, round trip not known yet: the force comes from haptics_node again\n",
        "left: the device is disconnected; no force until it is back\n",
        "left: the device is being calibrated; no force until it is ready\n", "left: the device is ready; the force ramps up\n"}) {
    EXPECT_THAT(log_text, testing::HasSubstr(line));
  }
}

// The fault is kept for the next start. That of a device that has failed, too: DeviceHub removes it if the process ends by itself.
TEST_F(SessionEvents, ALatchedFaultIsKeptUntilItsReset) {
  const LatchFile latch_file(scratch.path() / "latched");
  log_with({fault_event(ServoEvent::Kind::latched, SafetyFault::device)}, &latch_file);
  EXPECT_EQ(latch_file.read(), SafetyFault::device);
  log_with({fault_event(ServoEvent::Kind::latched, SafetyFault::jump)}, &latch_file);
  EXPECT_EQ(latch_file.read(), SafetyFault::jump);
  log_with({fault_event(ServoEvent::Kind::reset_rejected, SafetyFault::jump)}, &latch_file);
  EXPECT_EQ(latch_file.read(), SafetyFault::jump);
  log_with({fault_event(ServoEvent::Kind::reset, SafetyFault::jump)}, &latch_file);
  EXPECT_EQ(latch_file.read(), SafetyFault::none);
  const LatchFile unwritable("/proc/nowhere/latched");
  EXPECT_THAT(log_with({fault_event(ServoEvent::Kind::latched)}, &unwritable),
              testing::HasSubstr("the latched fault could not be saved, so a restart would reset it: cannot write /proc/nowhere/latched"));
}

}  // namespace
}  // namespace hapton
