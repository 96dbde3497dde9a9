// An object that is picked up and put down beside one that moves by itself, both felt from patches across a slow and a bad network.
#include "core/math/commanded_motion.h"
#include "scene/commanded_object.h"
#include "scene/object_reader.h"
#include "tests/faults/movable_touch_stage.h"

namespace hapton {
namespace {

constexpr double kPostTopM = 0.045;  // when the post is at rest
const Vec3 kOverPost = {-0.04, 0.02, 0.055};
const Vec3 kOnPost = {-0.04, 0.02, kPostTopM - 0.001};

struct MovableBesideMotion : MovableTouch {
  static constexpr int kPost = 2;

  static void add_post(Scene& scene) {
    SceneObject post;
    post.name = "post";
    post.mesh = made::shared(made::box(Vec3(-0.05, 0.01, 0.001), Vec3(-0.03, 0.03, kPostTopM)));
    post.material.stiffness_n_per_m = kBlockStiffness;
    scene.objects.push_back(std::move(post));
  }
  // Adds a post that moves up and down by 3 mm, again and again.
  static void add_rocking_post(Scene& scene) {
    add_post(scene);
    scene.objects[kPost].motion = std::make_shared<const KeyframeMotion>(
        Vec3::Zero(),
        std::vector<Keyframe>{
            {0.0, Vec3::Zero(), Quat::Identity()}, {0.3, Vec3(0, 0, 0.003), Quat::Identity()}, {0.7, Vec3::Zero(), Quat::Identity()}},
        true);
  }
  static void add_commanded_post(Scene& scene) {
    add_post(scene);
    ObjectSpec spec;
    spec.motion.by_program = true;
    scene.objects[kPost].commanded = std::make_shared<const CommandedObject>(spec, SceneFit(), *scene.objects[kPost].mesh);
  }

  double post_rise_m(std::int64_t scene_time_ns) const {
    const double time_s = 1e-9 * static_cast<double>(scene_time_ns);
    const SceneObject& post = system->scene.objects[kPost];
    if (post.motion != nullptr) return post.motion->pose_at(time_s).translation().z();
    return system->haptics->touch().find_commanded(kPost)->pose_at(time_s).translation().z();
  }
  // The hand goes from the block to the post, stays on it for a while, and returns. The hub computes the force of each sample with the
  // post where it is at the sample's scene time.
  void feel_post() {
    system->device.target = kPressed + displacement_m + Vec3(0, 0, 0.02);
    system->run_for_ns(1'500 * kMs);
    system->device.target = kOverPost;
    system->run_slowly_for_ns(2'500 * kMs);
    ASSERT_TRUE(system->wait_for_patches());
    const std::size_t first = system->local_steps.size();
    system->device.target = kOnPost;
    system->run_slowly_for_ns(2'000 * kMs);
    ASSERT_TRUE(system->wait_for_patches());
    std::size_t in_contact = 0;
    double least_rise_m = 1.0;
    double largest_rise_m = -1.0;
    for (std::size_t n = first; n < system->local_steps.size(); ++n) {
      const auto& [sample, force, is_beyond] = system->local_steps[n];
      if (is_beyond || (sample.p_WD - kOnPost).head<2>().norm() > 0.005) continue;
      const double rise_m = post_rise_m(force.scene_time_ns);
      const double depth_m = std::max(0.0, kPostTopM + rise_m - sample.p_WD.z());
      ASSERT_NEAR(force.force_n.z(), kBlockStiffness * depth_m, kGridRoundingN) << n << ": " << rise_m;
      in_contact += force.contact ? 1 : 0;
      least_rise_m = std::min(least_rise_m, rise_m);
      largest_rise_m = std::max(largest_rise_m, rise_m);
    }
    EXPECT_GT(in_contact, 500U);
    EXPECT_EQ(system->local_steps.back().force.object, kPost);
    EXPECT_TRUE(system->scene.objects[kPost].motion == nullptr || largest_rise_m - least_rise_m > 0.0025) << "it did not rock";
    system->device.target = kOverPost;
    system->run_for_ns(1'000 * kMs);
    system->device.target = kPressed + displacement_m + Vec3(0, 0, 0.02);
    system->run_for_ns(2'500 * kMs);
    checked_count = system->local_steps.size();
  }
};

TEST_F(MovableBesideMotion, BothAreFeltWhereTheyAre) {
  change_scene = add_rocking_post;
  for (std::uint64_t seed = 170; seed < 173; ++seed) {
    displacement_m = Vec3::Zero();
    checked_count = 0;
    LinkFaults faults = kFarLink;
    if (seed > 170) faults = {.delay_ns = 12 * kMs, .jitter_ns = 30 * kMs, .loss = 0.2, .duplicate = 0.3};
    ASSERT_NO_FATAL_FAILURE(press(seed, faults));
    ASSERT_NO_FATAL_FAILURE(feel_post());
    lead(kPressed);
    ASSERT_NO_FATAL_FAILURE(pick_up());
    carry(kPressed + kCarried);
    ASSERT_NO_FATAL_FAILURE(put_down());
    EXPECT_LT((displacement_m - kCarried).norm(), 1e-9);
    ASSERT_NO_FATAL_FAILURE(feel_both_places());
    ASSERT_NO_FATAL_FAILURE(feel_post());
  }
}

// A program moves the post before the object is picked up, while it is held, and after it is put down. The new patches have all moves.
TEST_F(MovableBesideMotion, ProgramsMoveTheOtherMeanwhile) {
  change_scene = add_commanded_post;
  ASSERT_NO_FATAL_FAILURE(press(175, kFarLink));
  std::uint32_t request = 0;
  const auto raise_post = [&](double by_m) {
    system->haptics->mover.request({.request = ++request, .object = {"post"}, .p_m = Vec3(0, 0, by_m), .over_s = 0.05});
    system->run_for_ns(300 * kMs);
    EXPECT_EQ(system->haptics->touch().find_commanded(kPost)->newest().serial, request);
  };
  raise_post(0.002);
  ASSERT_NO_FATAL_FAILURE(feel_post());
  lead(kPressed);
  ASSERT_NO_FATAL_FAILURE(pick_up());
  raise_post(0.004);
  carry(kPressed + kCarried);
  ASSERT_NO_FATAL_FAILURE(put_down());
  ASSERT_NO_FATAL_FAILURE(feel_post());
  EXPECT_NEAR(post_rise_m(system->local_steps.back().force.scene_time_ns), 0.004, 1e-12);
  raise_post(0.001);
  ASSERT_NO_FATAL_FAILURE(feel_post());
}

}  // namespace
}  // namespace hapton
