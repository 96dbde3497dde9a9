// Rows of docs/faults.md: the force when something dies, freezes, or the network is bad. Times are exact: they are simulated.
#include <gtest/gtest.h>

#include <cmath>
#include <string_view>
#include <utility>
#include <vector>

#include "tests/faults/simulated_system.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

constexpr std::int64_t kCycleNs = kMs;

// Every force, from the one with the index `first` on, is within the magnitude limit and the rate limit of the device.
void expect_bounded(const PressingDevice& device, std::size_t first = 0) {
  const DeviceLimits& limits = device.limits();
  const PressingDevice::Written* last = nullptr;
  for (std::size_t n = first; n < device.written.size(); ++n) {
    const PressingDevice::Written& written = device.written[n];
    ASSERT_TRUE(written.force_n.allFinite());
    ASSERT_LE(written.force_n.norm(), limits.max_force_n + 1e-9);
    if (last != nullptr) {
      // The governor steps once a cycle even if nothing changes, so a change of the force takes at least one cycle.
      const double passed_s = 1e-9 * static_cast<double>(std::max(written.time_ns - last->time_ns, std::int64_t{0}));
      ASSERT_LE((written.force_n - last->force_n).norm(), limits.max_slew_n_per_s * passed_s + 1e-9)
          << 1e-6 * static_cast<double>(written.time_ns) << " ms";
    }
    last = &written;
  }
}

struct Faults : testing::Test {
  // Brings the device into contact, with the full force of 2 mm at 1000 N/m: 2 N.
  void press(std::uint64_t seed = 1) {
    system.emplace(seed);
    system->start_haptics();
    system->run_for_ns(500 * kMs);
    ASSERT_NEAR(system->force_n().z(), 2.0, 0.05);
  }
  std::int64_t now_ns() const { return system->clock.now_ns(); }
  std::optional<SimulatedSystem> system;
};

TEST_F(Faults, HapticsKilledInContactLeavesNoForceAfter20Ms) {
  press();
  system->kill_haptics();
  const std::int64_t killed_ns = now_ns();
  system->run_for_ns(200 * kMs);
  const auto zero_ns = system->zero_since_ns();
  ASSERT_TRUE(zero_ns);
  EXPECT_LE(*zero_ns - killed_ns, 20 * kMs + kCycleNs);
  EXPECT_LE(system->stats().longest_release_ns, 20 * kMs + kCycleNs);
  expect_bounded(system->device);
}

TEST_F(Faults, HapticsRestartedInContactExertsForceAgainWithin200Ms) {
  for (const std::int64_t away_ns : {1 * kMs, 40 * kMs, 60 * kMs, 1500 * kMs}) {
    press();
    system->kill_haptics();
    system->run_for_ns(away_ns);
    system->start_haptics();
    const std::int64_t restarted_ns = now_ns();
    system->run_for_ns(1000 * kMs);
    // However short the absence was, a command timeout comes first, because the killed node's slot was still in use.
    const auto force_ns = system->force_after_ns(std::max(restarted_ns, restarted_ns - away_ns + 25 * kMs));
    ASSERT_TRUE(force_ns) << away_ns;
    EXPECT_LE(*force_ns - restarted_ns, 200 * kMs) << away_ns;
    EXPECT_NEAR(system->force_n().z(), 2.0, 0.05) << away_ns;
    expect_bounded(system->device);
  }
}

TEST_F(Faults, HapticsFrozenLeavesNoForceAndThawedRampsItIn) {
  for (const std::int64_t frozen_for_ns : {100 * kMs, 3000 * kMs}) {
    press();
    system->network.freeze(system->haptics->address(), true);
    const std::int64_t frozen_ns = now_ns();
    system->run_for_ns(frozen_for_ns);
    ASSERT_TRUE(system->zero_since_ns());
    EXPECT_LE(*system->zero_since_ns() - frozen_ns, 20 * kMs + kCycleNs);
    system->network.freeze(system->haptics->address(), false);
    const std::int64_t thawed_ns = now_ns();
    system->run_for_ns(1000 * kMs);
    ASSERT_TRUE(system->force_after_ns(thawed_ns)) << frozen_for_ns;
    EXPECT_LE(*system->force_after_ns(thawed_ns) - thawed_ns, 300 * kMs) << frozen_for_ns;
    EXPECT_NEAR(system->force_n().z(), 2.0, 0.05);
    expect_bounded(system->device);
  }
}

TEST_F(Faults, HubRestartedIsFoundAgainWithin500Ms) {
  press();
  system->start_hub();
  const std::int64_t restarted_ns = now_ns();
  const std::size_t before = system->device.written.size();
  system->run_for_ns(1000 * kMs);
  ASSERT_TRUE(system->force_after_ns(restarted_ns + 1));
  EXPECT_LE(*system->force_after_ns(restarted_ns + 1) - restarted_ns, 500 * kMs);
  EXPECT_NEAR(system->force_n().z(), 2.0, 0.05);
  // The new hub's first force is the first step of its own ramp.
  ASSERT_GT(system->device.written.size(), before);
  EXPECT_LT(system->device.written[before].force_n.norm(), 0.1);
}

TEST_F(Faults, HubFrozenAndThawedGoesOnWithARamp) {
  for (const std::int64_t frozen_for_ns : {30 * kMs, 700 * kMs, 5000 * kMs}) {
    press();
    const std::size_t before = system->device.written.size();
    system->network.run_nodes_until(now_ns() + frozen_for_ns);
    system->run_for_ns(1500 * kMs);
    EXPECT_NEAR(system->force_n().z(), 2.0, 0.05) << frozen_for_ns;
    // The first force that is written is not the one from before the gap, which is too old by now: the ramp begins at zero.
    ASSERT_GT(system->device.written.size(), before);
    EXPECT_EQ(system->device.written[before].force_n, Vec3(Vec3::Zero()));
    expect_bounded(system->device, before);
    EXPECT_GT(system->stats().missed_cycles, 0U);
  }
}

// The forces on the motors, to the last bit, and their times.
std::vector<std::pair<double, std::int64_t>> force_of(const PressingDevice& device) {
  std::vector<std::pair<double, std::int64_t>> force;
  for (const auto& written : device.written) force.emplace_back(written.force_n.z(), written.time_ns);
  return force;
}

TEST_F(Faults, NoVisionNodeChangesAForceWhateverBecomesOfIt) {
  press();
  system->run_for_ns(2500 * kMs);
  const auto alone = force_of(system->device);
  for (const int acks_per_state : {1, 20}) {
    for (const char* fate : {"lives", "is killed", "is frozen"}) {
      system.emplace(1);
      system->start_haptics();
      const auto vision = system->make_vision(acks_per_state);
      system->run_for_ns(1000 * kMs);
      EXPECT_GT(vision->received_states(), 100) << fate;
      if (fate == std::string_view("is killed")) system->network.kill(vision->address());
      if (fate == std::string_view("is frozen")) system->network.freeze(vision->address(), true);
      system->run_for_ns(1000 * kMs);
      if (fate == std::string_view("is frozen")) system->network.freeze(vision->address(), false);
      system->run_for_ns(1000 * kMs);
      EXPECT_EQ(force_of(system->device), alone) << acks_per_state << " acknowledgements of each state, " << fate;
      EXPECT_GT(system->stats().drawn, 100U);
    }
  }
}

TEST_F(Faults, AStormLeavesTheForceBoundedAndTheSessionAlive) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    press(seed);
    const LinkFaults storm{.jitter_ns = 20 * kMs, .loss = 0.3, .burst_share = 0.05, .reorder = 0.1, .duplicate = 0.1, .corrupt = 0.05};
    system->set_faults(storm, storm);
    system->run_for_ns(5000 * kMs);
    expect_bounded(system->device);
    EXPECT_GT(system->stats().forces, 0U);
    system->set_faults({}, {});
    system->run_for_ns(1000 * kMs);
    EXPECT_NEAR(system->force_n().z(), 2.0, 0.05) << "seed " << seed;
  }
}

TEST_F(Faults, JitterAloneWithinTheCommandTimeoutKeepsTheContact) {
  press();
  system->set_faults({.jitter_ns = 5 * kMs}, {.jitter_ns = 5 * kMs});
  const std::uint64_t command_timeouts = system->stats().governor.counters.command_timeouts;
  system->run_for_ns(3000 * kMs);
  EXPECT_EQ(system->stats().governor.counters.command_timeouts, command_timeouts);
  EXPECT_NEAR(system->force_n().z(), 2.0, 0.05);
}

TEST_F(Faults, APartitionLeavesNoForceAndContactReturnsWithin500MsOfItsEnd) {
  for (const std::int64_t cut_for_ns : {100 * kMs, 600 * kMs, 3000 * kMs}) {
    press();
    system->set_faults({.partition = true}, {.partition = true});
    const std::int64_t cut_ns = now_ns();
    system->run_for_ns(cut_for_ns);
    ASSERT_TRUE(system->zero_since_ns());
    EXPECT_LE(*system->zero_since_ns() - cut_ns, 20 * kMs + kCycleNs);
    system->set_faults({}, {});
    const std::int64_t mended_ns = now_ns();
    system->run_for_ns(1500 * kMs);
    ASSERT_TRUE(system->force_after_ns(mended_ns)) << cut_for_ns;
    EXPECT_LE(*system->force_after_ns(mended_ns) - mended_ns, 500 * kMs) << cut_for_ns;
    EXPECT_NEAR(system->force_n().z(), 2.0, 0.05);
    expect_bounded(system->device);
  }
}

TEST_F(Faults, APartitionInOneDirectionIsSurvivedToo) {
  for (const bool is_to_hub : {true, false}) {
    press();
    const LinkFaults cut{.partition = true};
    system->set_faults(is_to_hub ? cut : LinkFaults(), is_to_hub ? LinkFaults() : cut);
    system->run_for_ns(3000 * kMs);
    EXPECT_TRUE(system->zero_since_ns());
    system->set_faults({}, {});
    system->run_for_ns(1500 * kMs);
    EXPECT_NEAR(system->force_n().z(), 2.0, 0.05) << (is_to_hub ? "to the hub" : "to the nodes");
    expect_bounded(system->device);
  }
}

// A node compares only times of the same clock, so a step of another node's clock makes no difference to the force.
TEST_F(Faults, AClockStepAtTheHapticsNodeDoesNotChangeTheForce) {
  press();
  for (const std::int64_t step_ns : {3600'000'000'000LL, -7200'000'000'000LL, 1LL, -1'000'000LL}) {
    system->haptics->clock.step_ns(step_ns);
    const std::uint64_t command_timeouts = system->stats().governor.counters.command_timeouts;
    const std::uint64_t forces = system->stats().forces;
    system->run_for_ns(1500 * kMs);
    EXPECT_EQ(system->stats().governor.counters.command_timeouts, command_timeouts) << step_ns;
    EXPECT_NEAR(static_cast<double>(system->stats().forces - forces), 1500.0, 5.0) << step_ns;
    EXPECT_NEAR(system->force_n().z(), 2.0, 0.05) << step_ns;
  }
  expect_bounded(system->device);
}

// The machine of the hub sleeps for an hour: its clock jumps, and the last force is not held.
TEST_F(Faults, AClockStepAtTheHubReleasesTheForceAndStartsAgain) {
  press();
  const std::size_t before = system->device.written.size();
  system->clock.advance_ns(3600'000'000'000LL);
  system->run_for_ns(2000 * kMs);
  EXPECT_NEAR(system->force_n().z(), 2.0, 0.05);
  // The force was zero within the first cycles.
  bool was_zero = false;
  for (std::size_t n = before; n < before + 5 && n < system->device.written.size(); ++n) {
    was_zero = was_zero || system->device.written[n].force_n == Vec3::Zero();
  }
  EXPECT_TRUE(was_zero);
}

// The keys change twice a second instead of every two minutes. The force is the same to the last bit as with one key for the whole time.
TEST_F(Faults, AChangeOfKeysInContactDoesNotChangeTheForce) {
  std::vector<std::vector<PressingDevice::Written>> written;
  for (const std::int64_t every_ns : {SealedClient::kRekeyEveryNs, 500 * kMs}) {
    SealedClient::Options sealing;
    sealing.rekey_every_ns = every_ns;
    system.emplace(1);
    system->start_haptics(sealing);
    system->run_for_ns(500 * kMs);
    ASSERT_NEAR(system->force_n().z(), 2.0, 0.05);
    const ResponseTracker::Counts before = system->stats().responses;
    system->run_for_ns(10'000 * kMs);
    const ServoStats& stats = system->stats();
    EXPECT_EQ(stats.responses.late, before.late);
    EXPECT_EQ(stats.responses.lost, before.lost);
    EXPECT_EQ(stats.governor.counters.command_timeouts, 0U);
    EXPECT_EQ(system->haptics->sessions() > 15, every_ns == 500 * kMs);
    written.push_back(system->device.written);
  }
  ASSERT_EQ(written[0].size(), written[1].size());
  for (std::size_t n = 0; n < written[0].size(); ++n) ASSERT_EQ(written[0][n].force_n, written[1][n].force_n) << n;
}

// A handshake is captured on the network and sent again 200 times per cycle, from the node's own address and from others.
TEST_F(Faults, HundredsOfReplayedHandshakesACycleDoNotChangeTheForce) {
  press();
  const LinkKey key = system->key();
  ClientHandshake node(RoleKey(key, KeyRole::haptics), 9, AgreementWorker::Where::caller);
  node.begin();
  node.start_request(1);
  std::vector<std::byte> request(seal::kRequestBytes);
  ASSERT_EQ(node.poll(request), ClientHandshake::Finished::request);
  const ResponseTracker::Counts before = system->stats().responses;
  const std::uint64_t sent = system->stats().seal.retries;
  for (int cycle = 0; cycle < 1000; ++cycle) {
    for (int n = 0; n < 200; ++n) {
      Address from = system->haptics->address();
      from.port = static_cast<std::uint16_t>(from.port + n % 3);
      system->network.inject(from, request);
    }
    system->run_for_ns(kCycleNs);
  }
  const ServoStats& stats = system->stats();
  EXPECT_EQ(stats.seal.retries, sent + 1) << "once it was new";
  EXPECT_GT(stats.seal.replayed_handshakes, 100'000U);
  EXPECT_EQ(stats.governor.counters.command_timeouts, 0U);
  EXPECT_EQ(stats.responses.lost, before.lost);
  EXPECT_EQ(stats.seal.handshakes, 1U);
}

TEST_F(Faults, HundredsOfJunkDatagramsACycleDoNotChangeTheForce) {
  press();
  std::vector<std::byte> junk(100);
  std::uint64_t salt = 0;
  for (int cycle = 0; cycle < 1000; ++cycle) {
    for (int n = 0; n < 100; ++n) {
      for (std::byte& byte : junk) byte = static_cast<std::byte>(++salt * 2654435761U >> 13);
      system->network.inject({{9, 9}, static_cast<std::uint16_t>(salt)}, junk);
    }
    system->run_for_ns(kMs);
  }
  EXPECT_NEAR(system->force_n().z(), 2.0, 0.05);
  EXPECT_EQ(system->stats().governor.counters.command_timeouts, 0U);
  EXPECT_GT(system->stats().seal.rejected(), 90'000U);
}

}  // namespace
}  // namespace hapton
