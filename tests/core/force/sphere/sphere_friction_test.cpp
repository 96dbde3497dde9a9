#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>

#include "core/force/sliding_friction.h"
#include "core/geometry/mesh_shapes.h"
#include "tests/core/force/sphere/sphere_stage.h"
#include "tests/support/allocation_guard.h"

// SphereFollower under Coulomb friction.
namespace hapton {
namespace {

constexpr Material kRubbing{.friction_static = 0.5, .friction_dynamic = 0.3};

TEST(SphereFollowerWithFriction, SticksExactlyInsideTheCone) {
  Stage stage(made::sphere(0.4, 16, 0.05), 0.03, kRubbing);
  stage.put({0.3, 0.4, 0.5});
  stage.move(0.39 * Vec3(0.3, 0.4, 0.5).normalized());
  ASSERT_FALSE(stage.follower->is_free());
  const Vec3 before = stage.follower->centre();
  const Vec3 out = (before - stage.device).normalized();
  const Vec3 aside = out.unitOrthogonal();
  for (int i = 0; i < 200; ++i) {
    const double depth = (before - stage.device).norm();
    const double turn = 0.1 * i;
    const Vec3 offset = 0.1 * depth * (std::cos(turn) * aside + std::sin(turn) * out.cross(aside));
    ASSERT_EQ(stage.move_local(before - 0.02 * (1.0 + 0.5 * std::sin(0.3 * i)) * out + offset * (0.02 / depth)), Outcome::settled);
    ASSERT_EQ(stage.follower->centre(), before) << "step " << i;
  }
}

// Over a sheet of many faces the sphere moves as a point on a plane does, in closed form.
TEST(SphereFollowerWithFriction, OverAPlaneItIsDraggedAsInClosedForm) {
  Stage stage(made::sheet(0.5, 0.0, 13), kStageOffset, kRubbing);
  stage.put({0.03, 0.02, 0.4});
  ASSERT_EQ(stage.move({0.03, 0.02, 0.0}), Outcome::settled);
  FrictionDrag expected;
  Vec3 device(0.03, 0.02, 0.0);
  for (int i = 0; i < 300; ++i) {
    const Vec3 to(0.3 * std::cos(0.31 * i), 0.3 * std::sin(0.17 * i), -0.05 - 0.04 * std::sin(0.7 * i));
    const Vec3 motion(to.x() - device.x(), to.y() - device.y(), 0.0);
    expected = drag_by_friction({.pull = expected.pull,
                                 .motion = motion,
                                 .pressure_start = kStageOffset - device.z(),
                                 .pressure_end = kStageOffset - to.z(),
                                 .friction_static = kRubbing.friction_static,
                                 .friction_dynamic = kRubbing.friction_dynamic,
                                 .sliding = expected.sliding});
    ASSERT_EQ(stage.move(to), Outcome::settled);
    ASSERT_LT((stage.centre() - (Vec3(to.x(), to.y(), kStageOffset) - expected.pull)).norm(), 1e-11) << "step " << i;
    ASSERT_EQ(stage.follower->slides(), expected.sliding) << "step " << i;
    device = to;
  }
}

// A flight ends the slide, even if the sphere slides off one surface and lands on another within one motion of the device.
TEST(SphereFollowerWithFriction, SticksWhereItLandsAfterAGapInOneMotion) {
  constexpr Material kGripping{.friction_static = 0.8, .friction_dynamic = 0.3};
  Stage stage(joined(made::sheet(0.5, 0.0, 2), made::sheet(0.5, 0.5, 2)), kStageOffset, kGripping);
  stage.put({-0.3, 0.11, 0.2});
  ASSERT_EQ(stage.move({-0.3, 0.11, 0.05}), Outcome::settled);
  ASSERT_EQ(stage.move({-0.2, 0.11, 0.05}), Outcome::settled);
  ASSERT_TRUE(stage.follower->slides());
  SphereFollower in_parts(*stage.follower);
  const Vec3 from = stage.device;
  // Through the gap and into the ceiling, at a slope between the two coefficients.
  ASSERT_EQ(stage.move({0.0, 0.11, 0.45}), Outcome::settled);
  EXPECT_FALSE(stage.follower->slides());
  EXPECT_LT((stage.centre() - Vec3(-0.025, 0.11, 0.4)).norm(), kCentreTolerance) << stage.centre().transpose();
  ASSERT_TRUE(follow_in_parts(in_parts, from, stage.device));
  EXPECT_LT((in_parts.centre() - stage.follower->centre()).norm(), kCentreTolerance);
}

// A motion that is undone does not count: a sweep goes on from where the centre was, with the coefficient that held it there. An object
// that was built late counts as soon as the centre is out of its bounds, however near.
TEST(SphereFollowerWithFriction, SticksWhereItIsPutBackBesideALateObject) {
  const auto sheet = made::shared(made::sheet(0.5, 0.0, 4));
  const auto late = made::shared(scaled_and_moved(made::sheet(0.02, 0.0, 2), 1.0, Vec3(0.07, 0.0, 0.13)));
  TouchGeometry geometry({sheet, late}, BuildPolicy::on_approach, std::nullopt, Box{Vec3::Constant(-1.0), Vec3::Constant(1.0)});
  const std::vector<Material> materials{kRubbing, kRubbing};
  SphereFollower follower(geometry, materials, kStageOffset / geometry.unit_m());
  const auto build_next = [&](double range) {
    geometry.request_ahead(follower.centre(), range);
    ASSERT_TRUE(geometry.build_requested());
    geometry.request_ahead(follower.centre(), range);
    follower.forget_near();
  };
  const Vec3 above = geometry.to_local(Vec3(0.0, 0.0, 0.2));
  const Vec3 below = geometry.to_local(Vec3(0.0, 0.0, 0.02));
  follower.start_free(above);
  build_next(0.0);
  ASSERT_EQ(geometry.waiting_count(), 1U);
  double time = 0.0;
  ASSERT_EQ(follower.follow(above, below, time), Outcome::settled);
  ASSERT_FALSE(follower.is_free());
  const Vec3 centre = follower.centre();
  build_next(10.0);
  ASSERT_EQ(geometry.waiting_count(), 0U);
  // The device goes out of the static cone, away from the late sheet; the centre is still too near to that sheet.
  time = 0.0;
  ASSERT_EQ(follower.follow(below, geometry.to_local(Vec3(-0.06, 0.0, 0.02)), time), Outcome::failed);
  EXPECT_EQ(follower.centre(), centre);
  EXPECT_EQ(time, 0.0);
  EXPECT_FALSE(follower.slides());
}

TEST(SphereFollowerWithFriction, InACornerOfThreeWallsItStays) {
  TriangleMesh room = made::box(Vec3::Zero(), Vec3::Ones());
  for (Triangle& triangle : room.triangles) std::swap(triangle[1], triangle[2]);
  Stage stage(room, kStageOffset, {.friction_static = 0.3, .friction_dynamic = 0.2, .two_sided = false});
  stage.put({0.4, 0.5, 0.6});
  ASSERT_EQ(stage.move({-0.1, -0.2, -0.3}), Outcome::settled);
  ASSERT_EQ(stage.move({-1.0, -1.0, -1.0}), Outcome::settled);
  expect_centre(stage, Vec3::Constant(kStageOffset));
  ASSERT_EQ(stage.follower->contacts().size(), 3U);
  // Along one edge of the room: the centre stays behind by mu times the depth.
  ASSERT_EQ(stage.move({-0.2, 0.6, -0.3}), Outcome::settled);
  const double pull = 0.2 * std::hypot(0.3, 0.4);
  EXPECT_LT((stage.centre() - Vec3(kStageOffset, 0.6 - pull, kStageOffset)).norm(), 1e-11) << stage.centre().transpose();
  EXPECT_TRUE(stage.follower->slides());
  // The device goes a little back: the centre stays.
  const Vec3 held_centre = stage.follower->centre();
  ASSERT_EQ(stage.move({-0.2, 0.6 - 0.5 * pull, -0.3}), Outcome::settled);
  EXPECT_EQ(stage.follower->centre(), held_centre);
}

// A roof whose ridge is the y axis.
TriangleMesh make_roof() {
  TriangleMesh roof;
  for (const double y : {-1.0, 1.0}) {
    for (const Vec3& p : {Vec3(0, y, 0), Vec3(-1, y, -1), Vec3(1, y, -1)}) roof.vertices.push_back(p);
  }
  roof.triangles = {{0, 2, 1}, {3, 4, 5}, {0, 3, 5}, {0, 5, 2}, {0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}};
  return roof;
}

// The centre slips along the ridge and turns off it within an offset, at a place that depends on the logarithm of how far aside the device
// is. The centre must not come out on the other side of the faces.
TEST(SphereFollowerWithFriction, AlongARidgeWithTheDeviceStraightBelowItStaysOutside) {
  constexpr double kStart = -0.9;
  int turned_off = 0;
  for (const double offset_m : {1e-9, 1e-6, 1e-3}) {
    for (const double aside_m : {0.0, 1e-300, -1e-129, 1e-60, 1e-30, -1e-16, 1e-12, 1e-9, -1e-6, 1e-3}) {
      for (const double along_m : {-0.8999, -0.89, -0.8, -0.3, 0.2, 0.8}) {
        Stage stage(make_roof(), offset_m, kRubbing);
        stage.put({0.0, kStart, 0.1});
        ASSERT_EQ(stage.move({0.0, kStart, -1e-3}), Outcome::settled);
        ASSERT_FALSE(stage.follower->is_free());
        const Outcome outcome = stage.finish(stage.geometry.to_local(Vec3(aside_m, along_m, -0.02)));
        const Vec3 centre = stage.centre();
        ASSERT_FALSE(stage.follower->is_free()) << "offset " << offset_m << ", aside " << aside_m << ", along " << along_m;
        ASSERT_GE(centre.z() + std::fabs(centre.x()), 0.0)
            << "offset " << offset_m << ", aside " << aside_m << ", along " << along_m << ": " << centre.transpose();
        ASSERT_TRUE(outcome != Outcome::settled || stage.distance_to_nearest() >= stage.offset - kSlop);
        turned_off += std::fabs(centre.x()) > offset_m ? 1 : 0;
      }
    }
  }
  EXPECT_GT(turned_off, 10) << "few centres turn off the ridge: this test proves little";
}

class OverBumpsWithFriction : public testing::TestWithParam<std::tuple<std::uint64_t, double, double>> {};

TEST_P(OverBumpsWithFriction, OneStepIsTheSameMotionInParts) {
  constexpr double kStiffness = 1000.0;  // N/m
  constexpr int kSteps = 160;
  const auto [seed, static_mu, dynamic_mu] = GetParam();
  RecordProperty("seed", std::to_string(seed));
  Stage stage(made::sphere(0.4, 16, 0.05), 0.03, {.friction_static = static_mu, .friction_dynamic = dynamic_mu});
  Wanderer wanderer(seed);
  stage.put({0.3, 0.5, 0.7});
  int contact_steps = 0;
  int sliding_steps = 0;
  int several_contact_steps = 0;
  double worst_error = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const Vec3 from = stage.device;
    const Vec3 to = stage.geometry.to_local(wanderer.next(i % 4 == 0 ? 0.2 : 0.05));
    SphereFollower in_parts(*stage.follower);
    ASSERT_EQ(stage.finish(to), Outcome::settled) << "step " << i;
    ASSERT_GE(stage.distance_to_nearest(), stage.offset - kSlop) << "step " << i;
    ASSERT_TRUE(follow_in_parts(in_parts, from, to)) << "step " << i;
    const double error = kStiffness * stage.unit() * (stage.follower->centre() - in_parts.centre()).norm();
    const double force = kStiffness * stage.unit() * (stage.follower->centre() - to).norm();
    worst_error = std::max(worst_error, error / std::max(1.0, force));
    ASSERT_LE(error, 1e-8 * std::max(1.0, force)) << "N, step " << i;
    contact_steps += stage.follower->is_free() ? 0 : 1;
    sliding_steps += stage.follower->slides() ? 1 : 0;
    several_contact_steps += stage.follower->contacts().size() > 1 ? 1 : 0;
  }
  RecordProperty("worst", std::to_string(worst_error));
  EXPECT_GT(contact_steps, kSteps / 2);
  EXPECT_GT(sliding_steps, kSteps / 4);
  RecordProperty("several", several_contact_steps);
}

INSTANTIATE_TEST_SUITE_P(Seeds, OverBumpsWithFriction,
                         testing::Combine(testing::Values(1, 2, 3, 4), testing::Values(0.5), testing::Values(0.5, 0.3)));

// A sphere that stands for a point: its radius is a small number of units in the last digits of its position.
struct PointStage {
  explicit PointStage(const TriangleMesh& mesh) : geometry({&mesh}), materials{kRubbing}, follower(geometry, materials, 0x1p-31, true) {}

  void put(const Vec3& p_S) {
    device = geometry.to_local(p_S);
    follower.start_free(device);
  }
  Outcome move(const Vec3& p_S) {
    const Vec3 to = geometry.to_local(p_S);
    double time = 0.0;
    const std::uint64_t events_before = follower.events();
    const std::uint64_t work_before = follower.queried();
    const Outcome outcome = follower.follow(device, to, time);
    events = follower.events() - events_before;
    work = follower.queried() - work_before;
    device = to;
    return outcome;
  }

  TouchGeometry geometry;
  std::vector<Material> materials;
  SphereFollower follower;
  Vec3 device = Vec3::Zero();
  std::uint64_t events = 0, work = 0;  // of the last step
};

// At the boundary the point slips around the edge until the pull no longer presses it against the edge. Rounding of the position turns the
// normal there by a millionth, so the multiplier is never found to be zero.
TEST(SphereFollowerWithFriction, APointSlipsOffABoundaryInAFewPieces) {
  constexpr std::uint64_t kMaxWork = 1024;  // before contacts were released at the end of a slip: more than 4,096, and still held
  const TriangleMesh flat = made::sheet(0.5, 0.0, 5);
  for (int i = 0; i < 32; ++i) {
    const Eigen::Matrix3d turn =
        (Eigen::AngleAxisd(0.3 + 0.1 * i, Vec3::UnitX()) * Eigen::AngleAxisd(0.7 * i, Vec3::UnitZ())).toRotationMatrix();
    TriangleMesh sheet = flat;
    for (Vec3& p : sheet.vertices) p = turn * p;
    PointStage stage(sheet);
    const double depth = 0.002 * (i + 1);
    stage.put(turn * Vec3(0.437, 0.013, 0.1));
    ASSERT_EQ(stage.move(turn * Vec3(0.437, 0.013, -depth)), Outcome::settled) << i;
    ASSERT_FALSE(stage.follower.is_free()) << i;
    for (double x = 0.44; x < 0.56 + depth; x += 0.01) {
      ASSERT_EQ(stage.move(turn * Vec3(x, 0.013 + 0.1 * (x - 0.437), -depth)), Outcome::settled) << i << ", x " << x;
      ASSERT_LE(stage.work, kMaxWork) << i << ", x " << x;
    }
    EXPECT_TRUE(stage.follower.is_free()) << i;
  }
}

// The lag is far shorter than the motion, and across it: the point turns sharply.
TEST(SphereFollowerWithFriction, APointTurnsOnAFreeFaceInOnePiece) {
  constexpr double kDepth = 1e-4;
  constexpr std::uint64_t kMaxEvents = 8;  // with the path cut into pieces near a cubic: 97
  const TriangleMesh sheet = made::sheet(0.5, 0.0, 2);
  PointStage stage(sheet);
  stage.put({-0.3, 0.1, 0.1});
  ASSERT_EQ(stage.move({-0.3, 0.1, -kDepth}), Outcome::settled);
  ASSERT_EQ(stage.move({-0.2, 0.1, -kDepth}), Outcome::settled);
  FrictionDrag lag{.pull = {kRubbing.friction_dynamic * kDepth, 0.0, 0.0}, .sliding = true};
  const Vec3 start(-0.2, 0.1, 0.0);
  const Vec3 to(-0.18, 0.25, 0.0);
  ASSERT_EQ(stage.move(to - Vec3(0.0, 0.0, kDepth)), Outcome::settled);
  EXPECT_LE(stage.events, kMaxEvents);
  lag = drag_by_friction({.pull = lag.pull,
                          .motion = to - start,
                          .pressure_start = kDepth,
                          .pressure_end = kDepth,
                          .friction_static = kRubbing.friction_static,
                          .friction_dynamic = kRubbing.friction_dynamic,
                          .sliding = true});
  const Vec3 off = stage.geometry.to_scene(stage.follower.centre()) - (to - lag.pull);
  EXPECT_LT(std::hypot(off.x(), off.y()), 1e-9) << "the contact offset adds 1e-10 to the depth";
}

// The device passes along an edge, so little within the sphere's reach that the lag is a billionth of the motion.
TEST(SphereFollowerWithFriction, AMotionAlongAnEdgeThatIsOnlyJustTouchedIsLeftToSweeps) {
  constexpr double kShallowDepth = 1e-9;
  TriangleMesh fin;
  fin.vertices = {{-1.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 0.0, -1.0}};
  fin.triangles = {{0, 1, 2}};
  Stage stage(fin, kStageOffset, kRubbing);
  stage.put({-0.9, 0.0, 1.5 * kStageOffset});
  ASSERT_EQ(stage.move({-0.9, 0.0, kStageOffset - kShallowDepth}), Outcome::settled);
  const std::uint64_t events = stage.follower->events();
  double time = 0.0;
  Outcome outcome = Outcome::exhausted;
  for (int i = 0; i < 1000 && outcome == Outcome::exhausted; ++i)
    outcome =
        stage.follower->follow(stage.device, stage.geometry.to_local({0.9, 1e-3 * kShallowDepth, kStageOffset - kShallowDepth}), time);
  EXPECT_EQ(outcome, Outcome::failed);
  EXPECT_LE(stage.follower->events() - events, 300U);
}

TEST(SphereFollowerWithFriction, UsesNoHeap) {
  SCOPED_TRACE("seed 7");
  Stage stage(made::sphere(0.4, 16, 0.05), 0.03, kRubbing);
  Wanderer wanderer(7);
  stage.put({0.3, 0.5, 0.7});
  std::vector<Vec3> path;
  for (int i = 0; i < 100; ++i) path.push_back(stage.geometry.to_local(wanderer.next(0.05)));
  const AllocationGuard guard;
  for (const Vec3& to : path) stage.move_local(to);
  EXPECT_TRUE(!AllocationGuard::is_available() || guard.count() == 0U);
}

}  // namespace
}  // namespace hapton
