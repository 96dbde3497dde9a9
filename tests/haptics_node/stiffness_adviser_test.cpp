#include "haptics_node/stiffness_adviser.h"

#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "closed_loop/device_model.h"
#include "closed_loop/hand_model.h"
#include "closed_loop/recommendation.h"
#include "closed_loop/turning_axis.h"
#include "core/geometry/mesh_shapes.h"
#include "runtime/log.h"
#include "tests/support/made_scene.h"

namespace hapton {
namespace {

constexpr LoopFacts kSimulated = {.device = {'s', 'i', 'm', 'u', 'l', 'a', 't', 'e', 'd'}, .servo_rate_hz = 1000.0, .round_trip_s = 0.010F};

// Waits until the adviser has made one complete check that began after this call.
void wait_for_check(const StiffnessAdviser& adviser) {
  const std::uint64_t before = adviser.checks();
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::minutes(2);
  while (adviser.checks() < before + 2) {
    ASSERT_LT(std::chrono::steady_clock::now(), deadline);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

// What an adviser logs about these facts.
std::string log_of(const LargestGains& gains, const std::vector<LoopFacts>& facts) {
  testing::internal::CaptureStderr();
  {
    start_log("haptics_node");
    StiffnessAdviser adviser(gains);
    for (const LoopFacts& one : facts) {
      adviser.note(one);
      wait_for_check(adviser);
    }
  }
  return testing::internal::GetCapturedStderr();
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

TEST(StiffnessAdviser, AdvisesTheSmallestStiffnessOfAllHands) {
  const DevicePreset& model_a = *find_device_preset("model-a");
  const auto advice = advise_stiffness(kSimulated);
  ASSERT_TRUE(advice);
  EXPECT_EQ(advice->by_stiffness.device, model_a.title);
  double least = HUGE_VAL;
  double least_of_loop = HUGE_VAL;
  for (const char* hand : {"light", "stylus", "arm", "firm"}) {
    const Recommendation one = recommend_stiffness(model_a.model, model_a.limits, *find_hand_preset(hand), 1000.0, 0.010);
    least = std::min(least, one.stiffness_n_per_m);
    least_of_loop = std::min(least_of_loop, one.stable_n_per_m / kGainMargin);
  }
  EXPECT_NEAR(advice->safe_n_per_m, least, 1e-6 * least);
  EXPECT_NEAR(advice->loop_n_per_m, least_of_loop, 1e-6 * least_of_loop);
}

TEST(StiffnessAdviser, AdvisesTheSmallestStiffnessOfSeveralDevices) {
  LoopFacts facts = kSimulated;
  facts.device = {'o', 'p', 'e', 'n', 'h', 'a', 'p', 't', 'i', 'c', 's'};
  const auto advice = advise_stiffness(facts);
  ASSERT_TRUE(advice);
  double least = HUGE_VAL;
  double least_of_loop = HUGE_VAL;
  const std::vector<const DevicePreset*> devices = presets_of_device("openhaptics");
  for (const DevicePreset* device : devices) {
    for (const char* hand : {"light", "stylus", "arm", "firm"}) {
      const Recommendation one = recommend_stiffness(device->model, device->limits, *find_hand_preset(hand), facts.servo_rate_hz,
                                                     static_cast<double>(facts.round_trip_s));
      least = std::min(least, one.stiffness_n_per_m);
      least_of_loop = std::min(least_of_loop, one.stable_n_per_m / kGainMargin);
    }
  }
  EXPECT_EQ(advice->safe_n_per_m, least);
  EXPECT_EQ(advice->loop_n_per_m, least_of_loop);
  // Otherwise the smallest could not be distinguished from the first or the last.
  EXPECT_NE(advice->by_stiffness.device, devices.front()->title);
  EXPECT_NE(advice->by_stiffness.device, devices.back()->title);
}

TEST(StiffnessAdviser, HasNoAdviceOnWhatItDoesNotKnow) {
  LoopFacts unknown = kSimulated;
  unknown.device = {'h', 'a', 'p', 'l', 'y'};
  EXPECT_FALSE(advise_stiffness(unknown));
  EXPECT_FALSE(advise_stiffness({}));
  LoopFacts without_rate = kSimulated;
  without_rate.servo_rate_hz = 0.0;
  EXPECT_FALSE(advise_stiffness(without_rate));
}

TEST(StiffnessAdviser, WarnsOnceAndAgainWhenTheLoopIsMuchSlower) {
  LoopFacts slower = kSimulated;
  slower.round_trip_s = 0.050F;
  LoopFacts similar = kSimulated;
  similar.round_trip_s *= 1.1F;
  const std::string log = log_of({.stiffness_n_per_m = 5000.0}, {kSimulated, similar, slower, slower});
  EXPECT_EQ(count(log, "the scene has up to 5000 N/m, but PHANToM Model A at 1000 Hz"), 2U) << log;
  EXPECT_THAT(log, testing::HasSubstr("with forces after 10 ms"));
  EXPECT_THAT(log, testing::HasSubstr("with forces after 50 ms"));
  EXPECT_THAT(log, testing::HasSubstr("hapton loop recommend"));
}

TEST(StiffnessAdviser, WarnsAgainWhenTheDeviceIsServedAtAnotherRate) {
  LoopFacts slower = kSimulated;
  slower.servo_rate_hz = 500.0;
  const std::string log = log_of({.stiffness_n_per_m = 5000.0}, {kSimulated, slower, slower});
  EXPECT_EQ(count(log, "PHANToM Model A at 1000 Hz"), 1U) << log;
  EXPECT_EQ(count(log, "PHANToM Model A at 500 Hz"), 1U) << log;
}

// Where the maker's limit decides, the log must not blame the hand or the delay.
TEST(StiffnessAdviser, NamesTheMakersLimitWhereThatDecides) {
  LoopFacts fast = kSimulated;
  fast.round_trip_s = 1e-4F;
  const auto advice = advise_stiffness(fast);
  ASSERT_TRUE(advice);
  EXPECT_TRUE(advice->is_limited_by_device);
  EXPECT_EQ(advice->safe_n_per_m, find_device_preset("model-a")->limits.max_stiffness_n_per_m);
  const std::string log = log_of({.stiffness_n_per_m = 2.0 * advice->safe_n_per_m}, {fast});
  EXPECT_THAT(log, testing::HasSubstr("the stiffness limit of PHANToM Model A is"));
  EXPECT_THAT(log, testing::Not(testing::HasSubstr("delay")));
}

TEST(StiffnessAdviser, WarnsWhenAMaterialHasBecomeTooStiff) {
  const double safe_n_per_m = advise_stiffness(kSimulated)->safe_n_per_m;
  testing::internal::CaptureStderr();
  {
    start_log("haptics_node");
    StiffnessAdviser adviser({.stiffness_n_per_m = 0.5 * safe_n_per_m});
    adviser.note(kSimulated);
    wait_for_check(adviser);
    for (const double factor : {0.9, 1.5, 1.5, 0.5}) {
      adviser.set_gains({.stiffness_n_per_m = factor * safe_n_per_m});
      wait_for_check(adviser);
    }
  }
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_EQ(count(log, "the scene has up to"), 1U) << log;
  EXPECT_THAT(log, testing::HasSubstr(fmt::format("the scene has up to {:.0f} N/m", 1.5 * safe_n_per_m)));
}

TEST(StiffnessAdviser, NamesTheKeyOfWhatIsStiff) {
  const auto log = [](StiffCause cause) { return log_of({.stiffness_n_per_m = 320000.0, .cause = cause}, {kSimulated}); };
  const std::string magnet = log(StiffCause::snap_effect);
  EXPECT_THAT(magnet, testing::HasSubstr("up to 320000 N/m in an effect of type magnet"));
  EXPECT_THAT(magnet, testing::HasSubstr("lower 4 max_force_n / range_m, or shorten"));
  EXPECT_THAT(magnet, testing::Not(testing::HasSubstr("stiffness_n_per_m")));
  EXPECT_THAT(log(StiffCause::spring), testing::HasSubstr("lower its stiffness_n_per_m, start with --coupling"));
}

// The stiffness of bumps counts at the largest force of this device. The maker's limit holds for walls and not for bumps.
TEST(StiffnessAdviser, CountsBumpsAtTheForceOfTheDevice) {
  LoopFacts fast = kSimulated;
  fast.round_trip_s = 1e-4F;
  const StiffnessAdvice advice = *advise_stiffness(fast);
  EXPECT_NEAR(advice.pressed_n, 8.45, 0.01);
  ASSERT_TRUE(advice.is_limited_by_device);
  ASSERT_GT(advice.loop_n_per_m, 1.5 * advice.safe_n_per_m);
  const auto log_at = [&](double factor) {
    LargestGains gains{.by_place_n_per_m = factor * advice.loop_n_per_m * kMaxPressedN / advice.pressed_n,
                       .place_cause = StiffCause::bumps};
    gains.of_pressing_n_per_m = gains.by_place_n_per_m;
    return log_of(gains, {fast});
  };
  EXPECT_THAT(log_at(0.99), testing::Not(testing::HasSubstr("has up to")));
  EXPECT_THAT(log_at(1.01), testing::HasSubstr("N/m on bumps, pressed with 8.5 N, but PHANToM Model A at 1000 Hz"));
  EXPECT_THAT(log_at(1.01), testing::HasSubstr("lower bump_height_m"));
}

TEST(StiffnessAdviser, WarnsWhenASurfaceHasBecomeTooStiffFromPlaceToPlace) {
  const StiffnessAdvice advice = *advise_stiffness(kSimulated);
  const auto log_of_change = [&](StiffCause cause) {
    testing::internal::CaptureStderr();
    {
      start_log("haptics_node");
      StiffnessAdviser adviser({});
      adviser.note(kSimulated);
      wait_for_check(adviser);
      for (const double factor : {0.9, 1.5, 0.5}) {
        const double n_per_m = factor * advice.loop_n_per_m * kMaxPressedN / advice.pressed_n;
        adviser.set_gains({.by_place_n_per_m = n_per_m, .of_pressing_n_per_m = n_per_m, .place_cause = cause});
        wait_for_check(adviser);
      }
    }
    return testing::internal::GetCapturedStderr();
  };
  const std::string bumps = log_of_change(StiffCause::bumps);
  EXPECT_EQ(count(bumps, fmt::format("the scene has up to {:.0f} N/m on bumps, pressed", 1.5 * advice.loop_n_per_m)), 1U) << bumps;
  EXPECT_EQ(count(bumps, "the scene has up to"), 1U) << bumps;
  const std::string map = log_of_change(StiffCause::stiffness_map);
  EXPECT_EQ(count(map, fmt::format("up to {:.0f} N/m where a stiffness_map changes", 1.5 * advice.loop_n_per_m)), 1U) << map;
  EXPECT_THAT(map, testing::HasSubstr("set the two numbers of stiffness_map_n_per_m nearer to each other"));
}

constexpr LoopFacts kSixDof = {.device = {'s', 'i', 'm', 'u', 'l', 'a', 't', 'e', 'd', '-', '6', 'd', 'o', 'f'},
                               .servo_rate_hz = 1000.0,
                               .round_trip_s = 0.010F,
                               .max_torque_nm = 0.17F};

TEST(StiffnessAdviser, AdvisesOnTurningWhereMotorsTurnTheStylus) {
  EXPECT_EQ(advise_stiffness(kSimulated)->rotational_nm_per_rad, 0.0);
  const StiffnessAdvice advice = *advise_stiffness(kSixDof);
  EXPECT_EQ(advice.by_turning, "light");
  EXPECT_NEAR(advice.rotational_nm_per_rad,
              recommend_rotational_stiffness(*find_hand_preset("light"), 0.17, 1000.0, static_cast<double>(kSixDof.round_trip_s)), 1e-9);
}

TEST(StiffnessAdviser, WarnsOfAToolThatTurnsTooStiffly) {
  const double safe = advise_stiffness(kSixDof)->rotational_nm_per_rad;
  testing::internal::CaptureStderr();
  {
    start_log("haptics_node");
    StiffnessAdviser adviser({});
    adviser.note_tool(0.9 * safe);
    adviser.note(kSixDof);
    wait_for_check(adviser);
    adviser.set_gains({.stiffness_n_per_m = 1.0, .rotational_nm_per_rad = 2.0 * safe});  // stiffer materials with the same tool
    wait_for_check(adviser);
    adviser.note_tool(1.5 * safe);  // less than the value that it warned of
    wait_for_check(adviser);
  }
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_EQ(count(log, "the stylus holds a tool with"), 1U) << log;
  EXPECT_THAT(log, testing::HasSubstr(fmt::format("a tool with {:.3g} Nm/rad", 2.0 * safe)));
  EXPECT_THAT(log, testing::HasSubstr("give haptics_node --rotational-stiffness"));
  LoopFacts without_motors = kSixDof;
  without_motors.max_torque_nm = 0.0F;
  EXPECT_THAT(log_of({.rotational_nm_per_rad = 100.0}, {without_motors}), testing::Not(testing::HasSubstr("holds a tool")));
  EXPECT_THAT(log_of({.rotational_nm_per_rad = 100.0}, {without_motors, kSixDof}), testing::HasSubstr("holds a tool with 100 Nm/rad"));
}

TEST(StiffnessAdviser, SaysNothingOfASceneThatIsSafe) {
  const StiffnessAdvice advice = *advise_stiffness(kSimulated);
  EXPECT_THAT(log_of({.stiffness_n_per_m = 0.9 * advice.safe_n_per_m,
                      .damping_ns_per_m = 0.9 * advice.damping_ns_per_m,
                      .viscosity_ns_per_m = 0.9 * advice.viscosity_ns_per_m},
                     {kSimulated}),
              testing::Not(testing::HasSubstr("has up to")));
}

TEST(StiffnessAdviser, AdvisesTheSmallestDampingOfAllHands) {
  const DevicePreset& model_a = *find_device_preset("model-a");
  const StiffnessAdvice advice = *advise_stiffness(kSimulated);
  double damping = HUGE_VAL;
  double viscosity = HUGE_VAL;
  for (const char* hand : {"light", "stylus", "arm", "firm"}) {
    const Recommendation one =
        recommend_stiffness(model_a.model, model_a.limits, *find_hand_preset(hand), 1000.0, static_cast<double>(kSimulated.round_trip_s));
    damping = std::min(damping, one.damping_ns_per_m);
    viscosity = std::min(viscosity, one.viscosity_ns_per_m);
  }
  EXPECT_EQ(advice.damping_ns_per_m, damping);
  EXPECT_EQ(advice.viscosity_ns_per_m, viscosity);
  EXPECT_EQ(advice.by_damping.device, model_a.title);
}

TEST(StiffnessAdviser, WarnsOfTooMuchDampingAndOfNothingElse) {
  const StiffnessAdvice advice = *advise_stiffness(kSimulated);
  const std::string damped =
      log_of({.stiffness_n_per_m = 0.9 * advice.safe_n_per_m, .damping_ns_per_m = 1.1 * advice.damping_ns_per_m}, {kSimulated});
  EXPECT_EQ(count(damped, "the scene has up to"), 1U) << damped;
  EXPECT_THAT(damped, testing::HasSubstr(fmt::format("the scene has up to {:.3g} Ns/m of damping, but PHANToM Model A at 1000 Hz with "
                                                     "forces after 10 ms is safe only up to {:.3g} Ns/m",
                                                     1.1 * advice.damping_ns_per_m, advice.damping_ns_per_m)));
  EXPECT_THAT(damped, testing::HasSubstr("lower damping_ns_per_m of materials"));
  const std::string viscous = log_of({.viscosity_ns_per_m = 1.1 * advice.viscosity_ns_per_m}, {kSimulated});
  EXPECT_EQ(count(viscous, "the scene has up to"), 1U) << viscous;
  EXPECT_THAT(viscous, testing::HasSubstr("Ns/m of viscosity, but PHANToM Model A"));
}

// The adviser warns of the damping that has risen, but not a second time of the stiffness, which was too large from the start.
TEST(StiffnessAdviser, WarnsWhenAMaterialHasBecomeTooDamped) {
  const StiffnessAdvice advice = *advise_stiffness(kSimulated);
  testing::internal::CaptureStderr();
  {
    start_log("haptics_node");
    const double stiffness_n_per_m = 2.0 * advice.safe_n_per_m;
    StiffnessAdviser adviser({.stiffness_n_per_m = stiffness_n_per_m});
    adviser.note(kSimulated);
    wait_for_check(adviser);
    for (const double factor : {0.9, 1.5, 0.5}) {
      adviser.set_gains({.stiffness_n_per_m = stiffness_n_per_m, .damping_ns_per_m = factor * advice.damping_ns_per_m});
      wait_for_check(adviser);
    }
  }
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_EQ(count(log, " Ns/m of damping, but"), 1U) << log;
  EXPECT_EQ(count(log, fmt::format("the scene has up to {:.0f} N/m", 2.0 * advice.safe_n_per_m)), 1U) << log;
}

}  // namespace
}  // namespace hapton
