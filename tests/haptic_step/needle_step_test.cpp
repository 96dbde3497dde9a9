// A needle in layers is drawn at its tip, but the surface holds the proxy elsewhere: after a break, contact continues from the proxy.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "core/math/contact_resumption.h"
#include "haptic_step/haptics_step.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

// A block of flesh under a skin that gives way at 0.4 N, when pressed 1 mm in. The hand stays within kResumeReachM of the skin.
TouchScene flesh() {
  SurfaceEffects layers;
  layers.layers.add({.depth_m = 0.0, .stiffness_n_per_m = 400.0, .pop_force_n = 0.4, .drag_ns_per_m = 2.0});
  layers.layers.add({.depth_m = 0.006, .stiffness_n_per_m = 600.0});
  return {.objects = {{made::shared(made::box({-0.05, -0.05, -0.05}, {0.05, 0.05, 0.0})), {}, layers}}};
}

std::unique_ptr<TouchStep> make_needle() { return std::make_unique<TouchStep>(*make_method({.name = "proxy"}, flesh()), flesh()); }

class NeedleStep : public testing::Test {
 protected:
  ForceCommand move_to(HapticsStep& step, double z, bool is_resumed = false, const Vec3& p_WP = Vec3::Zero()) {
    ++sample_;
    DeviceState state{.sample = sample_, .sample_time_ns = 1'000'000 * static_cast<std::int64_t>(sample_), .p_WD = {0.001, 0.002, z}};
    state.is_resumed = is_resumed;
    state.p_WP = p_WP;
    step.offer(state);
    return step.reply();
  }
  // Pushes the needle through the skin and into the muscle below, 0.2 mm per sample.
  ForceCommand push_in(HapticsStep& step) {
    ForceCommand last;
    for (double z = 0.002; z > kDeep; z -= 2e-4) last = move_to(step, z);
    for (int n = 0; n < 20; ++n) last = move_to(step, kDeep);
    return last;
  }
  // Pulls the needle out again: no spring, not even that of the skin, holds it back.
  void expect_free_retraction(HapticsStep& step) {
    double largest_pull_n = 0.0;
    for (double z = kDeep; z < 0.002; z += 2e-4) largest_pull_n = std::max(largest_pull_n, -move_to(step, z).force_n.z());
    EXPECT_LT(largest_pull_n, 2.0 * 0.2 + 1e-6) << "the drag at 0.2 m/s";
  }

  static constexpr double kDeep = -0.008;
  std::uint64_t sample_ = 10;
};

TEST_F(NeedleStep, AReplySaysWhereTheProxyIs) {
  HapticsStep step(make_needle(), 1e-5);
  const ForceCommand free = move_to(step, 0.002);
  ASSERT_TRUE(free.held_offset_m.has_value()) << "always, in a scene with layers";
  EXPECT_EQ(*free.held_offset_m, Vec3::Zero());
  const ForceCommand deep = push_in(step);
  EXPECT_NEAR(deep.force_n.z(), 600.0 * 0.002, 1e-6);
  EXPECT_NEAR(deep.visual_offset_m.z(), 0.002, 1e-6) << "it is drawn on the muscle";
  EXPECT_NEAR(deep.held_offset_m->z(), 0.008, 1e-6) << "and held by the skin";
  EXPECT_EQ(deep.held_offset(), *deep.held_offset_m);
}

TEST_F(NeedleStep, GoesOnInAnotherNode) {
  HapticsStep first_node(make_needle(), 1e-5);
  const ForceCommand deep = push_in(first_node);
  HapticsStep second_node(make_needle(), 1e-5);
  const ForceCommand first = move_to(second_node, kDeep, true, Vec3(0.001, 0.002, kDeep) + deep.held_offset());
  EXPECT_TRUE(first.contact);
  EXPECT_EQ(first.object, 0);
  EXPECT_LT(first.force_n.norm(), 0.5) << "layers that it is past are punctured without a tension";
  expect_free_retraction(second_node);
}

TEST_F(NeedleStep, GoesOnInANewSessionAndWithAnotherMethod) {
  HapticsStep step(make_needle(), 1e-5);
  (void)push_in(step);
  step.resume();
  EXPECT_TRUE(move_to(step, kDeep).contact);
  EXPECT_EQ(move_to(step, kDeep).object, 0);
  (void)step.replace(make_needle());
  EXPECT_EQ(move_to(step, kDeep).object, 0);
  expect_free_retraction(step);
}

TEST_F(NeedleStep, ASceneWithoutLayersSaysNothing) {
  const TouchScene plain = {.objects = {{flesh().objects[0].mesh, {}}}};
  HapticsStep step(std::make_unique<TouchStep>(*make_method({.name = "proxy"}, plain), plain), 1e-5);
  (void)move_to(step, 0.001);
  const ForceCommand pressed = move_to(step, -0.001);
  EXPECT_TRUE(pressed.contact);
  EXPECT_FALSE(pressed.held_offset_m.has_value());
  EXPECT_EQ(pressed.held_offset(), pressed.visual_offset_m);
}

}  // namespace
}  // namespace hapton
