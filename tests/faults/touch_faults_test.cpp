// A node dies or freezes, or the network is cut, while the force comes from the haptics node, or from patches beside the device: one table
// for both. Times are simulated; only the threads that send and build patches run in real time.
#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "tests/faults/simulated_system.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

constexpr std::int64_t kServoCycleNs = kMs;
// The force must end 20 ms after the sample that the last force replies to. From patches it may last kMaxSilenceNs longer.
constexpr std::int64_t kRemoteReleaseNs = 20 * kMs + kServoCycleNs;

struct FaultRow {
  std::string name;
  std::function<void(SimulatedSystem&)> begin;
  std::int64_t lasts_ns = 0;
  std::function<void(SimulatedSystem&)> end = [](SimulatedSystem&) {};
  std::int64_t felt_after_ns = 500 * kMs;  // after end(): by then there is a force again
  bool takes_haptics_away = true;          // false: the force continues
};

void cut(SimulatedSystem& system, bool up, bool down) { system.set_faults({.partition = up}, {.partition = down}); }
void freeze_haptics(SimulatedSystem& system, bool is_frozen) { system.network.freeze(system.haptics->address(), is_frozen); }

// Moves the scene by one millimetre along x and turns it by a degree about z: the hand stays 2 mm deep.
void move_scene(SimulatedSystem& system) {
  ViewTransform view;
  const double angle = 0.0175;
  view.X_WS = {static_cast<float>(std::cos(angle)),
               static_cast<float>(-std::sin(angle)),
               0.0F,
               0.001F,
               static_cast<float>(std::sin(angle)),
               static_cast<float>(std::cos(angle)),
               0.0F,
               0.0F,
               0.0F,
               0.0F,
               1.0F,
               0.0F};
  view.revision = 2;
  system.send_view(view);
}

std::vector<FaultRow> fault_rows() {
  const auto kill = [](SimulatedSystem& s) { s.kill_haptics(); };
  const auto start = [](SimulatedSystem& s) { s.start_haptics(); };
  return {
      {"haptics killed for a moment", kill, 40 * kMs, start},
      {"haptics killed, then started again", kill, 1500 * kMs, start},
      {"haptics stopped for a moment", [](SimulatedSystem& s) { freeze_haptics(s, true); }, 100 * kMs,
       [](SimulatedSystem& s) { freeze_haptics(s, false); }},
      {"haptics stopped, then continued", [](SimulatedSystem& s) { freeze_haptics(s, true); }, 3000 * kMs,
       [](SimulatedSystem& s) { freeze_haptics(s, false); }},
      {"the network cut for a moment", [](SimulatedSystem& s) { cut(s, true, true); }, 100 * kMs,
       [](SimulatedSystem& s) { cut(s, false, false); }},
      {"the network cut", [](SimulatedSystem& s) { cut(s, true, true); }, 3000 * kMs, [](SimulatedSystem& s) { cut(s, false, false); }},
      {"the network cut towards the hub", [](SimulatedSystem& s) { cut(s, true, false); }, 3000 * kMs,
       [](SimulatedSystem& s) { cut(s, false, false); }},
      {"the hub started again", [](SimulatedSystem& s) { s.start_hub(); }, 0},
      {"the hub stopped, then continued", [](SimulatedSystem& s) { s.network.run_nodes_until(s.clock.now_ns() + 700 * kMs); }, 0,
       [](SimulatedSystem&) {}, 1500 * kMs},
      {"the scene moved", move_scene, 1000 * kMs, [](SimulatedSystem&) {}, 500 * kMs, false},
  };
}

// Runs until the hand is pressed in and feels the full force; with patches, until the patches compute it.
void press_in(SimulatedSystem& system, TouchChoice touch) {
  system.start_haptics();
  system.run_for_ns(500 * kMs);
  ASSERT_NEAR(system.force_n().z(), 2.0, 0.05) << "the remote force goes on until a patch is there";
  ASSERT_TRUE(touch == TouchChoice::remote || system.wait_for_patches());
}

void expect_within_limits(const PressingDevice& device) {
  const PressingDevice::Written* last = nullptr;
  for (const auto& written : device.written) {
    ASSERT_TRUE(written.force_n.allFinite());
    ASSERT_LE(written.force_n.norm(), device.limits().max_force_n + 1e-9);
    if (last != nullptr) {
      const double passed_s = 1e-9 * static_cast<double>(std::max(written.time_ns - last->time_ns, std::int64_t{0}));
      ASSERT_LE((written.force_n - last->force_n).norm(), device.limits().max_slew_n_per_s * passed_s + 1e-9);
    }
    last = &written;
  }
}

void run_row(const FaultRow& row, TouchChoice touch) {
  SCOPED_TRACE(row.name + (touch == TouchChoice::patch ? ", by patches" : ", remote"));
  SimulatedSystem system(1, touch);
  ASSERT_NO_FATAL_FAILURE(press_in(system, touch));
  const std::int64_t release_ns = kRemoteReleaseNs + (touch == TouchChoice::patch ? PatchLink::kMaxSilenceNs : 0);
  const std::int64_t fault_begin_ns = system.clock.now_ns();
  row.begin(system);
  system.run_for_ns(row.lasts_ns);
  if (row.takes_haptics_away && row.lasts_ns > 0) {
    const auto zero_ns = system.zero_since_ns();
    EXPECT_EQ(zero_ns.has_value(), row.lasts_ns > release_ns);
    // The last datagram of the haptics node came up to one cycle before `fault_begin_ns`.
    EXPECT_LE(zero_ns.value_or(fault_begin_ns) - fault_begin_ns, release_ns);
  }
  row.end(system);
  const std::int64_t fault_end_ns = system.clock.now_ns();
  system.run_for_ns(row.felt_after_ns + 500 * kMs);
  const auto force_ns = system.force_after_ns(fault_end_ns + 1);
  ASSERT_TRUE(force_ns.has_value());
  EXPECT_LE(*force_ns - fault_end_ns, row.felt_after_ns);
  EXPECT_NEAR(system.force_n().z(), 2.0, 0.05);
  if (touch == TouchChoice::patch) {
    EXPECT_TRUE(system.wait_for_patches()) << "patches take over again";
    EXPECT_NEAR(system.force_n().z(), 2.0, 0.05);
  }
  if (row.name != "the hub started again" && row.name != "the hub stopped, then continued") expect_within_limits(system.device);
  const GovernorStats& governor = system.stats().governor;
  EXPECT_EQ(governor.fault, SafetyFault::none);
  EXPECT_EQ(governor.counters.latched, 0U);
  EXPECT_GT(governor.counters.accepted, 0U) << "the governor is in charge";
}

TEST(TouchFaults, TheForceEndsAndComesBackWhereverItIsComputed) {
  for (const FaultRow& row : fault_rows()) {
    for (const TouchChoice touch : {TouchChoice::remote, TouchChoice::patch}) run_row(row, touch);
  }
}

// Half of all that the haptics node sends is lost, parts of the scene too. The hand is in contact before these parts have arrived.
TEST(TouchFaults, ALossyLinkTakesNoForceAwayUntilPatchesAreThere) {
  SimulatedSystem system(1, TouchChoice::patch);
  system.start_haptics();
  system.run_for_ns(200 * kMs);
  system.set_faults({.loss = 0.5}, {});
  system.run_for_ns(1000 * kMs);
  EXPECT_TRUE(system.wait_for_patches());
  system.run_for_ns(1000 * kMs);
  const std::int64_t pressed_ns = system.device.written.front().time_ns + 400 * kMs;
  for (const auto& written : system.device.written) {
    if (written.time_ns <= pressed_ns) continue;
    ASSERT_GT(written.force_n.z(), 1.9) << 1e-6 * static_cast<double>(written.time_ns - pressed_ns) << " ms";
  }
  EXPECT_EQ(system.stats().governor.counters.command_timeouts, 0U);
}

}  // namespace
}  // namespace hapton
