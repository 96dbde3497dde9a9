#include "closed_loop/loop_simulation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "closed_loop/stability.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

struct Loop {
  Loop(const LoopSimulation::Options& options, const ForceChain::Options& link, const WallLaw::Wall& wall)
      : law(wall), chain(law, link), simulation(chain, options) {}

  WallLaw law;
  ForceChain chain;
  LoopSimulation simulation;
};

// Runs for a while, and returns the largest distance from zero; infinite: the motion diverged.
double largest_distance_m(LoopSimulation& simulation, std::int64_t duration_ns) {
  std::vector<LoopRow> rows;
  if (!simulation.run_until(simulation.now_ns() + duration_ns, &rows)) return HUGE_VAL;
  double largest_m = 0.0;
  for (const LoopRow& row : rows) largest_m = std::max(largest_m, std::fabs(row.p_WD.x()));
  return largest_m;
}

// With a two-sided wall, without quantisation and friction, the loop is linear: the motion decays below the limit and grows above it.
TEST(LoopSimulation, AgreesWithTheExactLimit) {
  for (const double delay_ms : {0.0, 0.3, 2.0, 10.4}) {
    const DeviceModel device{.mass_kg = 0.225, .damping_ns_per_m = 5.0};
    const HandModel hand{.stiffness_n_per_m = 500.0};
    const double limit = find_stable_stiffness(SampledPlant(make_axis_plant(device, hand), 1e-3, 1e-3 * delay_ms), 0.0).value;
    for (const double share : {0.995, 1.005}) {
      ForceChain::Options link;
      link.to_law.delay_ns = static_cast<std::int64_t>(0.5e6 * delay_ms);
      link.from_law.delay_ns = static_cast<std::int64_t>(1e6 * delay_ms) - link.to_law.delay_ns;
      Loop loop({.device = device, .hand = hand, .start_m = Vec3(1e-3, 0.0, 0.0)}, link,
                {.stiffness_n_per_m = share * limit, .two_sided = true});
      largest_distance_m(loop.simulation, 2000 * kMs);
      const double before = largest_distance_m(loop.simulation, 3000 * kMs);
      const double after = largest_distance_m(loop.simulation, 3000 * kMs);
      EXPECT_EQ(after > before, share > 1.0) << delay_ms << " ms, " << share;
    }
  }
}

TEST(LoopSimulation, TheSameSeedGivesTheSameRows) {
  const auto run = [](std::uint64_t seed) {
    ForceChain::Options link{.seed = seed};
    link.to_law = {.delay_ns = 3 * kMs, .jitter_ns = 5 * kMs, .loss = 0.2, .reorder = 0.1};
    link.from_law = link.to_law;
    Loop loop({.device = find_device_preset("touch")->model, .hand = *find_hand_preset("light"), .start_m = Vec3(-1e-3, 0.0, 0.0)}, link,
              {});
    std::vector<LoopRow> rows;
    loop.simulation.run_until(500 * kMs, &rows);
    EXPECT_GT(loop.chain.counters().lost, 0U);
    EXPECT_GT(loop.chain.counters().overtaken, 0U);
    return rows.back().p_WD.x();
  };
  EXPECT_EQ(run(1), run(1));
  EXPECT_NE(run(1), run(2));
}

TEST(LoopSimulation, TheGovernorLimitsWhatAnUnstableWallDoes) {
  const DevicePreset& preset = *find_device_preset("premium-1.5");
  ForceChain::Options link{.max_force_n = preset.limits.max_force_n, .gate = ForceChain::Gate::governor, .limits = preset.limits};
  link.to_law.delay_ns = 10 * kMs;
  Loop loop({.device = preset.model, .hand = *find_hand_preset("stylus"), .start_m = Vec3(1e-3, 0.0, 0.0)}, link,
            {.stiffness_n_per_m = 20'000.0, .two_sided = true});
  std::vector<LoopRow> rows;
  EXPECT_TRUE(loop.simulation.run_until(2000 * kMs, &rows));
  ASSERT_NE(loop.chain.governor(), nullptr);
  EXPECT_GT(loop.chain.governor()->counters().accepted, 100U);
  for (const LoopRow& row : rows) ASSERT_LE(row.force_n.norm(), preset.limits.max_force_n * (1.0 + 1e-9));
}

TEST(LoopSimulation, TheCommandFilterReleasesAnOldForce) {
  ForceChain::Options link{.gate = ForceChain::Gate::filter};
  link.to_law.delay_ns = 30 * kMs;  // on arrival, samples are older than the command timeout
  Loop loop({.device = find_device_preset("touch")->model, .hand = *find_hand_preset("stylus"), .start_m = Vec3(-1e-3, 0.0, 0.0)}, link,
            {});
  std::vector<LoopRow> rows;
  loop.simulation.run_until(200 * kMs, &rows);
  for (const LoopRow& row : rows) ASSERT_EQ(row.force_n.x(), 0.0);
}

}  // namespace
}  // namespace hapton
