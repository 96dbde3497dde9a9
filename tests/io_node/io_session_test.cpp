// Both sides in their threads, over real sockets, with a haptics node in this one's stead.
#include "io_node/io_session.h"

#include <gtest/gtest.h>

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
#include "link/hub_client.h"
#include "link/random_id.h"
#include "link/udp_endpoint.h"
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
  // On a busy machine the haptics node may come too late for a short session.
  for (; forces == 0 && options.seconds < 30.0; options.seconds *= 2.0) {
    SimulatedPhantom device({});
    const std::int64_t begin_ns = clock.now_ns();
    const auto ended = run(device);
    ASSERT_TRUE(ended) << ended.error().what;
    EXPECT_GE(clock.now_ns() - begin_ns, static_cast<std::int64_t>(1e9 * options.seconds));
  }
  EXPECT_GT(forces, 0U);
  EXPECT_NE(report().find("\"round_trip\""), std::string::npos);
  EXPECT_TRUE(std::filesystem::exists(folder / "latency.csv"));
}

TEST_F(Sessions, EndsWithItsRecording) {
  options.seconds = 0.0;
  ReplayDevice device({{0.0, Vec3::Zero(), Quat::Identity()}, {0.1, Vec3::UnitX(), Quat::Identity()}}, {});
  EXPECT_TRUE(run(device));
}

// Is away and being calibrated for 100 reads each, is there until a force has been written, and then its recording is over.
class Wayward final : public Device {
 public:
  std::string_view name() const noexcept override { return "wayward"; }
  const DeviceLimits& limits() const noexcept override { return phantom_.limits(); }
  DeviceSample read(std::int64_t now_ns) noexcept override {
    ++reads_;
    return phantom_.read(now_ns);
  }
  void write(const Wrench& wrench, std::int64_t now_ns) noexcept override {
    if (wrench.force_n != Vec3::Zero()) ++(reads_ < 200 ? forces_before : forces_after);
    phantom_.write(wrench, now_ns);
  }
  DeviceStatus status() const noexcept override {
    if (reads_ < 100) return DeviceStatus::away;
    if (reads_ < 200) return DeviceStatus::calibrating;
    return forces_after == 0 ? DeviceStatus::ready : DeviceStatus::ended;
  }
  bool set_hand_target(const std::optional<Vec3>&) noexcept override { return false; }

  int forces_before = 0;
  int forces_after = 0;

 private:
  SimulatedPhantom phantom_{{}};
  int reads_ = 0;
};

TEST_F(Sessions, GoesOnWhileTheDeviceIsAwayOrBeingCalibrated) {
  options.seconds = 0.0;
  Wayward device;
  EXPECT_TRUE(run(device));
  EXPECT_EQ(device.forces_before, 0);
  EXPECT_GT(device.forces_after, 0);
}

// Replies late once.
class Stumbling final : public Device {
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
  Stumbling device;
  const auto ended = run(device, {.overrun = OverrunPolicy::stop});
  ASSERT_FALSE(ended);
  EXPECT_NE(ended.error().what.find("a cycle was missed"), std::string::npos) << ended.error().what;
}

TEST_F(Sessions, EndsOnRequestAndReportsOnRequest) {
  options.seconds = 0.0;
  SimulatedPhantom device({});
  std::atomic<bool> seen{false};
  std::thread asker([&] {
    // A request from before the session began is of no session.
    seen = wait_until([&] {
      std::raise(SIGUSR1);
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      return std::filesystem::exists(folder / "report.json");
    });
    stop.request_stop();
  });
  EXPECT_TRUE(run(device));
  asker.join();
  EXPECT_TRUE(seen);
}

TEST_F(Sessions, AReportThatCannotBeWrittenIsAnError) {
  options.out = "/proc/nowhere";
  options.seconds = 0.1;
  SimulatedPhantom device({});
  const auto ended = run(device);
  ASSERT_FALSE(ended);
  EXPECT_NE(ended.error().what.find("/proc/nowhere"), std::string::npos);
}

}  // namespace
}  // namespace hapton
