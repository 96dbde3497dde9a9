// Past the edge of patches made by hand: the plane of the last contact, and the patch that takes over from it.
#include <gtest/gtest.h>

#include <utility>

#include "core/force/force_method.h"
#include "patch/patch_touch.h"
#include "tests/support/made_scene.h"

namespace hapton {
namespace {

constexpr double kEdgeStiffness = 1000.0;
constexpr double kHeldDepth = 0.003;

// A flat sheet at z = 0, known within 10 mm of the origin.
struct PatchEdge : testing::Test {
  PatchEdge() { (void)touch.offer(make_patch(Vec3::Zero(), 0.01)); }
  static std::unique_ptr<Patch> make_patch(const Vec3& p_SC, double radius_m, bool is_path_incomplete = false,
                                           const Material& material = {.stiffness_n_per_m = kEdgeStiffness}) {
    auto patch = std::make_unique<Patch>();
    patch->step = std::make_unique<TouchStep>(*make_method({}, scene_of(made::sheet(0.05, 0.0, 10), material)));
    patch->objects = {4};
    patch->materials = {material};
    patch->p_SC = p_SC;
    patch->radius_m = radius_m;
    patch->lift_m = 1e-9;
    patch->is_path_incomplete = is_path_incomplete;
    return patch;
  }
  std::optional<PatchOutput> step_at(double x, double depth_m, double dt_s = 1e-3) {
    (void)touch.take_retired();
    return touch.step({.p_WD = {x, 0.0005, -depth_m}, .dt_s = dt_s});
  }
  // Goes down at the middle, then 12 mm sideways, 1 mm in each step.
  PatchOutput go_past_the_edge() {
    for (int n = 0; n <= 5; ++n) last_output = *step_at(0.0, -0.002 + 0.001 * n);
    EXPECT_FALSE(last_output.is_beyond);
    EXPECT_EQ(last_output.object, 4) << "the scene's number";
    for (int n = 1; n <= 12; ++n) last_output = *step_at(0.001 * n, kHeldDepth);
    return last_output;
  }
  PatchTouch touch;
  PatchOutput last_output;
};

TEST_F(PatchEdge, ThePlaneHoldsWhileTheHandGoesOnAtItsDepth) {
  const PatchOutput beyond = go_past_the_edge();
  ASSERT_TRUE(beyond.is_beyond);
  EXPECT_TRUE(beyond.contact);
  EXPECT_NEAR((beyond.force_n - Vec3(0, 0, kEdgeStiffness * kHeldDepth)).norm(), 0.0, 0.01);
  EXPECT_NEAR((beyond.visual_offset_m - Vec3(0, 0, kHeldDepth)).norm(), 0.0, 1e-5);
  EXPECT_EQ(beyond.object, -1);
  EXPECT_EQ(touch.counts().beyond, 1U);
  EXPECT_GT(touch.counts().beyond_steps, 1U);
  EXPECT_EQ(touch.counts().steps + touch.counts().beyond_steps, 18U);
}

// The plane has a spring, and a damper of 0.005 s times its stiffness. It never pulls, and gives at most twice the last force within the
// patch.
TEST_F(PatchEdge, ThePlaneIsADampedSpringWithinBounds) {
  (void)go_past_the_edge();
  const double x = 0.012;
  struct Row {
    double depth_m, dt_s, force_n;
  };
  const Row rows[] = {{0.0035, 1.0, 3.5},                          // slowly: the spring alone
                      {0.0036, 1e-3, 3.6 + 1000.0 * 0.005 * 0.1},  // 0.1 m/s inwards
                      {0.0035, 1e-3, 3.5 - 1000.0 * 0.005 * 0.1},  // 0.1 m/s outwards
                      {0.0055, 1e-3, 6.0},                         // 2 m/s inwards: limited to twice 3 N
                      {0.009, 1.0, 6.0},                           // deep: limited as well
                      {0.005, 1e-3, 0.0},                          // 4 m/s outwards: no pull
                      {0.005, 1e-3, 5.0}};
  for (const Row& row : rows) {
    const auto felt = step_at(x, row.depth_m, row.dt_s);
    ASSERT_TRUE(felt.has_value() && felt->is_beyond);
    EXPECT_NEAR(felt->force_n.z(), row.force_n, 0.02) << row.depth_m;
    EXPECT_TRUE(felt->contact);
    EXPECT_FALSE(felt->is_handed_over);
  }
  const auto out = step_at(x, -0.001);
  ASSERT_TRUE(out.has_value());
  EXPECT_TRUE(out->is_beyond);
  EXPECT_FALSE(out->contact);
  EXPECT_EQ(out->force_n, Vec3(Vec3::Zero()));
  EXPECT_EQ(out->visual_offset_m, Vec3(Vec3::Zero()));
}

// The hand leaves the surface so fast that damping takes all of the force, or enters it so fast that damping is most of the force. Then it
// is past the edge.
TEST_F(PatchEdge, ThePlaneIsAsStiffAsTheSurfaceWhateverDampingDidLast) {
  for (const double before_m : {0.003, 0.001}) {
    touch = PatchTouch();
    (void)touch.offer(make_patch(Vec3::Zero(), 0.01, false, {.stiffness_n_per_m = kEdgeStiffness, .damping_ns_per_m = 5.0}));
    for (int n = 0; n <= 5; ++n) (void)step_at(0.0, -0.002 + n * (before_m + 0.002) / 5);
    last_output = *step_at(0.0, 0.002);
    ASSERT_FALSE(last_output.is_beyond);
    EXPECT_TRUE(last_output.contact);
    EXPECT_NEAR(last_output.force_n.z(), before_m > 0.002 ? 0.0 : 7.0, 0.01);
    for (const auto& [depth_m, force_n] : {std::pair{0.002, 2.0}, {0.003, 3.0}, {0.009, 4.0}}) {
      const auto felt = step_at(0.012, depth_m, 1.0);
      ASSERT_TRUE(felt.has_value() && felt->is_beyond);
      EXPECT_NEAR(felt->force_n.z(), force_n, 0.05) << before_m << " " << depth_m;
    }
  }
}

// In a corner the stiffness is that of both objects together, whichever of them is reported.
TEST_F(PatchEdge, ThePlaneIsAsStiffAsACornerBetweenTwoObjects) {
  for (const auto& [floor_n_per_m, wall_n_per_m] : {std::pair{300.0, 2000.0}, {2000.0, 300.0}}) {
    const std::vector<Material> materials = {{.stiffness_n_per_m = floor_n_per_m, .damping_ns_per_m = 1.0},
                                             {.stiffness_n_per_m = wall_n_per_m, .damping_ns_per_m = 1.0}};
    TriangleMesh wall = made::sheet(0.05, 0.0, 10);
    for (Vec3& vertex : wall.vertices) vertex = {vertex.x(), 0.002, vertex.y()};  // it faces -y
    TouchScene scene = scene_of(made::sheet(0.05, 0.0, 10), materials[0]);
    scene.objects.push_back({std::make_shared<const TriangleMesh>(std::move(wall)), materials[1]});
    auto patch = make_patch(Vec3::Zero(), 0.02);
    patch->step = std::make_unique<TouchStep>(*make_method({}, scene));
    patch->objects = {4, 5};
    patch->materials = materials;
    touch = PatchTouch();
    (void)touch.offer(std::move(patch));
    const auto hold = [&](double x, double y, double z) {
      (void)touch.take_retired();
      return *touch.step({.p_WD = {x, y, z}});
    };
    for (int n = 0; n <= 5; ++n) (void)hold(0.0, 0.0005, 0.002 - 0.001 * n);
    for (int n = 0; n <= 9; ++n) (void)hold(0.0, 0.0005 + 0.0005 * n, -0.003);
    last_output = hold(0.0, 0.005, -0.003);  // at rest: no damping
    ASSERT_FALSE(last_output.is_beyond);
    ASSERT_NEAR((last_output.visual_offset_m - Vec3(0.0, -0.003, 0.003)).norm(), 0.0, 1e-5);
    (void)hold(0.025, 0.005, -0.003);
    const PatchOutput beyond = hold(0.025, 0.005, -0.003);
    EXPECT_TRUE(beyond.is_beyond);
    EXPECT_NEAR(beyond.force_n.norm(), last_output.force_n.norm(), 0.01 * last_output.force_n.norm()) << floor_n_per_m;
  }
}

TEST_F(PatchEdge, TheProxyCatchesUpOnceAPatchReachesTheHand) {
  (void)go_past_the_edge();
  (void)touch.offer(make_patch({0.012, 0, 0}, 0.04));
  const auto felt = step_at(0.012, kHeldDepth);
  ASSERT_TRUE(felt.has_value());
  EXPECT_FALSE(felt->is_beyond);
  EXPECT_TRUE(felt->is_handed_over);
  EXPECT_NEAR(felt->force_n.z(), kEdgeStiffness * kHeldDepth, 0.01);
  EXPECT_GT(touch.counts().followed, 0U);
  EXPECT_FALSE(step_at(0.012, kHeldDepth)->is_handed_over);
}

// A patch that does not reach back to the last proxy within a patch takes over only if it says that the path is incomplete.
TEST_F(PatchEdge, APatchBesideThePathTakesOverFromAboveThePlane) {
  for (const bool is_path_incomplete : {false, true}) {
    touch = PatchTouch();
    (void)touch.offer(make_patch(Vec3::Zero(), 0.01));
    (void)go_past_the_edge();
    for (int n = 13; n < 40; ++n) (void)step_at(0.001 * n, kHeldDepth);
    (void)touch.offer(make_patch({0.039, 0, 0}, 0.03, is_path_incomplete));
    const auto felt = step_at(0.039, kHeldDepth);
    ASSERT_TRUE(felt.has_value());
    EXPECT_EQ(felt->is_beyond, !is_path_incomplete);
    EXPECT_EQ(touch.counts().raised, is_path_incomplete ? 1U : 0U);
    EXPECT_NEAR(felt->force_n.z(), kEdgeStiffness * kHeldDepth, 0.02);
  }
}

TEST_F(PatchEdge, ASmallPatchBesideThePathHasToGrowFirst) {
  (void)go_past_the_edge();
  for (int n = 13; n < 40; ++n) (void)step_at(0.001 * n, kHeldDepth);
  // Twice the last penetration must fit into the patch.
  (void)touch.offer(make_patch({0.039, 0, 0}, 0.0095, true));
  EXPECT_TRUE(step_at(0.039, kHeldDepth)->is_beyond);
  (void)touch.offer(make_patch({0.039, 0, 0}, 0.0099, true));
  EXPECT_FALSE(step_at(0.039, kHeldDepth)->is_beyond);
}

// On a short path the surface cannot have risen far.
TEST_F(PatchEdge, AfterAShortPathASmallerPatchIsEnough) {
  (void)go_past_the_edge();
  (void)touch.offer(make_patch({0.012, 0, 0}, 0.0075, true));
  EXPECT_TRUE(step_at(0.012, kHeldDepth)->is_beyond);
  (void)touch.offer(make_patch({0.012, 0, 0}, 0.009, true));
  const auto felt = step_at(0.012, kHeldDepth);
  ASSERT_TRUE(felt.has_value());
  EXPECT_FALSE(felt->is_beyond);
  EXPECT_EQ(touch.counts().raised, 1U);
  EXPECT_NEAR(felt->force_n.z(), kEdgeStiffness * kHeldDepth, 0.02);
}

TEST_F(PatchEdge, AFreeHandThatStaysAwayBeginsAnew) {
  for (int n = 0; n < 20; ++n) (void)step_at(0.001 * n, -0.002);
  EXPECT_TRUE(touch.is_placed());
  for (int n = 0; n < 4; ++n) EXPECT_TRUE(step_at(0.02, -0.002, 1.0).has_value()) << "within five seconds";
  EXPECT_TRUE(touch.has_arrived());
  EXPECT_FALSE(step_at(0.02, -0.002, 1.0).has_value());
  EXPECT_EQ(touch.counts().begun_anew, 1U);
  EXPECT_FALSE(touch.is_placed());
  EXPECT_FALSE(touch.has_arrived());
  (void)touch.offer(make_patch({0.02, 0, 0}, 0.01));
  EXPECT_TRUE(step_at(0.02, -0.002).has_value());
}

// In contact the hand never starts again.
TEST_F(PatchEdge, AHandOnThePlaneIsHeldForAsLongAsItStays) {
  (void)go_past_the_edge();
  for (int n = 0; n < 20; ++n) {
    const auto held = step_at(0.012, kHeldDepth, 1.0);
    ASSERT_TRUE(held.has_value());
    EXPECT_NEAR(held->force_n.z(), kEdgeStiffness * kHeldDepth, 0.01);
  }
  EXPECT_EQ(touch.counts().begun_anew, 0U);
}

TEST_F(PatchEdge, APositionThatIsNotFiniteOrTooFarChangesNothing) {
  (void)go_past_the_edge();
  EXPECT_FALSE(touch.step({.p_WD = {std::nan(""), 0, 0}, .dt_s = 1e-3}).has_value());
  EXPECT_FALSE(touch.step({.p_WD = {1e10, 0, 0}, .dt_s = 1e-3}).has_value()) << "its rounding is more than the lift";
  EXPECT_NEAR(step_at(0.012, kHeldDepth)->force_n.z(), kEdgeStiffness * kHeldDepth, 0.01);
}

// hand_at() reports where the hand is, and what a patch has to cover.
TEST_F(PatchEdge, ThePathHoldsTheLastProxyAndThePositionsSince) {
  const Vec3 hand(0.001, 0.002, 0.003);
  EXPECT_FALSE(touch.hand_at(hand, 7).is_beyond);
  EXPECT_EQ(touch.hand_at(hand, 7).p_SD, hand);
  EXPECT_EQ(touch.hand_at(hand, 7).time_ns, 7);
  (void)go_past_the_edge();
  const PatchHandState state = touch.hand_at(hand, 8);
  ASSERT_TRUE(state.is_beyond);
  const Vec3 far = Vec3(0.012, 0.0005, -kHeldDepth);
  EXPECT_LE((far - state.path.p_SC).norm(), state.path.radius_m + 1e-9);
  EXPECT_NEAR(state.path.p_SC.z(), -0.5 * kHeldDepth, 1e-4) << "half way between proxy and hand";
  EXPECT_GT(state.path.p_SC.x(), 0.006);
  EXPECT_LT(state.path.radius_m, 0.006);
}

TEST_F(PatchEdge, AnotherGenerationIsAnotherScene) {
  (void)go_past_the_edge();
  touch.set_generation(1);
  EXPECT_FALSE(step_at(0.012, kHeldDepth).has_value()) << "its patches are of no use";
  (void)touch.offer(make_patch({0.012, 0, 0}, 0.04));
  EXPECT_FALSE(step_at(0.012, kHeldDepth).has_value());
  auto next = make_patch({0.012, 0, 0}, 0.04);
  next->generation = 1;
  (void)touch.offer(std::move(next));
  const auto felt = step_at(0.012, kHeldDepth);
  ASSERT_TRUE(felt.has_value());
  EXPECT_NEAR(felt->force_n.z(), kEdgeStiffness * kHeldDepth, 0.01);
}

}  // namespace
}  // namespace hapton
