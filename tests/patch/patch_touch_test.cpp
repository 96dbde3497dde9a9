// Compares touch by small patches that come late with touch of the whole scene.
#include "patch/patch_touch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/force/force_method.h"
#include "tests/patch/patch_stage.h"

namespace hapton {
namespace {

constexpr double kSheetHalfSide = 0.05;
constexpr double kPatchRadius = 0.012;
constexpr double kPressDepth = 0.003;

// A hand that moves in circles with a radius of 30 mm at 100 mm/s, after the first second 3 mm below the sheet.
Vec3 circling_hand(int n) {
  const double angle = 0.01 / 3.0 * std::max(n - 1000, 0);
  const double x = 0.03 * std::cos(angle);
  const double y = 0.03 * std::sin(angle);
  const double height = 0.01 * std::max(1.0 - n / 500.0, 0.0) - kPressDepth * std::clamp(n / 500.0 - 1.0, 0.0, 1.0);
  return {x, y, wavy_height(x, y) + height};
}

// Each patch has the whole sheet but says that it is small, so that only the hand-over can cause a difference.
class LatePatches {
 public:
  explicit LatePatches(int late_cycles)
      : late_cycles_(late_cycles), scene_(scene_of(wavy_sheet(kSheetHalfSide, 60))), whole_(*make_method({}, scene_)) {}

  struct Outputs {
    std::optional<PatchOutput> patch;
    TouchOutput whole;
  };
  Outputs step(const Vec3& p_WD, double dt_s) {
    if (++cycle_ == 1) whole_.reset({p_WD});
    (void)touch_.take_retired();
    if (next_patch_ == nullptr && (cycle_ == 1 || touch_.hand_at(p_WD, 0).is_beyond || cycle_ % 20 == 0)) {
      next_patch_ = make(p_WD);
      due_cycle_ = cycle_ == 1 ? cycle_ : cycle_ + late_cycles_;
    }
    if (next_patch_ != nullptr && cycle_ >= due_cycle_) (void)touch_.offer(std::move(next_patch_));
    const TouchInput input{.p_WD = p_WD, .dt_s = dt_s};
    return {touch_.step(input), whole_.step(input)};
  }
  const PatchTouch& touch() const { return touch_; }

 private:
  std::unique_ptr<Patch> make(const Vec3& p_SD) const {
    const PatchHandState hand = touch_.hand_at(p_SD, 0);
    const PathBall ball = hand.is_beyond ? hand.path : PathBall{p_SD, 0.0};
    auto patch = std::make_unique<Patch>();
    patch->step = std::make_unique<TouchStep>(*make_method({}, scene_));
    patch->p_SC = ball.p_SC;
    patch->radius_m = std::max(kPatchRadius, 1.5 * ball.radius_m);
    patch->lift_m = 1e-9;
    return patch;
  }

  int late_cycles_;
  TouchScene scene_;
  TouchStep whole_;
  PatchTouch touch_;
  std::unique_ptr<Patch> next_patch_;
  int cycle_ = 0;
  int due_cycle_ = 0;
};

// The machine stops again and again, and a patch takes 40 cycles to come, so the hand is often past the edge of its patch. Once the proxy
// has caught up with the hand, no difference is left.
TEST(PatchTouch, AHandPastTheEdgeIsCaughtUpWithExactly) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    LatePatches patches(40);
    std::mt19937_64 random(seed);
    std::exponential_distribution<double> stall_ms(1.0 / 50.0);
    int within_steps = 0;
    double worst_error_n = 0.0;
    double largest_force_n = 0.0;
    for (int n = 1; n < 8000; ++n) {
      const int missed = n % 100 == 0 ? static_cast<int>(std::min(stall_ms(random), 300.0)) : 0;
      n += missed;
      const auto [patch, whole] = patches.step(circling_hand(n), 1e-3 * (1 + missed));
      if (!patch || patch->is_beyond) continue;
      ++within_steps;
      worst_error_n = std::max(worst_error_n, (patch->force_n - whole.force_n).norm());
      largest_force_n = std::max(largest_force_n, whole.force_n.norm());
    }
    const PatchTouch::Counts& counts = patches.touch().counts();
    EXPECT_GT(counts.beyond, 20U);
    EXPECT_GT(counts.followed, 200U);
    EXPECT_EQ(counts.raised, 0U);
    EXPECT_EQ(counts.begun_anew, 0U);
    EXPECT_GT(within_steps, 1000);
    EXPECT_GT(largest_force_n, 2.0);
    EXPECT_LT(worst_error_n, 1e-5);
  }
}

// The path has more positions than there is room for: it gets coarser, but still ends where the hand is.
TEST(PatchTouch, AHandThatWasPastTheEdgeForLongIsCaughtUpWith) {
  LatePatches patches(3000);
  LatePatches::Outputs felt;
  int n = 1;
  for (; n < 12000 && (n < 5000 || felt.patch->is_beyond); ++n) felt = patches.step(circling_hand(n), 1e-3);
  ASSERT_FALSE(felt.patch->is_beyond);
  EXPECT_GT(patches.touch().counts().beyond_steps, 2000U);
  EXPECT_EQ(felt.patch->contact, felt.whole.contact);
  EXPECT_LT((felt.patch->force_n - felt.whole.force_n).norm(), 0.5 * felt.whole.force_n.norm());
}

std::unique_ptr<Patch> patch_of(const TouchScene& scene, const Vec3& p_SC, double radius_m) {
  auto patch = std::make_unique<Patch>();
  patch->step = std::make_unique<TouchStep>(*make_method({}, scene));
  patch->p_SC = p_SC;
  patch->radius_m = radius_m;
  patch->lift_m = 1e-9;
  return patch;
}

// A small patch reaches where the proxy was, but not the hand, which has moved on. Then there is no output, rather than a zero force.
TEST(PatchTouch, GivesNothingBeforeAPatchHasReachedTheHand) {
  const TouchScene scene = scene_of(wavy_sheet(kSheetHalfSide, 60));
  PatchTouch touch;
  touch.start_at(circling_hand(0), Vec3::Zero());
  for (int n = 1; n < 2000; ++n) {
    if (n == 300) (void)touch.offer(patch_of(scene, circling_hand(0), 0.001));
    (void)touch.take_retired();
    if (n == 1500) (void)touch.offer(patch_of(scene, Vec3::Zero(), 1.0));
    const auto felt = touch.step({.p_WD = circling_hand(n)});
    ASSERT_TRUE(n >= 1500 || !felt.has_value()) << n;
    ASSERT_EQ(touch.has_arrived(), felt.has_value() && !felt->is_beyond);
  }
  EXPECT_TRUE(touch.has_arrived());
  touch.set_generation(1);
  EXPECT_FALSE(touch.has_arrived());
  EXPECT_FALSE(touch.step({.p_WD = circling_hand(2000)}).has_value());
}

// A scene so small that it vanishes in the rounding of positions gives no output, but the next scene is felt.
TEST(PatchTouch, ASceneBelowAllRoundingDoesNotBlockTheNextOne) {
  const TouchScene scene = scene_of(wavy_sheet(kSheetHalfSide, 60));
  PatchTouch touch;
  auto tiny = patch_of(scene, Vec3::Zero(), 1.0);
  tiny->lift_m = 1e-300;
  (void)touch.offer(std::move(tiny));
  (void)touch.step({.p_WD = circling_hand(1000)});
  EXPECT_FALSE(touch.step({.p_WD = circling_hand(1001)}).has_value());
  touch.set_generation(1);
  auto next = patch_of(scene, Vec3::Zero(), 1.0);
  next->generation = 1;
  (void)touch.offer(std::move(next));
  (void)touch.take_retired();
  EXPECT_TRUE(touch.step({.p_WD = circling_hand(1002)}).has_value());
}

// start_at() says again and again where the proxy was a while ago. From there the proxy comes to where the whole scene has it.
TEST(PatchTouch, FollowsTheHandFromWhereTheProbeWasThen) {
  constexpr int kAgeSteps = 300;
  const TouchScene scene = scene_of(wavy_sheet(kSheetHalfSide, 60));
  TouchStep whole(*make_method({}, scene));
  PatchTouch touch;
  whole.reset({.p_WD = circling_hand(0)});
  std::vector<Vec3> offsets;
  int felt_count = 0;
  for (int n = 0; n < 3000; ++n) {
    const Vec3 p_WD = circling_hand(n);
    if (n > kAgeSteps && n % 200 == 0 && !touch.has_arrived()) {
      const Vec3& offset = offsets[static_cast<std::size_t>(n - 1 - kAgeSteps)];
      touch.start_at(circling_hand(n - 1 - kAgeSteps) + offset, offset.stableNormalized(), 1e-3 * kAgeSteps);
    }
    if (n == 2200) (void)touch.offer(patch_of(scene, Vec3::Zero(), 1.0));
    const TouchOutput expected = whole.step({.p_WD = p_WD});
    offsets.push_back(expected.visual_offset_m);
    const auto felt = touch.step({.p_WD = p_WD});
    if (!touch.has_arrived()) continue;
    ++felt_count;
    ASSERT_LT((felt->force_n - expected.force_n).norm(), 1e-5) << n;
  }
  EXPECT_GT(felt_count, 500);
}

// Damping resists the motion of the hand, not the way from the proxy to the hand, which the proxy of a new patch makes in one step.
TEST(PatchTouch, AHandAtRestFeelsNoDampingWhereAnotherPatchTakesOver) {
  const TouchScene scene = scene_of(made::sheet(kSheetHalfSide, 0.0, 10), {.stiffness_n_per_m = 1000.0, .damping_ns_per_m = 5.0});
  PatchTouch touch;
  (void)touch.offer(patch_of(scene, Vec3::Zero(), 1.0));
  Vec3 hand(0.001, 0.0, 0.001);
  for (; hand.z() > -0.002; hand.z() -= 1e-5) (void)touch.step({.p_WD = hand});
  (void)touch.step({.p_WD = hand});
  const auto at_rest = touch.step({.p_WD = hand});
  ASSERT_NEAR(at_rest->force_n.z(), -1000.0 * hand.z(), 1e-6);
  for (int n = 0; n < 3; ++n) {
    (void)touch.take_retired();
    (void)touch.offer(patch_of(scene, Vec3::Zero(), 1.0));
    const auto felt = touch.step({.p_WD = hand});
    EXPECT_EQ(touch.counts().handed_over, 2U + n);
    EXPECT_LT((felt->force_n - at_rest->force_n).norm(), 1e-6);
    EXPECT_LT(felt->difference_n.norm(), 1e-6);
  }
}

// A message about a material does not say from which sides its surface is felt: the scene does.
TEST(PatchTouch, AnotherMaterialDoesNotChangeFromWhichSidesASurfaceIsFelt) {
  for (const bool two_sided : {false, true}) {
    SCOPED_TRACE(two_sided);
    const Material material{.stiffness_n_per_m = 1000.0, .two_sided = two_sided};
    const TouchScene scene = scene_of(made::sheet(kSheetHalfSide, 0.0, 10), material);
    PatchTouch touch;
    auto patch = patch_of(scene, Vec3::Zero(), 1.0);
    patch->objects = {0};
    patch->materials = {material};
    (void)touch.offer(std::move(patch));
    Vec3 hand(0.001, 0.0, -0.001);
    (void)touch.step({.p_WD = hand});
    touch.use_materials({.objects = {{0, {.stiffness_n_per_m = 500.0, .two_sided = !two_sided}}}, .version = 1});
    std::optional<PatchOutput> felt;
    // The hand goes from behind through the sheet and back. The side of the normals is felt in any case.
    for (; hand.z() < 0.001; hand.z() += 1e-5) felt = touch.step({.p_WD = hand});
    felt = touch.step({.p_WD = hand});
    EXPECT_NEAR(felt->force_n.z(), two_sided ? -500.0 * hand.z() : 0.0, 1e-6);
    if (two_sided) continue;
    for (; hand.z() > -0.001; hand.z() -= 1e-5) (void)touch.step({.p_WD = hand});
    felt = touch.step({.p_WD = hand});
    EXPECT_NEAR(felt->force_n.z(), -500.0 * hand.z(), 1e-6);
  }
}

// This depends on the present materials. Past the edge of a patch it is not known.
TEST(PatchTouch, IsFrictionlessWhereNoMaterialHasDynamicFriction) {
  PatchTouch touch;
  EXPECT_FALSE(touch.is_frictionless()) << "without a patch";
  auto patch = patch_of(scene_of(made::sheet(kSheetHalfSide, 0.0, 10), Material()), Vec3::Zero(), 1.0);
  patch->objects = {0};
  patch->materials = {Material()};
  (void)touch.offer(std::move(patch));
  (void)touch.step({.p_WD = Vec3(0.001, 0.0, 0.001)});
  EXPECT_TRUE(touch.is_frictionless());
  touch.use_materials({.objects = {{0, {.friction_static = 0.2, .friction_dynamic = 0.1}}}, .version = 1});
  EXPECT_FALSE(touch.is_frictionless());
  touch.use_materials({.objects = {{0, {.friction_static = 0.2}}}, .version = 2});
  EXPECT_TRUE(touch.is_frictionless());
  (void)touch.step({.p_WD = Vec3(2.0, 0.0, 0.001)});
  EXPECT_TRUE(touch.is_beyond());
  EXPECT_FALSE(touch.is_frictionless());
}

// Another body that holds the proxy may move the device point of this body within a sample, to where its patch does not reach. Then the
// plane of the last contact holds the point, from below the surface to above it, and the sample counts once.
TEST(PatchTouch, ACorrectionPastTheEdgeOfThePatchIsHeldByThePlane) {
  constexpr double kSheetStiffness = 1000.0;
  PatchTouch touch;
  (void)touch.offer(patch_of(scene_of(made::sheet(kSheetHalfSide, 0.0, 10), {.stiffness_n_per_m = kSheetStiffness}), Vec3::Zero(), 0.01));
  for (const double z : {0.001, -0.001}) (void)touch.step({.p_WD = Vec3(0.001, 0.0, z)});
  const std::uint64_t steps = touch.counts().steps;
  for (const double z : {-0.0015, -0.001, 0.001}) {
    const auto felt = touch.step({.p_WD = Vec3(0.03, 0.0, z), .is_correction = true});
    ASSERT_TRUE(felt.has_value()) << z;
    EXPECT_TRUE(felt->is_beyond);
    EXPECT_EQ(felt->contact, z < 0.0);
    EXPECT_NEAR(felt->visual_offset_m.z(), std::max(-z, 0.0), 1e-9) << z;
    EXPECT_EQ(felt->force_n.z() > 0.0, z < 0.0) << z;
  }
  EXPECT_EQ(touch.counts().beyond, 1U);
  EXPECT_EQ(touch.counts().steps, steps);
  // Only the last of these positions waits to be followed.
  EXPECT_NEAR(touch.hand_at(Vec3::Zero(), 0).path.radius_m, 0.5 * Vec3(0.029, 0.0, 0.001).norm(), 1e-7);
}

// No step follows more than kMaxFollowed positions.
TEST(PatchTouch, CatchingUpIsSpreadOverSteps) {
  LatePatches patches(500);
  std::uint64_t before = 0;
  std::uint64_t most_steps = 0;
  for (int n = 1; n < 2000; ++n) {
    (void)patches.step(circling_hand(n), 1e-3);
    most_steps = std::max(most_steps, patches.touch().counts().steps - before);
    before = patches.touch().counts().steps;
  }
  EXPECT_EQ(most_steps, static_cast<std::uint64_t>(PatchTouch::kMaxFollowed));
}

}  // namespace
}  // namespace hapton
