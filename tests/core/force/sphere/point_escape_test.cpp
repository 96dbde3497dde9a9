// A small sphere that represents a point, held where the point itself would not be: its ways out (core/force/sphere/point_escape.cpp).
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "tests/core/force/sphere/sphere_stage.h"

namespace hapton {
namespace {

constexpr double kPointOffset = 1e-7;  // offset that represents a point, for a mesh one unit large

// In the frame of the notch: a plate in z = 0, and below it a body with its top at z = -gap and a notch in it, between two vertical walls
// that meet in the z axis at the given angle.
TriangleMesh make_notch_under_plate(double gap, double angle) {
  constexpr double kDepth = 0.2;
  const double x = 0.4 * std::sin(0.5 * angle);
  const double y = 0.4 * std::cos(0.5 * angle);
  TriangleMesh mesh;
  mesh.vertices = {{-0.5, -0.5, 0.0}, {0.5, -0.5, 0.0},   {0.5, 0.5, 0.0}, {-0.5, 0.5, 0.0},    {0.0, 0.0, -gap}, {x, y, -gap},
                   {0.4, -0.2, -gap}, {-0.4, -0.2, -gap}, {-x, y, -gap},   {0.0, 0.0, -kDepth}, {x, y, -kDepth},  {-x, y, -kDepth}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}, {4, 7, 8}, {4, 9, 10}, {4, 10, 5}, {4, 11, 9}, {4, 8, 11}};
  return mesh;
}

struct Notch {
  double gap_offsets;
  double angle;
};

class UnderAPlate : public testing::TestWithParam<Notch> {};

// The gap between plate and top is narrower than the sphere, but the plate's plane passes the apex of the notch on the far side of the
// centre. The point goes down the line where the walls meet.
TEST_P(UnderAPlate, APointLeavesANotchDownwards) {
  const Notch& notch = GetParam();
  const std::uint64_t seed = 1;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 6; ++i) {
    const Eigen::Quaterniond turn = Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random)).normalized();
    TriangleMesh mesh = make_notch_under_plate(notch.gap_offsets * kPointOffset, notch.angle);
    for (Vec3& vertex : mesh.vertices) vertex = turn * vertex;
    Stage stage(mesh, kPointOffset);
    stage.follower = std::make_unique<SphereFollower>(stage.geometry, stage.materials, stage.offset, true);
    stage.put(turn * Vec3(0.001, 0.1, -0.1));
    const Vec3 above(0.0003, -0.05, 0.05);
    const Vec3 below(0.0003, -0.05, -0.05);
    stage.finish(stage.geometry.to_local(turn * above));
    const Vec3 held = turn.conjugate() * stage.centre();
    ASSERT_LT((held - Vec3(0.0, 0.0, -kPointOffset)).norm(), 20.0 * kPointOffset) << held.transpose();
    EXPECT_EQ(stage.finish(stage.geometry.to_local(turn * below)), Outcome::settled);
    const Vec3 left = turn.conjugate() * stage.centre();
    EXPECT_LT((left - Vec3(0.0, 0.0, below.z())).norm(), 20.0 * kPointOffset) << left.transpose();
    EXPECT_GE(stage.distance_to_nearest(), stage.offset - kSlop);
  }
}

INSTANTIATE_TEST_SUITE_P(Gaps, UnderAPlate,
                         testing::Values(Notch{0.3, std::numbers::pi / 3.0}, Notch{1.2, std::numbers::pi / 3.0},
                                         Notch{1.5, std::numbers::pi / 3.0}, Notch{1.757, std::numbers::pi / 3.0},
                                         Notch{1.9, std::numbers::pi / 3.0}, Notch{1.5, 0.3}, Notch{1.8, 0.3}, Notch{1.5, 2.0},
                                         Notch{1.9, 2.0}));

// Two sheets meet in a corner at a small angle and end at y = 0. A point is between them, and its device exactly in the plane y = 0, in
// front of the corner: over the sheets the point is at a minimum, but beyond their boundary the slit is wider.
TEST(APointInASlit, LeavesItOverTheBoundaryThatItIsAt) {
  const std::uint64_t seed = 5;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  for (const double gap : {3e-7, 1e-6, 1e-5}) {
    for (int i = 0; i < 4; ++i) {
      const Eigen::Quaterniond turn = i == 0
                                          ? Eigen::Quaterniond::Identity()
                                          : Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random)).normalized();
      TriangleMesh mesh;
      mesh.vertices = {{-0.5, 0.0, 0.0}, {0.5, 0.0, 0.0}, {0.5, 0.4, 0.0}, {-0.5, 0.4, 0.0}, {-0.5, 0.0, gap}, {-0.5, 0.4, gap}};
      mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {4, 1, 2}, {4, 2, 5}};
      for (Vec3& vertex : mesh.vertices) vertex = turn * vertex;
      Stage stage(mesh, kPointOffset);
      stage.follower = std::make_unique<SphereFollower>(stage.geometry, stage.materials, stage.offset, true);
      stage.put(turn * Vec3(-0.6, 0.1, 0.5 * gap));
      for (const Vec3& to : {Vec3(-0.45, 0.1, 0.45 * gap), Vec3(-0.3, 0.01, -0.01), Vec3(0.9, 0.0, -0.01), Vec3(0.92, 0.0, -0.011)})
        stage.finish(stage.geometry.to_local(turn * to));
      EXPECT_TRUE(stage.follower->is_free() || (stage.device - stage.follower->centre()).norm() < 0.1)
          << gap << " " << i << ": " << (turn.conjugate() * stage.centre()).transpose();
      EXPECT_GE(stage.distance_to_nearest(), stage.offset - kSlop);
    }
  }
}

// The notch again, with little work for each call. To find that no wedge of planes holds the point may take so much of it that too little
// is left for a way out: the next call goes on with the ways out, and each call tries at least one.
TEST(APointInANotch, ComesToAnEndHoweverLittleWorkACallHas) {
  const TriangleMesh mesh = make_notch_under_plate(1.5 * kPointOffset, std::numbers::pi / 3.0);
  for (int most_work = 10; most_work <= 160; most_work += 5) {
    SCOPED_TRACE(testing::Message() << most_work << " units a call");
    Stage stage(mesh, kPointOffset);
    stage.follower = std::make_unique<SphereFollower>(stage.geometry, stage.materials, stage.offset, true);
    stage.put(Vec3(0.001, 0.1, -0.1));
    for (const double z : {0.05, -0.05}) {
      const Vec3 device = stage.geometry.to_local(Vec3(0.0003, -0.05, z));
      Outcome outcome = Outcome::exhausted;
      int calls = 0;
      for (; calls < 400 && outcome == Outcome::exhausted; ++calls) {
        double time = 0.0;
        outcome = stage.follower->follow(stage.device, device, time, most_work);
        stage.device = outcome == Outcome::exhausted ? on_path(stage.device, device, time) : device;
      }
      EXPECT_EQ(outcome, Outcome::settled);
    }
    EXPECT_LT((stage.centre() - Vec3(0.0, 0.0, -0.05)).norm(), 20.0 * kPointOffset) << stage.centre().transpose();
  }
}

// Two sheets that cross at a small angle hold the point. When it starts anew at another place, it no longer counts as in a slit, even if it
// cannot start there because that place is on a sheet.
TEST(APointInASlit, NoLongerCountsAsInASlitAfterAStart) {
  int slits = 0;
  for (const double angle : {1e-6, 1e-5, 1e-4}) {
    TriangleMesh mesh;
    for (const double slope : {0.0, angle}) {
      for (const auto& [x, y] : {std::pair(-0.5, -0.2), {0.5, -0.2}, {0.5, 0.2}, {-0.5, 0.2}}) mesh.vertices.emplace_back(x, y, slope * x);
    }
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}};
    Stage stage(mesh, kPointOffset);
    stage.follower = std::make_unique<SphereFollower>(stage.geometry, stage.materials, stage.offset, true);
    stage.put({0.3, 0.013, 0.15 * angle});
    stage.finish(stage.geometry.to_local({-0.1, 0.021, -0.05}));
    slits += stage.follower->is_in_slit() ? 1 : 0;
    EXPECT_FALSE(stage.follower->start(stage.geometry.to_local({0.3, 0.1, 0.0}), false, 0.0)) << angle;
    EXPECT_FALSE(stage.follower->is_in_slit()) << angle;
  }
  EXPECT_GT(slits, 0) << "no point was in a slit: this test proves nothing";
}

}  // namespace
}  // namespace hapton
