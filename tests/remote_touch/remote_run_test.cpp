// Ways to touch across a slow network on a real mesh: 1,000 N/m, a hand that slides at 100 mm/s.
#include "remote_touch/remote_run.h"

#include <gtest/gtest.h>

#include <span>
#include <vector>

#include "closed_loop/stability.h"
#include "remote_touch/packet_size.h"
#include "tests/remote_touch/real_mesh.h"

namespace hapton {
namespace {

RemoteDevice device_of(const char* name) {
  const DevicePreset& preset = *find_device_preset(name);
  return {preset.model, preset.limits, *find_hand_preset("stylus")};
}

RemoteCase case_of(const char* method, double round_trip_s, double loss, std::uint64_t seed = 1) {
  return {find_remote_method(method), RemoteNetwork::of(round_trip_s, loss, 0.0, seed), round_trip_s, {}};
}

class RealMesh : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    auto made = make_remote_scene(real_mesh(GetParam()), {.stiffness_n_per_m = 1000.0});
    ASSERT_TRUE(made) << made.error().what;
    scene_ = std::move(*made);
  }
  SlidePath path(double speed_m_per_s, double round_trip_s) {
    auto made = make_slide_path(*scene_.mesh, *scene_.zero_delay_method,
                                {.seed = 1, .speed_m_per_s = speed_m_per_s, .after_s = 0.5 + 1.5 * round_trip_s});
    EXPECT_TRUE(made) << made.error().what;
    return made.value_or(SlidePath{});
  }
  RemoteScene scene_;
  RemoteDevice device_ = device_of("premium-1.5");
};

// What the comparison has to show: no fall-through, no generated energy, an error of 1 % at most, and 50 packets a second at most.
TEST_P(RealMesh, PatchesAreTouchWithoutDelayAtAnyRoundTrip) {
  for (const double round_trip_s : {0.0, 0.1, 1.0}) {
    SCOPED_TRACE(testing::Message() << round_trip_s << " s");
    const auto touch = run_prescribed(scene_, path(0.1, round_trip_s), device_, case_of("patch", round_trip_s, 0.1));
    ASSERT_TRUE(touch) << touch.error().what;
    EXPECT_GT(touch->force.contact_s, 4.0);
    EXPECT_EQ(touch->force.falls, 0U);
    EXPECT_LT(touch->force.error_rms, 0.01);
    EXPECT_NEAR(touch->force.time_offset_s, 0.0, 1e-4);
    EXPECT_LE(touch->force.generated_j, touch->force.zero_delay_generated_j + 1e-7);
    EXPECT_LE(touch->rates.packets_up, 50.0);
    EXPECT_LE(touch->rates.packets_down, 50.0);
  }
}

// The device's machine stands still for 150 ms on average, after gaps of 200 ms on average: then the hand has jumped by up to 75 mm. What
// is felt after a jump is what the whole scene gives for the same samples.
TEST_P(RealMesh, PatchesAreTheWholeSceneWhereTheMachineStalls) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    RemoteCase stalling = case_of("patch", 0.1, 0.1, seed);
    stalling.stall_s = 0.15;
    const SlidePath slide = path(0.1, 0.1);
    const auto touch = run_prescribed(scene_, slide, device_, stalling);
    ASSERT_TRUE(touch) << touch.error().what;
    EXPECT_GT(touch->missed_periods, 1000U);
    EXPECT_EQ(touch->missed_periods + touch->rows.size(), slide.rows.size()) << "each period of the path is one or the other";
    EXPECT_EQ(touch->force.falls, 0U);
    EXPECT_LT(touch->force.error_rms, 1e-4);
  }
}

// Governor and passivity controller are on, as `io_node --touch patch --passive-mass` has them.
TEST_P(RealMesh, PatchesGiveNoEnergyInClosedLoop) {
  for (const double round_trip_s : {0.0, 1.0}) {
    SCOPED_TRACE(testing::Message() << round_trip_s << " s");
    const auto loop = run_closed_loop(scene_, path(0.1, round_trip_s), device_, case_of("patch-passive", round_trip_s, 0.1), nullptr);
    ASSERT_TRUE(loop) << loop.error().what;
    EXPECT_TRUE(loop->is_bounded);
    EXPECT_LT(loop->generated_j, 1e-6);
    EXPECT_LT(loop->limit_cycle_m, 3.0 * device_.model.encoder_step_m) << "it comes to rest";
    EXPECT_GT(loop->most_force_n, 0.5);
  }
}

TEST_P(RealMesh, RemoteForceThatIsHeldGivesEnergyAndDoesNotRest) {
  const auto loop = run_closed_loop(scene_, path(0.1, 0.1), device_, case_of("remote-held", 0.1, 0.1), nullptr);
  ASSERT_TRUE(loop) << loop.error().what;
  EXPECT_GT(loop->generated_j, 0.01);
  EXPECT_TRUE(!loop->is_bounded || loop->limit_cycle_m > 1e-3);
  const auto passive = run_closed_loop(scene_, path(0.1, 0.1), device_, case_of("remote-passive", 0.1, 0.1), nullptr);
  ASSERT_TRUE(passive);
  EXPECT_LT(passive->generated_j, 1e-6) << "the controller removes that energy, though not the delay";
}

INSTANTIATE_TEST_SUITE_P(Meshes, RealMesh, testing::Values("nefertiti_70k.ply", "fish_22k.obj"));

// Compares linear theory for a force that is late by the round trip with presses of the same device. The device has no friction, joints
// or encoder steps, because the theory leaves them out.
TEST(RestStiffness, OfRemoteForceAgreesWithTheoryAndOfPatchesIsThatWithoutDelay) {
  RemoteDevice device = device_of("premium-1.5");
  device.model.friction_n = device.model.encoder_step_m = device.model.max_force_n = 0.0;
  device.model.mode_count = 0;
  const AxisPlant plant = make_axis_plant(device.model, device.hand);
  double undelayed_n_per_m = 0.0;
  for (const double round_trip_s : {0.0, 0.01, 0.1}) {
    SCOPED_TRACE(testing::Message() << round_trip_s << " s");
    const double stable_n_per_m = find_stable_stiffness(SampledPlant(plant, 1e-3, round_trip_s), 0.0).value;
    const auto held_n_per_m = find_rest_stiffness_of(device, case_of("remote-held", round_trip_s, 0.0), 2e4);
    ASSERT_TRUE(held_n_per_m) << held_n_per_m.error().what;
    EXPECT_LE(*held_n_per_m, 1.02 * stable_n_per_m);
    EXPECT_GT(*held_n_per_m, 0.25 * stable_n_per_m) << "near the limit a press needs longer than a second to come to rest";
    if (round_trip_s == 0.0) undelayed_n_per_m = *held_n_per_m;
    EXPECT_EQ(stable_n_per_m > 1000.0, round_trip_s < 0.01) << "1,000 N/m is beyond it from 10 ms on";
    const auto patch = find_rest_stiffness_of(device, case_of("patch", round_trip_s, 0.1), 2e4);
    ASSERT_TRUE(patch) << patch.error().what;
    EXPECT_NEAR(*patch, undelayed_n_per_m, 0.05 * undelayed_n_per_m);
  }
}

TEST(RemoteRun, ASceneThatNeverArrivesIsAnError) {
  const auto scene = make_remote_scene(real_mesh("fish_22k.obj"), {});
  ASSERT_TRUE(scene);
  const auto path = make_slide_path(*scene->mesh, *scene->zero_delay_method, {});
  ASSERT_TRUE(path);
  const auto touch = run_prescribed(*scene, *path, device_of("touch"), case_of("patch", 0.0, 1.0));
  ASSERT_FALSE(touch);
  constexpr const char* kNotArrived = "patch: the scene around the hand had not arrived after 120 s";
  EXPECT_EQ(touch.error().what, kNotArrived);
  const auto loop = run_closed_loop(*scene, *path, device_of("touch"), case_of("patch", 0.0, 1.0), nullptr);
  ASSERT_FALSE(loop);
  EXPECT_EQ(loop.error().what, kNotArrived);
  const auto rest = find_rest_stiffness_of(device_of("touch"), case_of("patch", 0.0, 1.0), 2e4);
  ASSERT_FALSE(rest);
  EXPECT_EQ(rest.error().what, kNotArrived);
}

TEST(RemoteRun, AHandWithoutASpringFollowsNoPath) {
  const auto scene = make_remote_scene(real_mesh("fish_22k.obj"), {});
  ASSERT_TRUE(scene);
  const auto path = make_slide_path(*scene->mesh, *scene->zero_delay_method, {});
  ASSERT_TRUE(path);
  RemoteDevice device = device_of("touch");
  device.hand.stiffness_n_per_m = 0.0;
  const auto loop = run_closed_loop(*scene, *path, device, case_of("local", 0.0, 0.0), nullptr);
  ASSERT_FALSE(loop);
  EXPECT_EQ(loop.error().what, "a hand without a spring cannot follow a path");
}

// In each period a datagram goes each way; in addition, ten Hellos and Welcomes per second, of 110 bytes each.
TEST(RemoteRun, RatesAreThoseOfTheDatagrams) {
  const auto scene = make_remote_scene(real_mesh("fish_22k.obj"), {});
  ASSERT_TRUE(scene);
  const auto path = make_slide_path(*scene->mesh, *scene->zero_delay_method, {.slide_s = 0.5});
  ASSERT_TRUE(path);
  const auto touch = run_prescribed(*scene, *path, device_of("touch"), case_of("remote-held", 0.0, 0.0));
  ASSERT_TRUE(touch) << touch.error().what;
  EXPECT_NEAR(touch->rates.packets_up, 1010.0, 1e-6);
  EXPECT_NEAR(touch->rates.packets_down, 1010.0, 1e-6);
  EXPECT_NEAR(touch->rates.bytes_up, 1000.0 * static_cast<double>(packet_bytes_of_state()) + 10.0 * 110.0, 1e-3);
  EXPECT_NEAR(touch->rates.bytes_down, 1000.0 * static_cast<double>(packet_bytes_of_force()) + 10.0 * 110.0, 1e-3);
  EXPECT_EQ(touch->scene_kb, 0.0);
  EXPECT_EQ(touch->missed_periods, 0U);
  EXPECT_EQ(touch->rows.size(), path->rows.size());
  const auto patch = run_prescribed(*scene, *path, device_of("touch"), case_of("patch", 0.0, 0.0));
  ASSERT_TRUE(patch);
  EXPECT_GT(patch->scene_kb, 10.0);
  EXPECT_LT(patch->scene_kb, 10'000.0);
  EXPECT_GT(patch->ready_s, 0.5);
}

TEST(RemoteRun, ComparisonsSearchDelaysBeyondTheRoundTrip) {
  EXPECT_DOUBLE_EQ(searched_delay_s(0.1), 0.15);
  EXPECT_DOUBLE_EQ(searched_delay_s(0.0), 0.03) << "a force is used for 20 ms";
}

// The two that are farthest apart do not include the one that is farthest from the first.
TEST(RemoteRun, TheLargestDistanceIsThatOfAnyTwoPositions) {
  const std::vector<Vec3> positions = {Vec3::Zero(), {0.0, 1.125, 0.0}, {1.0, 0.0, 0.0}, {-1.0, 0.0, 0.0}};
  EXPECT_EQ(largest_distance(positions), 2.0);
  EXPECT_EQ(largest_distance(std::span(positions).first(2)), 1.125);
  EXPECT_EQ(largest_distance(std::span(positions).first(1)), 0.0);
  EXPECT_EQ(largest_distance({}), 0.0);
}

// The error is the distance from where the device was without delay: zero, or a millimetre if this test shifts these positions by one.
TEST(RemoteRun, ThePathErrorIsADistance) {
  const auto scene = make_remote_scene(real_mesh("fish_22k.obj"), {.stiffness_n_per_m = 300.0});
  ASSERT_TRUE(scene);
  const auto path = make_slide_path(*scene->mesh, *scene->zero_delay_method, {.slide_s = 0.5});
  ASSERT_TRUE(path);
  const auto run = [&](const std::vector<Vec3>* zero_delay) {
    const auto touch = run_closed_loop(*scene, *path, device_of("premium-1.5"), case_of("local", 0.0, 0.0), zero_delay);
    EXPECT_TRUE(touch);
    return touch.value_or(ClosedLoopTouch{});
  };
  std::vector<Vec3> positions = run(nullptr).p_WD;
  ASSERT_GT(positions.size(), path->first_leaving_row);
  EXPECT_EQ(run(nullptr).path_error_m, 0.0);
  EXPECT_EQ(run(&positions).path_error_m, 0.0) << "the same run";
  for (Vec3& p_W : positions) p_W += Vec3(0.0, 0.0006, 0.0008);
  EXPECT_NEAR(run(&positions).path_error_m, 0.001, 1e-12);
  positions.resize(path->first_sliding_row);
  EXPECT_EQ(run(&positions).path_error_m, 0.0) << "nothing to compare";
}

TEST(RemoteRun, TheSameSeedGivesTheSameRun) {
  const auto scene = make_remote_scene(real_mesh("fish_22k.obj"), {});
  ASSERT_TRUE(scene);
  const auto path = make_slide_path(*scene->mesh, *scene->zero_delay_method, {.slide_s = 0.5});
  ASSERT_TRUE(path);
  int checked_seeds = 0;
  for (const RemoteMethod& method : remote_methods()) {
    const auto run = [&](std::uint64_t seed) {
      const auto touch = run_prescribed(*scene, *path, device_of("touch"), case_of(method.name.data(), 0.02, 0.2, seed));
      EXPECT_TRUE(touch);
      return touch ? touch->force.error_rms : -1.0;
    };
    const double first_error = run(1);
    EXPECT_EQ(run(1), first_error) << method.name;
    // Each datagram that is lost changes the force of these methods. The whole scene needs none, lost parts of a scene are sent again, and
    // a governor releases forces of that age.
    using Scheme = RemoteMethod::Scheme;
    if (method.scheme != Scheme::whole && method.scheme != Scheme::patch && !method.has_governor) {
      EXPECT_NE(run(2), first_error) << method.name;
      ++checked_seeds;
    }
  }
  EXPECT_EQ(checked_seeds, 5);
}

}  // namespace
}  // namespace hapton
