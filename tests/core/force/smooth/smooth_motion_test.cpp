#include <gtest/gtest.h>

#include "tests/core/force/smooth/smooth_scenes.h"

namespace hapton {
namespace {

// For any motion, no step without a force is inside a closed mesh by more than a small allowed depth.
TEST(SmoothMethod, NothingFallsThroughAClosedMesh) {
  const TriangleMesh wingnut = made::obj_mesh("wingnut.obj");
  const TriangleMesh fish = made::obj_mesh("fish_22k.obj");
  ASSERT_EQ(wingnut.triangles.size(), 6090U);
  int seed = 200;
  for (const TriangleMesh& mesh : {wingnut, fish, made::sphere(0.05, 24, 0.2), make_staircase(0.1, 5, 4), make_pit(0.1, 0.05),
                                   make_thin_wall(0.1, 0.002, 12), make_torus(0.05, 0.01, 40, 16)}) {
    const auto method = make_smooth(scene_of(mesh));
    const auto local_set = std::make_unique<LocalSet>();
    const double max_depth = 0.0025 * method->scene().diagonal();
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const std::vector<Vec3> path = wandering_path(mesh, static_cast<std::uint64_t>(seed++), 6000);
    method->reset(path[0]);
    int contact_steps = 0;
    for (std::size_t i = 0; i < path.size(); ++i) {
      const MethodOutput felt = method->step({.p_SD = path[i]});
      ASSERT_TRUE(felt.force_n.allFinite());
      contact_steps += felt.contact ? 1 : 0;
      if (felt.contact) continue;
      method->scene().select({path[i], path[i]}, 1, *local_set);
      ASSERT_FALSE(local_set->nearest > max_depth && winding_number(mesh, path[i]) > 0.5) << "step " << i;
    }
    EXPECT_GT(contact_steps, 500);
  }
}

// A plate thinner than the depth of the probe: the history of the VCP keeps the probe on the side where it entered.
TEST(SmoothMethod, AThinPlateIsNotPushedThrough) {
  const auto method = make_smooth(scene_of(make_thin_wall(0.1, 0.0005, 20)));
  method->reset(Vec3(0.0013, 0.0021, 0.005));
  for (int i = 0; i < 3000; ++i) {
    const double depth = -0.005 + std::min(0.012, 1e-5 * i);
    const Vec3 P(0.0013 + 0.02 * std::sin(1e-3 * i), 0.0021 + 0.02 * std::sin(1.7e-3 * i), 0.00025 - depth);
    const MethodOutput felt = method->step({.p_SD = P});
    if (depth > 1e-6) {
      ASSERT_NEAR(felt.force_n.z(), 1000.0 * depth, 1e-6) << i;
    }
  }
}

// The probe moves along the outside of a box and off its edge: it is released there, and touches again on the next side.
TEST(SmoothMethod, IsReleasedAtAConvexEdge) {
  const auto method = make_smooth(scene_of(make_box(Vec3(0.1, 0.1, 0.1), 4)));
  method->reset(Vec3(0.04, 0.003, 0.055));
  ASSERT_NEAR(method->step({.p_SD = Vec3(0.04, 0.003, 0.049)}).force_n.z(), 1.0, kOffsetForce);
  for (int i = 1; i <= 120; ++i) method->step({.p_SD = Vec3(0.04 + 1e-4 * i, 0.003, 0.049)});
  EXPECT_FALSE(method->is_inside());
  EXPECT_FALSE(method->step({.p_SD = Vec3(0.052, 0.003, 0.04)}).contact);
  const MethodOutput side = method->step({.p_SD = Vec3(0.0485, 0.003, 0.04)});
  EXPECT_NEAR(side.force_n.x(), 1.5, kOffsetForce);
}

// Beyond the boundary of a sheet, the probe is held as long as it is behind the faces there.
TEST(SmoothMethod, TheBoundaryOfASheetHoldsAProbeThatIsBehindIt) {
  const auto method = make_smooth(scene_of(made::sheet(0.05, 0.0, 4)));
  const double tolerance = method->scene().tolerance();
  for (const double side : {1.0, -1.0}) {
    for (const double depth : {0.001, 2.0 * tolerance, 0.5 * tolerance, -0.5 * tolerance}) {
      method->reset(Vec3(0.0495, 0.003, side * 0.001));
      method->step({.p_SD = Vec3(0.0495, 0.003, -side * 0.001)});
      ASSERT_TRUE(method->is_inside());
      method->step({.p_SD = Vec3(0.0505, 0.003, -side * 0.001)});
      ASSERT_TRUE(method->is_inside());
      const MethodOutput felt = method->step({.p_SD = Vec3(0.0505, 0.003, -side * depth)});
      EXPECT_EQ(method->is_inside(), depth > tolerance) << depth;
      if (depth > tolerance) {
        EXPECT_LT((felt.p_SP - Vec3(0.05, 0.003, 0.0)).norm(), 1e-8) << depth;
      }
    }
  }
}

// In a groove the probe is held by both walls at once, at the bottom.
TEST(SmoothMethod, AGrooveHoldsAtItsBottom) {
  const auto method = make_smooth(scene_of(make_gutter(0.1, 0.03, 0.5 * std::numbers::pi, 8)));
  const Vec3 bottom(0.0, 0.05 - 0.03, 0.011);
  method->reset(bottom + Vec3(0, 0.01, 0));
  MethodOutput felt;
  for (int i = 0; i <= 130; ++i) felt = method->step({.p_SD = bottom + Vec3(1e-6 * i, 0.01 - 1e-4 * i, 0)});
  EXPECT_LT((felt.p_SP - bottom).norm(), 5e-5);
  EXPECT_NEAR(felt.force_n.y(), 3.0, 0.1);
}

TEST(SmoothMethod, IsTheSameAtEveryScaleAndPosition) {
  SCOPED_TRACE("seed 103");
  const TriangleMesh mesh = made::sphere(0.05, 16, 0.1);
  const std::vector<Vec3> path = wandering_path(mesh, 103, 1500);
  const auto base = make_smooth(scene_of(mesh));
  base->reset(path[0]);
  std::vector<MethodOutput> expected;
  for (const Vec3& P : path) expected.push_back(base->step({.p_SD = P}));
  struct Placement {
    double scale;
    Vec3 move;
    double tolerance;
  };
  for (const Placement& placement : {Placement{1e-6, Vec3::Zero(), 1e-6}, Placement{1e6, Vec3::Zero(), 1e-6},
                                     Placement{1.0, Vec3(1e3, -2e3, 1e3), 1e-6}, Placement{1e3, Vec3(1e6, 1e6, -1e6), 1e-6}}) {
    const auto method = make_smooth(scene_of(scaled_and_moved(mesh, placement.scale, placement.move)));
    method->reset(placement.scale * path[0] + placement.move);
    int different_steps = 0;
    int contacts = 0;
    for (std::size_t i = 0; i < path.size(); ++i) {
      const MethodOutput felt = method->step({.p_SD = placement.scale * path[i] + placement.move});
      contacts += expected[i].contact ? 1 : 0;
      different_steps +=
          (felt.force_n / placement.scale - expected[i].force_n).norm() > placement.tolerance * (1.0 + expected[i].force_n.norm()) ? 1 : 0;
    }
    EXPECT_GT(contacts, 100);
    // At a tie rounding may choose the other side, but rarely.
    EXPECT_LE(different_steps, contacts / 50) << "scale " << placement.scale << " at " << placement.move.transpose();
  }
}

TEST(SmoothMethod, ANotFiniteSampleIsIgnored) {
  const auto method = make_smooth(scene_of(make_icosphere(0.05, 3)));
  const Vec3 inside(0.049, 0.001, 0.002);
  method->reset(Vec3(0.06, 0, 0));
  const Vec3 before = method->step({.p_SD = inside}).force_n;
  for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
    const MethodOutput felt = method->step({.p_SD = Vec3(0, bad, 0)});
    EXPECT_TRUE(felt.force_n.isZero(0.0));
    EXPECT_FALSE(felt.contact);
    EXPECT_TRUE(felt.p_SP.allFinite());
  }
  EXPECT_LT((method->step({.p_SD = inside}).force_n - before).norm(), 1e-9);
  EXPECT_GT(before.norm(), 0.5);
}

// A moving surface carries along a probe inside and catches a probe outside; the force is that of a scene built in that shape.
TEST(SmoothMethod, MovingAndDeformingSurfacesExertForces) {
  TriangleMesh mesh = make_icosphere(0.05, 3);
  const auto method = make_smooth(scene_of(mesh));
  const Vec3 device(0.0485, 0.004, -0.003);
  method->reset(Vec3(0.06, 0, 0));
  ASSERT_TRUE(method->step({.p_SD = device}).contact);
  const std::vector<Vec3> rest = mesh.vertices;
  for (int i = 1; i <= 60; ++i) {
    // The sphere swells along x and drifts along y.
    for (std::size_t v = 0; v < rest.size(); ++v)
      mesh.vertices[v] = Vec3(rest[v].x() * (1.0 + 2e-4 * i), rest[v].y() + 1e-5 * i, rest[v].z());
    ASSERT_TRUE(method->move_vertices(0, mesh.vertices));
    const Vec3 felt = method->step({.p_SD = device}).force_n;
    const auto anew = make_smooth(scene_of(mesh));
    anew->reset(Vec3(0.07, 0, 0));
    anew->step({.p_SD = Vec3(0.052 + 2e-5 * i, 0.004, -0.003)});
    const Vec3 expected = anew->step({.p_SD = device}).force_n;
    ASSERT_GT(expected.norm(), 0.5);
    EXPECT_LT((felt - expected).norm(), 1e-4) << i;
  }
  EXPECT_EQ(method->counters().entries, 1U);
}

TEST(SmoothMethod, ASurfaceThatSweepsOverTheProbeCatchesIt) {
  TriangleMesh mesh = make_plane_grid(0.1, 10);
  const auto method = make_smooth(scene_of(mesh));
  const Vec3 device(0.0013, 0.0021, 0.002);
  method->reset(device);
  EXPECT_FALSE(method->step({.p_SD = device}).contact);
  for (Vec3& v : mesh.vertices) v.z() += 0.003;
  ASSERT_TRUE(method->move_vertices(0, mesh.vertices));
  EXPECT_NEAR(method->step({.p_SD = device}).force_n.z(), 1.0, 1e-6);
  for (Vec3& v : mesh.vertices) v.z() -= 0.003;
  ASSERT_TRUE(method->move_vertices(0, mesh.vertices));
  EXPECT_FALSE(method->step({.p_SD = device}).contact);
  EXPECT_EQ(method->counters().releases, 1U);
}

TEST(SmoothMethod, FreeSpaceIsSkipped) {
  const auto method = make_smooth(scene_of(make_icosphere(0.05, 4)));
  method->reset(Vec3(0.2, 0, 0));
  for (int i = 0; i < 1000; ++i) method->step({.p_SD = Vec3(0.2 - 1e-5 * i, 1e-5 * i, 0)});
  EXPECT_GT(method->counters().skipped, 990U);
  EXPECT_LE(method->counters().selections, 2U);
}

}  // namespace
}  // namespace hapton
