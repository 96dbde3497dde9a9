// Materials that change while a device presses: the force before, during the fade and after, in closed form.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ostream>
#include <string>
#include <utility>

#include "haptic_step/haptics_step.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

constexpr double kContactOffset = 0.0005 * 0.0254;  // half a thousandth of an inch
constexpr double kFadeS = ForceFade::kInContactS;
constexpr double kStepS = 1e-3;

struct Case {
  const char* label;
  const char* method;
  double probe_radius_m;

  friend void PrintTo(const Case& tested, std::ostream* out) { *out << tested.label; }
};

// A haptics node on one square sheet at z = 0.
class Node {
 public:
  explicit Node(const Case& tested, const Material& material)
      : step(std::make_unique<TouchStep>(*make_method({.name = tested.method, .probe_radius_m = tested.probe_radius_m},
                                                      {.objects = {{made::shared(made::sheet(0.1, 0.0, 6)), material}}})),
             kContactOffset),
        radius_(tested.probe_radius_m) {}

  // The reply to a sample a millisecond after the last one: x along the surface, depth below it.
  ForceCommand press(double x, double depth) {
    ++sample_;
    step.offer({.sample = sample_,
                .sample_time_ns = 1'000'000 * static_cast<std::int64_t>(sample_),
                .p_WD = Vec3(0.011 + x, 0.013, radius_ - depth)});
    return step.reply();
  }

  HapticsStep step;

 private:
  double radius_;
  std::uint64_t sample_ = 100;
};

class MaterialChanges : public testing::TestWithParam<Case> {};

// For a device at rest at the depth d the force goes from k d to k' d, linearly in a tenth of a second.
TEST_P(MaterialChanges, AnotherStiffnessFadesInAndTheProxyStays) {
  constexpr double kDepth = 0.002;
  constexpr double kBefore = 1000.0;
  for (const double after : {3000.0, 250.0}) {
    Node node(GetParam(), {.stiffness_n_per_m = kBefore});
    node.press(0.0, -0.001);
    ForceCommand last = node.press(0.0, kDepth);
    const Vec3 proxy = last.visual_offset_m;
    const double from_n = last.force_n.z();
    EXPECT_NEAR(from_n, kBefore * kDepth, 1e-6 * from_n);
    const Material other{.stiffness_n_per_m = after};
    node.step.set_materials({&other, 1});
    const double to_n = from_n * after / kBefore;
    double largest_jump_n = 0.0;
    for (int i = 1; i <= 100; ++i) {
      const ForceCommand now = node.press(0.0, kDepth);
      EXPECT_NEAR(now.force_n.z(), from_n + (to_n - from_n) * i * kStepS / kFadeS, 1e-9 * kBefore * kDepth) << i;
      EXPECT_EQ(now.visual_offset_m, proxy) << "the proxy stays";
      EXPECT_EQ(now.material_serial, 1U);
      largest_jump_n = std::max(largest_jump_n, (now.force_n - last.force_n).norm());
      last = now;
    }
    EXPECT_NEAR(largest_jump_n, std::fabs(to_n - from_n) * kStepS / kFadeS, 1e-9 * from_n);
    // Afterwards the force is, to the last bit, that of a node that had this material from the start.
    Node fresh(GetParam(), other);
    fresh.press(0.0, -0.001);
    fresh.press(0.0, kDepth);
    for (int i = 0; i < 101; ++i) fresh.press(0.0, kDepth);
    EXPECT_EQ(node.press(0.0, kDepth).force_n, fresh.press(0.0, kDepth).force_n);
  }
}

TEST_P(MaterialChanges, InFreeSpaceThereIsNothingToFade) {
  Node node(GetParam(), {.stiffness_n_per_m = 1000.0});
  node.press(0.0, -0.001);
  const Material other{.stiffness_n_per_m = 2000.0};
  node.step.set_materials({&other, 1});
  const ForceCommand first = node.press(0.0, 0.001);
  EXPECT_TRUE(first.contact);
  EXPECT_NEAR(first.force_n.z(), 2.0, 1e-5);
}

// Each of two objects gets its own material.
TEST_P(MaterialChanges, EachObjectHasItsOwn) {
  TriangleMesh beside = made::sheet(0.1, 0.0, 6);
  for (Vec3& vertex : beside.vertices) vertex.x() += 0.3;
  const TouchScene scene = {.objects = {{made::shared(made::sheet(0.1, 0.0, 6)), {}}, {made::shared(std::move(beside)), {}}}};
  const double radius = GetParam().probe_radius_m;
  TouchStep touch(*make_method({.name = GetParam().method, .probe_radius_m = radius}, scene));
  const std::array materials = {Material{.stiffness_n_per_m = 1000.0}, Material{.stiffness_n_per_m = 400.0}};
  touch.set_materials(materials);
  for (const auto& [x, stiffness] : {std::pair(0.011, 1000.0), std::pair(0.311, 400.0)}) {
    touch.reset({.p_WD = Vec3(x, 0.013, radius + 0.001)});
    touch.step({.p_WD = Vec3(x, 0.013, radius + 0.001)});
    EXPECT_NEAR(touch.step({.p_WD = Vec3(x, 0.013, radius - 0.002)}).force_n.z(), stiffness * 0.002, 1e-5 * stiffness * 0.002);
  }
}

INSTANTIATE_TEST_SUITE_P(OfEveryMethod, MaterialChanges,
                         testing::Values(Case{"proxy", "proxy", 0.0}, Case{"sphere", "proxy", 0.003}, Case{"reference", "reference", 0.0},
                                         Case{"smooth", "smooth", 0.0}, Case{"sweep", "sweep", 0.0}),
                         [](const auto& tested) { return tested.param.label; });

class FrictionChanges : public testing::TestWithParam<Case> {};

// Static friction holds the proxy, with the device at the lateral distance s and the depth d, mu_s d > s. With less friction the proxy
// slides until the pull is on the new cone, at the distance mu_d d. With more friction it stays.
TEST_P(FrictionChanges, LessFrictionLetsTheProxySlideAndTheForceFade) {
  constexpr double kStiffness = 1000.0;
  constexpr double kDepth = 0.002;
  constexpr double kLateralOffset = 0.001;
  constexpr double kTolerance = 1e-5 * kStiffness * kDepth;  // the reference moves in sub-steps
  Node node(GetParam(), {.stiffness_n_per_m = kStiffness, .friction_static = 1.0, .friction_dynamic = 0.8});
  node.press(0.0, -0.001);
  node.press(0.0, kDepth);
  for (int i = 1; i <= 10; ++i) node.press(0.1 * i * kLateralOffset, kDepth);
  const ForceCommand stuck = node.press(kLateralOffset, kDepth);
  ASSERT_NEAR(stuck.force_n.x(), -kStiffness * kLateralOffset, kTolerance);

  const Material more{.stiffness_n_per_m = kStiffness, .friction_static = 2.0, .friction_dynamic = 2.0};
  node.step.set_materials({&more, 1});
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(node.press(kLateralOffset, kDepth).force_n.x(), stuck.force_n.x(), kTolerance);

  const Material less{.stiffness_n_per_m = kStiffness, .friction_static = 0.25, .friction_dynamic = 0.2};
  node.step.set_materials({&less, 1});
  const double to_n = -kStiffness * 0.2 * kDepth;
  for (int i = 1; i <= 100; ++i) {
    const ForceCommand now = node.press(kLateralOffset, kDepth);
    EXPECT_NEAR(now.force_n.x(), stuck.force_n.x() + (to_n - stuck.force_n.x()) * i * kStepS / kFadeS, kTolerance) << i;
    EXPECT_NEAR(now.force_n.z(), kStiffness * kDepth, kTolerance) << i;
  }
  const Material none{.stiffness_n_per_m = kStiffness};
  node.step.set_materials({&none, 1});
  for (int i = 0; i < 100; ++i) node.press(kLateralOffset, kDepth);
  EXPECT_NEAR(node.press(kLateralOffset, kDepth).force_n.x(), 0.0, kTolerance);

  // Friction is on again: the proxy sticks where it is, and then the device pulls it along on the cone.
  const Material sticky{.stiffness_n_per_m = kStiffness, .friction_static = 0.5, .friction_dynamic = 0.4};
  node.step.set_materials({&sticky, 1});
  for (int i = 1; i <= 120; ++i) node.press(kLateralOffset * (1.0 + 0.05 * i), kDepth);
  EXPECT_NEAR(node.press(kLateralOffset * 7.05, kDepth).force_n.x(), -kStiffness * 0.4 * kDepth, kTolerance);
}

INSTANTIATE_TEST_SUITE_P(OfMethodsWithFriction, FrictionChanges,
                         testing::Values(Case{"proxy", "proxy", 0.0}, Case{"sphere", "proxy", 0.003}, Case{"reference", "reference", 0.0}),
                         [](const auto& tested) { return tested.param.label; });

// The new damping acts from the change on.
TEST(MaterialChange, DampingIsThatOfTheNewMaterial) {
  Node node({"proxy", "proxy", 0.0}, {.stiffness_n_per_m = 1000.0});
  node.press(0.0, -0.001);
  node.press(0.0, 0.001);
  const Material damped{.stiffness_n_per_m = 1000.0, .damping_ns_per_m = 5.0};
  node.step.set_materials({&damped, 1});
  for (int i = 0; i < 101; ++i) node.press(0.0, 0.001);
  // 0.1 mm deeper in a millisecond: 0.1 m/s.
  EXPECT_NEAR(node.press(0.0, 0.0011).force_n.z(), 1.1 + 0.5, 1e-6);
}

// A change during a fade begins a new fade from the force at that moment.
TEST(MaterialChange, AnotherOneDuringAFadeMakesNoJump) {
  Node node({"proxy", "proxy", 0.0}, {.stiffness_n_per_m = 1000.0});
  node.press(0.0, -0.001);
  Vec3 last_n = node.press(0.0, 0.002).force_n;
  double largest_n = 0.0;
  for (int i = 0; i < 200; ++i) {
    const Material next{.stiffness_n_per_m = i % 2 == 0 ? 4000.0 : 500.0};
    if (i % 20 == 0) node.step.set_materials({&next, 1});
    const Vec3 force_n = node.press(0.0, 0.002).force_n;
    largest_n = std::max(largest_n, (force_n - last_n).norm());
    last_n = force_n;
  }
  EXPECT_LE(largest_n, 7.0 * kStepS / kFadeS * (1.0 + 1e-9)) << "one step's share of 7 N, the largest possible difference";
  EXPECT_EQ(node.step.counts().materials_taken, 10U);
}

TEST_P(MaterialChanges, UsesNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  Node node(GetParam(), {.stiffness_n_per_m = 1000.0});
  node.press(0.0, -0.001);
  node.press(0.0, 0.002);
  const AllocationGuard guard;
  for (int i = 0; i < 500; ++i) {
    const Material next{.stiffness_n_per_m = 500.0 + i, .friction_static = 0.01 * (i % 50), .friction_dynamic = 0.005 * (i % 50)};
    node.step.set_materials({&next, 1});
    node.press(1e-6 * i, 0.002);
  }
  EXPECT_EQ(guard.count(), 0U);
}

}  // namespace
}  // namespace hapton
