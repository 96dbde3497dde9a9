#include "core/force/sphere/sphere_follower.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "tests/core/force/sphere/sphere_stage.h"
#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

TEST(SphereFollower, OverAPlaneItStaysAboveTheDevice) {
  Stage stage(made::sheet(0.5, 0.0, 8), kStageOffset);
  stage.put({0.03, 0.02, 0.4});
  ASSERT_EQ(stage.move({0.03, 0.02, -0.05}), Outcome::settled);
  expect_centre(stage, {0.03, 0.02, kStageOffset});
  // Over the sheet's inner edges and vertices, which all lie in one plane.
  ASSERT_EQ(stage.move({0.31, -0.27, -0.2}), Outcome::settled);
  expect_centre(stage, {0.31, -0.27, kStageOffset});
  ASSERT_EQ(stage.follower->contacts().size(), 1U);
  EXPECT_NEAR(stage.follower->contacts()[0].multiplier * stage.unit(), 0.2 + kStageOffset, kCentreTolerance);
  ASSERT_EQ(stage.move({0.125, 0.125, 0.03}), Outcome::settled);
  expect_centre(stage, {0.125, 0.125, kStageOffset});
  EXPECT_FALSE(stage.follower->is_free());
  // Off the sheet again, with the device.
  ASSERT_EQ(stage.move({0.2, 0.125, 0.13}), Outcome::settled);
  EXPECT_TRUE(stage.follower->is_free());
  EXPECT_EQ(stage.follower->centre(), stage.device);
  EXPECT_TRUE(stage.follower->contacts().empty());
}

// A position round the box's edge, which runs along y at x = z = 0.5.
Vec3 round_the_edge(double distance, double angle, double y) {
  return {0.5 + distance * std::sin(angle), y, 0.5 + distance * std::cos(angle)};
}

TEST(SphereFollower, RollsRoundAConvexEdge) {
  Stage stage(made::box(Vec3::Constant(-0.5), Vec3::Constant(0.5)), kStageOffset);
  stage.put({0.3, 0.0, 0.8});
  ASSERT_EQ(stage.move({0.4, 0.0, 0.53}), Outcome::settled);
  expect_centre(stage, {0.4, 0.0, 0.5 + kStageOffset});
  constexpr int kSteps = 50;
  for (int i = 0; i <= kSteps; ++i) {
    const double angle = 0.5 * std::numbers::pi * (i + 0.5) / (kSteps + 1);
    const double y = 0.2 * i / kSteps;
    ASSERT_EQ(stage.move(round_the_edge(0.03, angle, y)), Outcome::settled);
    expect_centre(stage, round_the_edge(kStageOffset, angle, y));
    ASSERT_EQ(stage.follower->contacts().size(), 1U);
    EXPECT_EQ(stage.follower->contacts()[0].part, Feature::edge);
  }
  ASSERT_EQ(stage.move({0.45, 0.1, 0.3}), Outcome::settled);
  expect_centre(stage, {0.5 + kStageOffset, 0.1, 0.3});
}

TEST(SphereFollower, GoesRoundAnEdgeInOneStep) {
  Stage stage(made::box(Vec3::Constant(-0.5), Vec3::Constant(0.5)), kStageOffset);
  stage.put({0.3, 0.0, 0.8});
  ASSERT_EQ(stage.move({0.4, 0.1, 0.55}), Outcome::settled);
  ASSERT_EQ(stage.move({0.55, 0.1, 0.4}), Outcome::settled);
  expect_centre(stage, {0.5 + kStageOffset, 0.1, 0.4});
}

TEST(SphereFollower, RollsOverAVertex) {
  Stage stage(made::box(Vec3::Constant(-0.5), Vec3::Constant(0.5)), kStageOffset);
  const Vec3 corner = Vec3::Constant(0.5);
  stage.put(corner + Vec3::Constant(0.3));
  ASSERT_EQ(stage.move(corner + 0.04 * Vec3(1, 1, 1).normalized()), Outcome::settled);
  for (int i = 0; i < 60; ++i) {
    const double turn = 0.7 * std::sin(0.3 * i);
    const Vec3 out = Vec3(1.0 + turn, 1.0 + 0.6 * std::cos(0.7 * i), 1.0 - turn).normalized();
    ASSERT_EQ(stage.move(corner + (0.04 + 0.02 * std::sin(1.3 * i)) * out), Outcome::settled);
    expect_centre(stage, corner + kStageOffset * out);
    ASSERT_EQ(stage.follower->contacts().size(), 1U);
    EXPECT_EQ(stage.follower->contacts()[0].part, Feature::vertex);
  }
  ASSERT_EQ(stage.move(corner + Vec3(0.2, 0.2, 0.2)), Outcome::settled);
  EXPECT_TRUE(stage.follower->is_free());
}

// A floor z = 0 and a wall that rises at x = 0, `angle` between them, both with the same side towards the room.
TriangleMesh crease(double angle) {
  TriangleMesh mesh;
  for (const double y : {-1.0, 1.0}) {
    mesh.vertices.insert(mesh.vertices.end(), {{1.0, y, 0.0}, {0.0, y, 0.0}, {std::cos(angle), y, std::sin(angle)}});
  }
  mesh.triangles = {{0, 4, 1}, {0, 3, 4}, {1, 5, 2}, {1, 4, 5}};
  return mesh;
}

TEST(SphereFollower, InACreaseItIsHeldByBothFaces) {
  for (const double angle : {0.5 * std::numbers::pi, 1.2, 2.3}) {
    Stage stage(crease(angle), kStageOffset);
    const double x = kStageOffset / std::tan(0.5 * angle);
    const Vec3 wall_normal(std::sin(angle), 0.0, -std::cos(angle));
    stage.put({x + 0.01, 0.3, kStageOffset + 0.005});
    // A device whose pull both faces must hold.
    const Vec3 device = Vec3(x, 0.25, kStageOffset) - 0.2 * Vec3::UnitZ() - 0.1 * wall_normal;
    ASSERT_EQ(stage.move(device), Outcome::settled);
    expect_centre(stage, {x, 0.25, kStageOffset});
    ASSERT_EQ(stage.follower->contacts().size(), 2U);
    for (const OffsetContact& contact : stage.follower->contacts()) {
      const bool is_floor = std::fabs(contact.normal.z()) > 1.0 - 1e-12;
      EXPECT_NEAR(contact.multiplier * stage.unit(), is_floor ? 0.2 : 0.1, kCentreTolerance);
    }
    ASSERT_EQ(stage.move(device + Vec3(0.0, -0.6, 0.0)), Outcome::settled);
    expect_centre(stage, {x, -0.35, kStageOffset});
    // Off the wall, over the floor.
    ASSERT_EQ(stage.move({x + 0.3, -0.2, -0.1}), Outcome::settled);
    expect_centre(stage, {x + 0.3, -0.2, kStageOffset});
    EXPECT_EQ(stage.follower->contacts().size(), 1U);
  }
}

TEST(SphereFollower, InACornerOfThreeWallsItStaysUntilAMultiplierIsZero) {
  TriangleMesh room = made::box(Vec3::Zero(), Vec3::Ones());
  for (Triangle& triangle : room.triangles) std::swap(triangle[1], triangle[2]);
  Stage stage(room, kStageOffset, {.two_sided = false});
  stage.put({0.4, 0.5, 0.6});
  ASSERT_EQ(stage.move({-0.1, -0.2, -0.3}), Outcome::settled);
  expect_centre(stage, Vec3::Constant(kStageOffset));
  ASSERT_EQ(stage.follower->contacts().size(), 3U);
  for (const OffsetContact& contact : stage.follower->contacts()) {
    int axis = 0;
    contact.normal.maxCoeff(&axis);
    EXPECT_NEAR(contact.multiplier * stage.unit(), kStageOffset + 0.1 * (axis + 1), kCentreTolerance);
  }
  ASSERT_EQ(stage.move({0.05, -0.1, 0.09}), Outcome::settled);
  expect_centre(stage, Vec3::Constant(kStageOffset));
  ASSERT_EQ(stage.move({0.05, 0.3, 0.09}), Outcome::settled);
  expect_centre(stage, {kStageOffset, 0.3, kStageOffset});
  ASSERT_EQ(stage.move({0.3, 0.3, -0.1}), Outcome::settled);
  expect_centre(stage, {0.3, 0.3, kStageOffset});
  // Into the opposite corner in one step.
  ASSERT_EQ(stage.move({1.1, 1.2, 1.3}), Outcome::settled);
  expect_centre(stage, Vec3::Constant(1.0 - kStageOffset));
}

// On the axis all positions round the edge are equally near: the centre keeps its angle, and turns to the device once that leaves the axis.
TEST(SphereFollower, OnTheAxisOfAnEdgeItKeepsItsAngle) {
  // Within 2^-39 of the axis the device counts as on it; so near, rounding turns its direction by up to this angle.
  constexpr double kMaxTurn = 0x1p-53 / 0x1p-39;
  Stage stage(made::box(Vec3::Constant(-0.5), Vec3::Constant(0.5)), kStageOffset);
  stage.put(round_the_edge(0.3, 0.7, 0.0));
  ASSERT_EQ(stage.move(round_the_edge(0.05, 0.7, 0.0)), Outcome::settled);
  expect_centre(stage, round_the_edge(kStageOffset, 0.7, 0.0));
  ASSERT_EQ(stage.move(round_the_edge(0.0, 0.0, 0.0)), Outcome::settled);
  const Vec3 held_centre = stage.centre();
  EXPECT_LT((held_centre - round_the_edge(kStageOffset, 0.7, 0.0)).norm(), kMaxTurn * kStageOffset);
  ASSERT_EQ(stage.move(round_the_edge(0.0, 0.0, 0.3)), Outcome::settled);
  expect_centre(stage, held_centre + Vec3(0.0, 0.3, 0.0));
  ASSERT_EQ(stage.move(round_the_edge(0.02, 0.2, 0.3)), Outcome::settled);
  expect_centre(stage, round_the_edge(kStageOffset, 0.2, 0.3));
}

TEST(SphereFollower, AnEdgeIsLeftByAPullStraightThroughIt) {
  Stage stage(made::box(Vec3::Constant(-0.5), Vec3::Constant(0.5)), kStageOffset);
  stage.put({0.45, 0.0, 0.8});
  ASSERT_EQ(stage.move({0.45, 0.0, 0.3}), Outcome::settled);
  expect_centre(stage, {0.45, 0.0, 0.5 + kStageOffset});
  // Past the edge and below: down the side at once.
  ASSERT_EQ(stage.move({0.51, 0.0, 0.3}), Outcome::settled);
  expect_centre(stage, {0.5 + kStageOffset, 0.0, 0.3});
}

TEST(SphereFollower, AnOpenSheetHoldsFromBothSides) {
  for (const double side : {1.0, -1.0}) {
    Stage stage(made::sheet(0.5, 0.0, 5), kStageOffset);
    stage.put({0.1, 0.2, 0.3 * side});
    ASSERT_EQ(stage.move({0.1, 0.2, -0.1 * side}), Outcome::settled);
    expect_centre(stage, {0.1, 0.2, kStageOffset * side});
    // Round its boundary and under it.
    ASSERT_EQ(stage.move({0.52, 0.2, -0.02 * side}), Outcome::settled);
    const Vec3 out = Vec3(0.02, 0.0, -0.02 * side).normalized();
    expect_centre(stage, Vec3(0.5, 0.2, 0.0) + kStageOffset * out);
    ASSERT_EQ(stage.move({0.3, 0.2, 0.1 * side}), Outcome::settled);
    expect_centre(stage, {0.3, 0.2, -kStageOffset * side});
  }
}

TEST(SphereFollower, AOneSidedSheetLetsThroughFromBehind) {
  Stage stage(made::sheet(0.5, 0.0, 5), kStageOffset, {.two_sided = false});
  stage.put({0.1, 0.2, 0.3});
  ASSERT_EQ(stage.move({0.1, 0.2, -0.1}), Outcome::settled);
  expect_centre(stage, {0.1, 0.2, kStageOffset});
  stage.put({0.1, 0.2, -0.3});
  ASSERT_EQ(stage.move({0.1, 0.2, -0.05}), Outcome::settled);
  EXPECT_TRUE(stage.follower->is_free());
  ASSERT_EQ(stage.move({0.1, 0.2, 0.3}), Outcome::settled);
  EXPECT_TRUE(stage.follower->is_free());
  EXPECT_EQ(stage.follower->centre(), stage.device);
}

TEST(SphereFollower, TakesOverACentreInContactAndNoneThatIsTooNear) {
  Stage stage(made::sheet(0.5, 0.0, 5), kStageOffset);
  const double short_by = 0x1p-36;
  const Vec3 place = stage.geometry.to_local({0.1, 0.2, kStageOffset});
  ASSERT_TRUE(stage.follower->start(place - 0.5 * short_by * Vec3::UnitZ(), false, short_by));
  EXPECT_GE(stage.follower->work(), 2) << "it gathers and lifts";
  EXPECT_TRUE(stage.follower->is_tracking());
  stage.device = place;
  ASSERT_EQ(stage.move({0.12, 0.2, -0.1}), Outcome::settled);
  expect_centre(stage, {0.12, 0.2, kStageOffset});
  EXPECT_FALSE(stage.follower->start(place - 3.0 * short_by * Vec3::UnitZ(), false, short_by));
  EXPECT_FALSE(stage.follower->is_tracking());
}

// At the end of a narrow crease. To leave one of its walls alone would lead into the other one.
TEST(SphereFollower, TakesOverACentreBetweenWallsThatItTouches) {
  constexpr double kAngle = 0.3;
  const Vec3 floor_normal = Vec3::UnitZ();
  const Vec3 wall_normal(std::sin(kAngle), 0.0, -std::cos(kAngle));
  TriangleMesh mesh = crease(kAngle);
  mesh.vertices.insert(mesh.vertices.end(), {{-1.0, 0.0, -1.0}, {3.0, 0.0, -1.0}, {1.0, 0.0, 3.0}});
  for (const std::size_t end_wall : {0U, 2U, 4U}) {
    TriangleMesh ordered = mesh;
    ordered.triangles.insert(ordered.triangles.begin() + static_cast<std::ptrdiff_t>(end_wall), {6, 8, 7});
    for (const bool is_in_floor : {false, true}) {
      Stage stage(ordered, kStageOffset);
      const Vec3& other = is_in_floor ? wall_normal : floor_normal;
      const Vec3& out = is_in_floor ? floor_normal : wall_normal;
      const double short_by = 0x1p-36;
      const Vec3 place = stage.geometry.to_local({kStageOffset / std::tan(0.5 * kAngle), kStageOffset, kStageOffset});
      const Vec3 along_other = (out - other.dot(out) * other).normalized();
      ASSERT_TRUE(stage.follower->start(place - 0.5 * short_by * along_other, false, short_by)) << end_wall;
      EXPECT_GE(stage.distance_to_nearest(), stage.offset - kSlop);
      EXPECT_LT((stage.follower->centre() - place).norm(), kCentreTolerance);
    }
  }
}

// ---------------------------------------------------------------------------------------------------------------------

class OverBumps : public testing::TestWithParam<std::uint64_t> {};

TEST_P(OverBumps, OneStepIsTheSameMotionInParts) {
  constexpr double kStiffness = 1000.0;  // N/m
  constexpr int kSteps = 120;
  RecordProperty("seed", std::to_string(GetParam()));
  Stage stage(made::sphere(0.4, 16, 0.05), 0.03);
  Wanderer wanderer(GetParam());
  stage.put({0.3, 0.5, 0.7});
  int settled_steps = 0;
  int contact_steps = 0;
  int several_contact_steps = 0;
  for (int i = 0; i < kSteps; ++i) {
    const Vec3 from = stage.device;
    const Vec3 to = stage.geometry.to_local(wanderer.next(i % 4 == 0 ? 0.2 : 0.05));
    SphereFollower in_parts(*stage.follower);
    const bool is_settled = stage.move_local(to) == Outcome::settled;
    ASSERT_GE(stage.distance_to_nearest(), stage.offset - kSlop) << "step " << i;
    const bool parts_settled = follow_in_parts(in_parts, from, to);
    if (is_settled && parts_settled) {
      ++settled_steps;
      ASSERT_LT(stage.imbalance(), kCentreTolerance);
      const double error = kStiffness * stage.unit() * (stage.follower->centre() - in_parts.centre()).norm();
      const double force = kStiffness * stage.unit() * (stage.follower->centre() - to).norm();
      ASSERT_LE(error, 1e-8 * std::max(1.0, force)) << "N, step " << i;
      contact_steps += stage.follower->is_free() ? 0 : 1;
      several_contact_steps += stage.follower->contacts().size() > 1 ? 1 : 0;
    } else {
      stage.follower->start_free(stage.geometry.to_local(Vec3(0.6 * to.normalized())));
      stage.device = stage.follower->centre();
    }
  }
  RecordProperty("settled", settled_steps);
  EXPECT_GE(settled_steps, kSteps - kSteps / 20);
  EXPECT_GT(contact_steps, kSteps / 2);
  EXPECT_GT(several_contact_steps, 5);
}

INSTANTIATE_TEST_SUITE_P(Seeds, OverBumps, testing::Values(1, 2, 3, 4, 5, 6));

// With each of these seeds there is a step in which the sphere cannot go on: what was tried there must not be left as the centre.
TEST(SphereFollower, TheCentreKeepsItsDistanceWhateverTheOutcome) {
  int contact_steps = 0;
  for (const std::uint64_t seed : {107U, 149U}) {
    RecordProperty("seed", std::to_string(seed));
    Stage stage(made::sphere(0.4, 16, 0.05), 0.03);
    Wanderer wanderer(seed);
    stage.put({0.3, 0.5, 0.7});
    for (int i = 0; i < 210; ++i) {
      const Vec3 to = stage.geometry.to_local(wanderer.next(i % 4 == 0 ? 0.2 : 0.05));
      const Outcome outcome = stage.move_local(to);
      ASSERT_GE(stage.distance_to_nearest(), stage.offset - kSlop) << "seed " << seed << " step " << i;
      contact_steps += stage.follower->is_free() ? 0 : 1;
      if (outcome != Outcome::failed) continue;
      stage.follower->start_free(stage.geometry.to_local(Vec3(0.6 * to.normalized())));
      stage.device = stage.follower->centre();
    }
  }
  EXPECT_GT(contact_steps, 100);
}

// A fine and bumpy sheet beside a large plain one: a path crosses few edges on the average of the object, but hundreds on the fine sheet.
TriangleMesh fine_patch() {
  TriangleMesh mesh = made::sheet(0.05, 0.0, 200);
  for (Vec3& p : mesh.vertices) p.z() = 0.0004 * std::sin(2500.0 * p.x()) * std::sin(1900.0 * p.y() + 1.0);
  const TriangleMesh plain = made::sheet(1.0, -0.5, 2);
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), plain.vertices.begin(), plain.vertices.end());
  for (const Triangle& t : plain.triangles) mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  return mesh;
}

TEST(SphereFollower, TheWorkOfAHostileMotionIsBoundedAndItGoesOnUntilItHasSettled) {
  constexpr std::uint64_t kOneEvent = 512;  // units, on this patch
  Stage stage(fine_patch(), 0.002);
  stage.put({-0.0442, 0.0027, 0.01});
  ASSERT_EQ(stage.move({-0.0443, 0.0029, -0.003}), Outcome::settled);
  int exhausted = 0;
  const auto follow = [&](const Vec3& to) {
    const std::uint64_t before = stage.follower->queried();
    const AllocationGuard guard;
    const Outcome outcome = stage.move_local(to);
    EXPECT_TRUE(!AllocationGuard::is_available() || guard.count() == 0U);
    // An event that has begun is completed, even if the work limit is passed.
    EXPECT_LE(stage.follower->queried() - before, static_cast<std::uint64_t>(StepWork::kMax) + kOneEvent);
    EXPECT_GE(stage.distance_to_nearest(), stage.offset - kSlop);
    exhausted += outcome == Outcome::exhausted ? 1 : 0;
    return outcome;
  };
  for (const Vec3& target : {Vec3(0.04, 0.0031, -0.004), Vec3(-0.03, -0.041, -0.003), Vec3(0.03, 0.04, -0.003)}) {
    const Vec3 to = stage.geometry.to_local(target);
    Outcome outcome = follow(to);
    EXPECT_EQ(outcome, Outcome::exhausted);
    for (int i = 0; i < 1000 && outcome == Outcome::exhausted; ++i) outcome = follow(to);
    ASSERT_EQ(outcome, Outcome::settled);
    EXPECT_LT(stage.imbalance(), kCentreTolerance);
    EXPECT_FALSE(stage.follower->is_free());
    EXPECT_LT((stage.centre() - target).norm(), 0.01) << "it was left behind";
  }
  EXPECT_GT(exhausted, 3);
}

// Far beyond the scene, only the direction of the device, seen from the centre, counts.
TEST(SphereFollower, ADeviceFarOutIsFollowed) {
  Stage stage(made::sheet(0.5, 0.0, 5), kStageOffset);
  stage.put({0.1, 0.2, 0.3});
  ASSERT_EQ(stage.move({0.1, 0.2, -0.1}), Outcome::settled);
  const double height = stage.follower->centre().z();
  for (const double far : {5.0, 40.0, 1e4, 1e9}) {
    ASSERT_EQ(stage.move_local(Vec3(0.0, 0.0, -far)), Outcome::settled) << far;
    EXPECT_LE((stage.follower->centre() - Vec3(0.0, 0.0, height)).norm(), far < 32.0 ? 1e-13 : 1e-9) << far;
  }
  ASSERT_EQ(stage.move_local(Vec3(0.05, 0.0, -1e9)), Outcome::settled);
  ASSERT_EQ(stage.move_local(Vec3(0.05, 0.0, -0.2)), Outcome::settled);
  EXPECT_LE((stage.follower->centre() - Vec3(0.05, 0.0, height)).norm(), 1e-13);
  ASSERT_EQ(stage.move_local(Vec3(0.05, 0.0, 2e6)), Outcome::settled);
  EXPECT_TRUE(stage.follower->is_free());
  ASSERT_EQ(stage.move_local(Vec3(0.05, 0.0, -2e6)), Outcome::settled);
  EXPECT_FALSE(stage.follower->is_free()) << "its way leads through the sheet";
}

// Each call replaces the far device by another, nearer target, so the distance to the target does not show the progress between calls.
TEST(SphereFollower, ADeviceFarOutIsFollowedHoweverLittleWorkACallHas) {
  constexpr int kWorkPerCall = 40;  // units
  const std::uint64_t seed = 29;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  int exhausted_calls = 0;
  for (int i = 0; i < 60; ++i) {
    Stage stage(made::sphere(0.4, 24, 0.05), 0.005);
    const Vec3 side = Vec3(normal(random), normal(random), normal(random)).normalized();
    stage.put(0.6 * side);
    ASSERT_EQ(stage.finish(stage.geometry.to_local(0.4 * side)), Outcome::settled);
    const Vec3 far = 1000.0 * Vec3(normal(random), normal(random), normal(random)).normalized();
    Outcome outcome = Outcome::exhausted;
    for (int call = 0; call < 2000 && outcome == Outcome::exhausted; ++call) {
      double time = 0.0;
      outcome = stage.follower->follow(call == 0 ? stage.device : far, far, time, kWorkPerCall);
      exhausted_calls += outcome == Outcome::exhausted ? 1 : 0;
    }
    EXPECT_EQ(outcome, Outcome::settled) << i;
  }
  EXPECT_GT(exhausted_calls, 60);
}

TEST(SphereFollower, ADeviceThatIsNotFiniteFailsAndChangesNothing) {
  Stage stage(made::sheet(0.5, 0.0, 5), kStageOffset);
  stage.put({0.1, 0.2, 0.3});
  ASSERT_EQ(stage.move({0.1, 0.2, -0.1}), Outcome::settled);
  const Vec3 centre = stage.follower->centre();
  EXPECT_EQ(stage.move_local(Vec3::Constant(std::numeric_limits<double>::quiet_NaN())), Outcome::failed);
  EXPECT_EQ(stage.follower->centre(), centre);
}

}  // namespace
}  // namespace hapton
