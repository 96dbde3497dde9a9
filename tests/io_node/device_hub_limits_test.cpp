// The limits that a person gives io_node to protect the hand take effect: nothing else would notice a flag that is lost on the way.
#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "devices/device.h"
#include "io_node/device_hub.h"
#include "link/hub_client.h"
#include "link/link_key.h"
#include "link/sealed_client.h"
#include "link/session_reader.h"
#include "link/udp_endpoint.h"
#include "runtime/stop_signal.h"
#include "tests/support/patience.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

// A haptics node that replies to every sample with the same wrench until it is destroyed.
class SteadyPusher {
 public:
  SteadyPusher(const Address& hub, const RoleKey& key, const Wrench& wrench)
      : thread_([this, hub, key, wrench] { run(hub, key, wrench); }) {}
  ~SteadyPusher() {
    stop_ = true;
    thread_.join();
  }
  SteadyPusher(const SteadyPusher&) = delete;
  SteadyPusher& operator=(const SteadyPusher&) = delete;
  int replies() const { return replies_; }

 private:
  void run(const Address& hub, const RoleKey& key, const Wrench& wrench) {
    SteadyClock clock;
    const auto endpoint = open_udp_endpoint("127.0.0.1:0");
    SealedClient sealed(**endpoint, clock, key, hub);
    HubClient client(sealed, clock, NodeRole::haptics, hub);
    Datagram datagram;
    while (!stop_) {
      if (!client.receive(datagram, clock.now_ns() + 10 * kMs)) continue;
      const auto* state = std::get_if<DeviceState>(&datagram.message);
      if (state == nullptr) continue;
      ForceCommand command;
      command.echo_sample = state->sample;
      command.echo_sample_time_ns = state->sample_time_ns;
      command.force_n = wrench.force_n;
      command.torque_nm = wrench.torque_nm;
      command.contact = true;
      client.send(command);
      ++replies_;
    }
  }

  std::atomic<bool> stop_{false};
  std::atomic<int> replies_{0};
  std::thread thread_;  // declared last, because it uses the others
};

struct DeviceHubLimits : testing::Test {
  void SetUp() override {
    ASSERT_TRUE(make_key_file(scratch.path() / "key"));
    options.key_file = (scratch.path() / "key").string();
    options.bind = "127.0.0.1:0";
    options.flight = "off";
    options.out = (scratch.path() / "out").string();
    options.realtime.mode = RealtimeMode::off;
    options.watchdog = RealtimeMode::off;
    options.touch = TouchChoice::remote;
  }

  // A recording that moves along z by 50 mm/s, longer than any test, with these buttons down.
  void replay(std::uint32_t buttons) {
    const std::string rows = fmt::format("t_s,x_m,y_m,z_m,buttons\n0,0,0,0,{0}\n1000,0,0,50,{0}\n", buttons);
    options.device.name = "replay";
    options.device.trajectory = scratch.write("hand.csv", rows).string();
  }
  nlohmann::json report() const {
    std::ifstream file(scratch.path() / "out" / "report.json");
    return nlohmann::json::parse(file, nullptr, false);
  }
  nlohmann::json report_of_a_short_run() {
    options.seconds = 0.1;
    const StopSignal stop;
    const auto hub = DeviceHub::open(options, clock);
    EXPECT_TRUE(hub && (*hub)->run(stop));
    return report();
  }
  // The report of a run in which a haptics node has replied at least 300 times with this wrench.
  nlohmann::json report_while_pushed(const Wrench& wrench) {
    StopSignal stop;
    const auto hub = DeviceHub::open(options, clock);
    const auto key = read_role_key_file(options.key_file, KeyRole::haptics);
    EXPECT_TRUE(hub && key);
    if (!hub || !key) return {};
    std::thread running([&] { EXPECT_TRUE((*hub)->run(stop)); });
    {
      const SteadyPusher node((*hub)->address(), *key, wrench);
      EXPECT_TRUE(wait_until([&] { return node.replies() >= 300; }));
    }
    stop.request_stop();
    running.join();
    return report();
  }
  static double note(const nlohmann::json& report, const char* name) { return std::stod(report.at("notes").at(name).get<std::string>()); }

  ScratchFolder scratch;
  SteadyClock clock;
  IoOptions options;
};

TEST_F(DeviceHubLimits, AForceLimitOfZeroIsNoForceAtAll) {
  options.device.max_force_n = 0.0;
  const auto hub = DeviceHub::open(options, clock);
  ASSERT_TRUE(hub) << hub.error().what;
  EXPECT_THAT((*hub)->describe(), testing::HasSubstr("at most 0.00 N"));
}

// The simulated hand presses no button.
TEST_F(DeviceHubLimits, TheDeadMansSwitchHasToBeHeld) {
  EXPECT_EQ(report_of_a_short_run().at("notes").at("governor"), "no command");
  options.device.dead_mans_switch = 2;
  EXPECT_EQ(report_of_a_short_run().at("notes").at("governor"), "switch released");
}

TEST_F(DeviceHubLimits, TheClutchHoldsTheDevicePoint) {
  replay(2);
  options.device.clutch_button = 2;
  options.record = (scratch.path() / "session.hapton").string();
  (void)report_of_a_short_run();
  auto reader = SessionReader::open(options.record);
  ASSERT_TRUE(reader) << reader.error().what;
  std::vector<double> z_m;
  for (SessionEntry entry; reader->next(entry);) {
    if (entry.kind == SessionEntry::Kind::cycle && entry.cycle.device) z_m.push_back(entry.cycle.device->p_WD.z());
  }
  ASSERT_GT(z_m.size(), 1U);
  EXPECT_EQ(z_m.back(), z_m.front());
}

TEST_F(DeviceHubLimits, ATorqueIsWithinItsLimit) {
  options.device.name = "simulated-6dof";
  options.device.max_torque_nm = 0.05;
  const auto pushed = report_while_pushed({.torque_nm = Vec3(0.1, 0.0, 0.0)});
  EXPECT_GT(note(pushed, "max_torque_written_nm"), 0.0);
  EXPECT_LE(note(pushed, "max_torque_written_nm"), 0.0501);
}

TEST_F(DeviceHubLimits, AForceRisesNoFasterThanItsLimit) {
  replay(0);
  options.device.max_slew_n_per_s = 1.0;
  const auto pushed = report_while_pushed({.force_n = Vec3(2.0, 0.0, 0.0)});
  EXPECT_GT(note(pushed, "max_force_written_n"), 0.0);
  EXPECT_LE(note(pushed, "max_force_written_n"), 1.0 * pushed.at("seconds").get<double>() + 1e-3);
}

// The recorded hand moves in the direction of the force, so the force gives it energy in every cycle.
TEST_F(DeviceHubLimits, ThePassivityControllerIsOnWhereAMassIsGiven) {
  replay(0);
  for (const double mass_kg : {0.0, 0.075}) {
    options.device.passive_mass_kg = mass_kg;
    const auto pushed = report_while_pushed({.force_n = Vec3(0.0, 0.0, 1.0)});
    EXPECT_EQ(pushed.at("counters").at("passivity_limited").get<int>() > 0, mass_kg > 0.0);
  }
}

}  // namespace
}  // namespace hapton
