// The governor between a wall and the simulated PHANToM with a hand on it: it leaves a normal contact unchanged, and bounds the energy that
// a source gives.
#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <functional>

#include "devices/model_a.h"
#include "devices/simulated_phantom.h"
#include "safety/safety_governor.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

struct Touch {
  double contact_s = 0.0;
  double requested_n2 = 0.0;  // sum of squares of the requested force, in contact
  double error_n2 = 0.0;      // sum of squares of the missing part
  double most_error_n = 0.0;
  double given_j = 0.0;       // given to the hand, in all, at the exact position
  double most_given_j = 0.0;  // the most in any span of time
};

using Source = std::function<Vec3(const Vec3& p_WD, const Vec3& v)>;

// Runs at 1 kHz. Each force is written 100 us after a sample, and is the reply to the sample `lag` samples before it.
Touch touch(SafetyGovernor* governor, const Source& source, double seconds, std::uint64_t seed, std::size_t lag = 0) {
  SimulatedPhantom device({.seed = seed, .stylus = {}});
  Touch result;
  std::deque<WrenchCommand> replies;
  Wrench written;
  Vec3 last_exact = device.exact_position_m();
  Vec3 last_p_WD = last_exact;
  double least_given_j = 0.0;
  for (int n = 0; n < static_cast<int>(1000.0 * seconds); ++n) {
    const std::int64_t now_ns = 1'000'000'000 + n * kMs;
    const DeviceSample sample = device.read(now_ns);
    const Vec3 exact = device.exact_position_m();
    result.given_j += written.force_n.dot(exact - last_exact);
    last_exact = exact;
    least_given_j = std::min(least_given_j, result.given_j);
    result.most_given_j = std::max(result.most_given_j, result.given_j - least_given_j);
    const Vec3 v = (sample.p_WD - last_p_WD) * 1000.0;
    last_p_WD = sample.p_WD;
    replies.push_back({{.force_n = source(sample.p_WD, v)}, sample.time_ns});
    const std::int64_t write_ns = now_ns + 100'000;
    const Vec3 requested_n = replies.front().wrench.force_n;
    if (governor != nullptr) {
      governor->observe(sample, device.status());
      written = governor->step(replies.size() > lag ? std::optional(replies.front()) : std::nullopt, write_ns);
    } else {
      written.force_n = requested_n;
      if (requested_n.norm() > model_a::kMaxForceN) written.force_n *= model_a::kMaxForceN / requested_n.norm();
    }
    if (replies.size() > lag) replies.pop_front();
    device.write(written, write_ns);
    if (n < 200 || requested_n == Vec3::Zero()) continue;  // without the ramp-up
    result.contact_s += 1e-3;
    const double error_n = (written.force_n - requested_n).norm();
    result.requested_n2 += requested_n.squaredNorm();
    result.error_n2 += error_n * error_n;
    result.most_error_n = std::max(result.most_error_n, error_n);
  }
  return result;
}

Source wall(double stiffness_n_per_m) {
  return [=](const Vec3& p_WD, const Vec3&) { return Vec3(0, 0, std::max(0.0, -stiffness_n_per_m * p_WD.z())); };
}

// Negative damping: accelerates every motion.
Source pump(double gain_n_s_per_m) {
  return [=](const Vec3&, const Vec3& v) { return Vec3(gain_n_s_per_m * v); };
}

TEST(GovernedTouch, AWallOf1000NewtonsAMetreIsRenderedUnchanged) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    SafetyGovernor governor(model_a::limits());
    const Touch output = touch(&governor, wall(1000.0), 30.0, seed);
    EXPECT_GT(output.contact_s, 10.0);
    EXPECT_LT(std::sqrt(output.error_n2 / output.requested_n2), 1e-6) << seed;
    EXPECT_LT(output.most_error_n, 1e-6) << seed;
    const GovernorCounters& counters = governor.counters();
    EXPECT_EQ(counters.damped + counters.speed_limited + counters.workspace_limited + counters.thermal_limited + counters.latched, 0U);
    // The governor is far from using up its energy or thermal budget, too.
    EXPECT_LT(governor.energy_spent_j(), 0.0);
    EXPECT_LT(governor.thermal_load(), 0.2);
  }
}

TEST(GovernedTouch, AWallOf1000NewtonsAMetreIsNotDampedWhenTheRepliesAreLate) {
  for (const std::size_t lag : {1U, 3U}) {
    SafetyGovernor governor(model_a::limits());
    touch(&governor, wall(1000.0), 20.0, 1, lag);
    EXPECT_EQ(governor.counters().damped, 0U) << lag;
  }
}

constexpr PassivityController::Mechanics kStylus = {.mass_kg = 0.075, .damping_ns_per_m = 0.0, .friction_n = 0.04};

TEST(GovernedTouch, APassiveWallIsRenderedAlmostUnchangedUnderThePassivityController) {
  SafetyGovernor governor(model_a::limits());
  governor.keep_passive(kStylus);
  const Touch output = touch(&governor, wall(1000.0), 30.0, 1);
  EXPECT_GT(output.contact_s, 10.0);
  // The simulated stylus dissipates little: 0.1 N s/m and 0.04 N, while sampling adds as much energy as a damping of -0.5 N s/m.
  EXPECT_LT(std::sqrt(output.error_n2 / output.requested_n2), 0.06);
  EXPECT_GT(governor.counters().kept_passive, 0U);
}

TEST(GovernedTouch, AStiffWallWithLateRepliesGivesNothingUnderThePassivityController) {
  for (const double stiffness : {3e3, 3e4, 1e5}) {
    for (const std::size_t lag : {0U, 5U, 15U}) {
      SafetyGovernor without_controller(model_a::limits());
      const Touch uncontrolled = touch(&without_controller, wall(stiffness), 20.0, 1, lag);
      SafetyGovernor with_controller(model_a::limits());
      with_controller.keep_passive(kStylus);
      const Touch controlled = touch(&with_controller, wall(stiffness), 20.0, 1, lag);
      EXPECT_LT(controlled.given_j, 1e-3) << stiffness << " N/m, " << lag << " ms";
      EXPECT_LT(controlled.most_given_j, 0.012) << "what a press stored comes back, no more";
      if (stiffness > 3e3 || lag > 0) {
        EXPECT_GT(uncontrolled.given_j, 0.3) << "without the controller this loop is a source";
      }
    }
  }
}

TEST(GovernedTouch, ASourceOfEnergyIsBounded) {
  constexpr double kSeconds = 20.0;
  for (const double gain : {8.0, 20.0, 100.0}) {
    const Touch ungoverned = touch(nullptr, pump(gain), kSeconds, 1);
    SafetyGovernor governor(model_a::limits());
    const Touch governed = touch(&governor, pump(gain), kSeconds, 1);
    // The bound of energy_budget.h: free energy, maximum of the budget, forgiven energy, and energy of the last force during its release.
    // A tenth more, because the governor sees positions in steps of 32 um, while the test measures the energy at exact positions.
    const double bound_j =
        1.1 * model_a::kMaxForceN *
        (EnergyBudget::kFreeM + EnergyBudget::kMaxM + EnergyBudget::kForgivenMPerS * kSeconds + 0.01 * model_a::kMaxSpeedMPerS);
    EXPECT_LT(governed.most_given_j, bound_j) << gain;
    EXPECT_GT(governor.counters().damped, 100U) << gain;
    EXPECT_GT(ungoverned.most_given_j, 3.0 * governed.most_given_j) << gain;
  }
}

TEST(GovernedTouch, AWallThatBuzzesIsCalmed) {
  // With a delay of ten samples, 1000 N/m are not stable.
  const Touch ungoverned = touch(nullptr, wall(1000.0), 20.0, 1, 10);
  SafetyGovernor governor(model_a::limits());
  const Touch governed = touch(&governor, wall(1000.0), 20.0, 1, 10);
  EXPECT_GT(governor.counters().damped, 100U);
  EXPECT_GT(ungoverned.most_given_j, 3.0 * governed.most_given_j);
}

}  // namespace
}  // namespace hapton
