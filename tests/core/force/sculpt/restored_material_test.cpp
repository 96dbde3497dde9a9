// Material that comes back while the hand is there.
#include <gtest/gtest.h>

#include <memory>

#include "core/force/sculpt/sculpt_method.h"
#include "core/geometry/mesh_shapes.h"
#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

constexpr double kBlockTop = 0.02;
constexpr double kStiffnessOfBlock = 500.0;

struct RestoredMaterial : testing::Test {
  RestoredMaterial() {
    const TouchScene scene{.objects = {{.mesh = std::make_shared<const TriangleMesh>(make_box(Vec3(0.08, 0.06, 2.0 * kBlockTop))),
                                        .material = {.stiffness_n_per_m = kStiffnessOfBlock},
                                        .sculpt = SculptSettings{.voxel_m = 0.001, .tool_radius_m = 0.005, .button = 1}}}};
    method = std::move(*make_method({}, scene));
    uncarved = std::make_unique<Sculpture>(*method->sculpture());
  }
  MethodOutput step(const Vec3& hand, bool is_down = false) {
    return method->step({.p_SD = hand, .dt_s = 1e-3, .buttons = is_down ? 1U : 0U});
  }
  // Digs a pit down to the middle of the block, and takes the hand out of it.
  void dig(double x = 0.0) {
    for (int i = 0; i <= 300; ++i) step({x, 0, 0.03 - 1e-4 * i}, true);
    for (int i = 0; i <= 300; ++i) step({x, 0, 1e-4 * i});
  }
  std::unique_ptr<ForceMethod> method;
  std::unique_ptr<Sculpture> uncarved;
};

TEST_F(RestoredMaterial, IsFeltAsBeforeItWasCarved) {
  step({0, 0, 0.04});
  const double uncarved_n = step({0, 0, 0.022}).force_n.z();
  step({0, 0, 0.04});
  dig();
  step({0, 0, 0.04});
  EXPECT_LT(step({0, 0, 0.022}).force_n.z(), 1e-6) << "a pit";
  step({0, 0, 0.04});
  const std::uint32_t carves = method->sculpture()->newest();
  ASSERT_TRUE(method->restore_sculpture(*uncarved, carves + 1));
  EXPECT_EQ(method->sculpture()->newest(), carves + 1);
  step({0, 0, 0.04});
  EXPECT_NEAR(step({0, 0, 0.022}).force_n.z(), uncarved_n, 1e-9);
  EXPECT_GT(uncarved_n, 0.5);
}

// The hand presses at the bottom of the pit when the material comes back, which would push the hand out by centimetres.
TEST_F(RestoredMaterial, ReleasesAHandInsideUntilItHasLeft) {
  dig();
  for (int i = 0; i <= 320; ++i) step({0, 0, 0.03 - 1e-4 * i});
  ASSERT_GT(step({0, 0, -0.002}).force_n.norm(), 0.3);
  ASSERT_TRUE(method->restore_sculpture(*uncarved, method->sculpture()->newest() + 1));
  const std::uint32_t carves = method->sculpture()->newest();
  for (int i = 0; i <= 250; ++i) {
    const MethodOutput felt = step({0, 0, -0.002 + 1e-4 * i}, i % 2 == 0);
    ASSERT_EQ(felt.force_n, Vec3(Vec3::Zero())) << i;
    ASSERT_FALSE(felt.contact);
  }
  EXPECT_EQ(method->sculpture()->newest(), carves) << "inside it carves nothing";
  step({0, 0, 0.03});
  EXPECT_GT(step({0, 0, 0.022}).force_n.z(), 0.5) << "from outside the material is felt again";
}

// A hand that touches elsewhere keeps its contact.
TEST_F(RestoredMaterial, ElsewhereKeepsTheContact) {
  dig();
  step({0.03, 0.02, 0.04});
  const MethodOutput before = step({0.03, 0.02, 0.022});
  ASSERT_TRUE(before.contact);
  ASSERT_TRUE(method->restore_sculpture(*uncarved, method->sculpture()->newest() + 1));
  const MethodOutput after = step({0.03, 0.02, 0.022});
  EXPECT_TRUE(after.contact);
  EXPECT_LT((after.force_n - before.force_n).norm(), 0.02 * before.force_n.norm());
}

// The material comes back in the middle of a cut: the cut stops, and begins again when the hand comes from outside.
TEST_F(RestoredMaterial, StopsACutInsideIt) {
  for (int i = 0; i <= 250; ++i) step({0, 0, 0.03 - 1e-4 * i}, true);
  ASSERT_TRUE(method->restore_sculpture(*uncarved, method->sculpture()->newest() + 1));
  const std::uint32_t carves = method->sculpture()->newest();
  for (int i = 0; i <= 100; ++i) EXPECT_EQ(step({1e-4 * i, 0, 0.005}, true).force_n.norm(), 0.0);
  EXPECT_EQ(method->sculpture()->newest(), carves);
  step({0, 0, 0.04}, true);
  for (int i = 0; i <= 200; ++i) step({0, 0, 0.03 - 1e-4 * i}, true);
  EXPECT_GT(method->sculpture()->newest(), carves + 5);
}

TEST_F(RestoredMaterial, OfOtherBodiesIsRejected) {
  dig();
  Sculpture other;
  ASSERT_TRUE(other.add(0, {.voxel_m = 0.0011, .tool_radius_m = 0.005, .button = 1}, make_box(Vec3(0.08, 0.06, 0.04))));
  const std::uint32_t carves = method->sculpture()->newest();
  EXPECT_FALSE(method->restore_sculpture(other, carves + 1));
  EXPECT_EQ(method->sculpture()->newest(), carves);
}

TEST_F(RestoredMaterial, UsesNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP();
  dig();
  step({0, 0, 0.0});
  const AllocationGuard guard;
  ASSERT_TRUE(method->restore_sculpture(*uncarved, method->sculpture()->newest() + 1));
  step({0, 0, 0.0});
  EXPECT_EQ(guard.count(), 0U);
}

TEST_F(RestoredMaterial, EachPressIsMarkedByItsFirstCarve) {
  int presses = 0;
  const auto count = [&](const Vec3& hand, bool is_down) {
    step(hand, is_down);
    presses += method->sculpture()->made() && method->sculpture()->made()->begins ? 1 : 0;
  };
  for (int i = 0; i <= 150; ++i) count({0, 0, 0.03 - 1e-4 * i}, true);
  EXPECT_EQ(presses, 1);
  // When the hand goes through free space with the button down, it is the same press.
  for (int i = 0; i <= 150; ++i) count({0.02, 0, 0.015 + 1e-4 * i}, true);
  for (int i = 0; i <= 150; ++i) count({0.02, 0, 0.03 - 1e-4 * i}, true);
  EXPECT_EQ(presses, 1);
  count({0.02, 0, 0.03}, false);
  for (int i = 0; i <= 150; ++i) count({-0.02, 0, 0.03 - 1e-4 * i}, true);
  EXPECT_EQ(presses, 2);
}

}  // namespace
}  // namespace hapton
