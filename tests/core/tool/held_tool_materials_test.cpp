#include <cmath>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "core/tool/held_tool.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

// Two tiles of a floor side by side, their tops at z = 0, and a distant wall that is a moving part of its own.
std::vector<std::shared_ptr<const TriangleMesh>> tiles_and_wall() {
  return {made::shared(made::box({-0.2, -0.1, -0.01}, {0.0, 0.1, 0.0})), made::shared(made::box({0.5, -0.1, -0.1}, {0.6, 0.1, 0.1})),
          made::shared(made::box({0.0, -0.1, -0.01}, {0.2, 0.1, 0.0}))};
}
const std::vector<int> kPartOfObject = {0, 1, 0};

ToolMaterials materials_of(double stiffness_n_per_m, const std::vector<double>& friction, const std::vector<double>& viscosity) {
  ToolMaterials materials{.stiffness_n_per_m = stiffness_n_per_m};
  for (const double coefficient : friction) materials.friction.push_back({coefficient, coefficient});
  for (const double coefficient : viscosity) materials.damping.push_back({0.0, coefficient});
  return materials;
}

// A cube of 20 mm that a hand moves over the tiles, 2 mm deep; as in a haptics node, with one slow step for each sample.
struct SlidingCube {
  explicit SlidingCube(const ToolMaterials& materials) {
    auto step = ToolStep::make(made::box(Vec3::Constant(-0.01), Vec3::Constant(0.01)), tiles_and_wall(),
                               {.stiffness_n_per_m = materials.stiffness_n_per_m}, materials.friction, nullptr, kPartOfObject)
                    .value();
    EXPECT_TRUE(step->damp(materials.damping));
    tool = std::make_unique<HeldTool>(std::move(step));
  }
  ToolOutput go_to(double x, double z = 0.008) {
    ToolInput input;
    input.X_WD.translation() = Vec3(x, 0.0, z);
    const Pose rest = Pose::Identity();
    input.X_SO = {&rest, 1};
    const ToolOutput felt = tool->step(input, 1'000'000 * ++sample);
    tool->follow();
    return felt;
  }
  // A slide along x at 0.1 m/s whose last sample is at x.
  ToolOutput slide_to(double x, int samples = 300) {
    ToolOutput felt;
    for (int n = samples; n >= 0; --n) felt = go_to(x - 1e-4 * n);
    return felt;
  }
  void press_down_at(double x) {
    for (int n = 0; n <= 100; ++n) go_to(x, 0.012 - 4e-5 * n);
  }

  std::unique_ptr<HeldTool> tool;
  std::int64_t sample = 0;
};

const ToolMaterials kPlain = materials_of(1000.0, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0});

TEST(HeldToolMaterials, StiffnessScalesForceAndTorqueAndMovesNothing) {
  SlidingCube cube(kPlain);
  cube.press_down_at(-0.05);
  const ToolOutput before = cube.go_to(-0.05);
  EXPECT_NEAR(before.force_n.z(), 2.0, 1e-3);
  cube.tool->set_materials(materials_of(250.0, {0, 0, 0}, {0, 0, 0}));
  const ToolOutput after = cube.go_to(-0.05);
  EXPECT_NEAR(after.force_n.z(), 0.5, 1e-3);
  EXPECT_EQ(after.X_WP.matrix(), before.X_WP.matrix());
  const ToolCoupling& coupling = cube.tool->tool().coupling();
  EXPECT_NEAR(coupling.rotational_stiffness_nm_per_rad,
              250.0 * find_mean_squared_lever(made::box(Vec3::Constant(-0.01), Vec3::Constant(0.01))), 1e-12);
}

// Whatever its materials were before, after the same slide it feels like a tool that was made with the new materials.
TEST(HeldToolMaterials, IsFeltAsIfItHadBeenMadeOfThem) {
  for (const ToolMaterials& materials : {materials_of(1000.0, {0.5, 0.0, 0.2}, {0, 0, 0}), materials_of(700.0, {0, 0, 0}, {5.0, 0.0, 2.0}),
                                         materials_of(400.0, {0.3, 0.9, 0.1}, {1.0, 3.0, 4.0}), kPlain}) {
    for (const ToolMaterials& materials_before : {kPlain, materials_of(1000.0, {0.8, 0.1, 0.4}, {2.0, 0, 0})}) {
      SlidingCube changed_cube(materials_before);
      SlidingCube new_cube(materials);
      for (SlidingCube* cube : {&changed_cube, &new_cube}) {
        cube->press_down_at(-0.1);
        cube->slide_to(-0.06);
      }
      changed_cube.tool->set_materials(materials);
      for (const double x : {-0.03, 0.05, 0.08}) {  // on the first tile, then on the second
        const ToolOutput of_changed = changed_cube.slide_to(x);
        const ToolOutput of_new = new_cube.slide_to(x);
        EXPECT_LT((of_changed.force_n - of_new.force_n).norm(), 2e-3 * of_new.force_n.norm())
            << x << ": " << of_changed.force_n.transpose() << " and " << of_new.force_n.transpose();
        EXPECT_LT((of_changed.torque_nm - of_new.torque_nm).norm(), 2e-3 * of_new.force_n.norm() * 0.02) << x;
      }
    }
  }
}

TEST(HeldToolMaterials, EachObjectHasItsOwn) {
  SlidingCube cube(kPlain);
  cube.tool->set_materials(materials_of(1000.0, {0.5, 0.9, 0.1}, {0, 0, 0}));
  cube.press_down_at(-0.1);
  EXPECT_NEAR(cube.slide_to(-0.05).force_n.x(), -0.5 * 2.0, 0.02) << "the first tile, not the wall";
  EXPECT_NEAR(cube.slide_to(0.06).force_n.x(), -0.1 * 2.0, 0.02) << "the second one";
  cube.tool->set_materials(kPlain);
  EXPECT_NEAR(cube.slide_to(0.09).force_n.x(), 0.0, 1e-3);
}

TEST(HeldToolMaterials, FewerThanThereAreObjectsChangeTheFirst) {
  SlidingCube cube(kPlain);
  cube.tool->set_materials(materials_of(1000.0, {0.5}, {0.0}));
  cube.press_down_at(-0.1);
  EXPECT_NEAR(cube.slide_to(-0.05).force_n.x(), -0.5 * 2.0, 0.02);
}

TEST(HeldToolMaterials, TakesNothingFromTheHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  SlidingCube cube(kPlain);
  cube.press_down_at(-0.1);
  const ToolMaterials rough = materials_of(500.0, {0.5, 0.5, 0.5}, {1, 1, 1});
  const AllocationGuard guard;
  cube.tool->set_materials(rough);
  cube.slide_to(-0.05, 20);
  cube.tool->set_materials(kPlain);
  cube.slide_to(-0.04, 20);
  EXPECT_EQ(guard.count(), 0U);
}

}  // namespace
}  // namespace hapton
