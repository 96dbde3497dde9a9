#include "core/tool/tool_friction.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <random>

#include "core/geometry/mesh_shapes.h"
#include "core/tool/held_tool.h"
#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

constexpr double kRubStiffness = 1000.0;  // N/m, of the coupling
constexpr double kPressDepthM = 0.002;    // m, to which the hand presses the cube into the plane
constexpr CoulombFriction kRubFriction = {0.5, 0.3};

std::unique_ptr<ToolStep> make_rough_step(const TriangleMesh& scene, const CoulombFriction& friction) {
  auto made = ToolStep::make(make_box({0.02, 0.02, 0.02}), {std::make_shared<TriangleMesh>(scene)}, {.stiffness_n_per_m = kRubStiffness},
                             {friction});
  EXPECT_TRUE(made) << made.error().what;
  return std::move(*made);
}

// A groove along x whose sides meet at a right angle.
TriangleMesh make_right_groove() {
  TriangleMesh groove;
  groove.vertices = {{-0.1, -0.1, 0.1}, {0.1, -0.1, 0.1}, {-0.1, 0.0, 0.0}, {0.1, 0.0, 0.0}, {-0.1, 0.1, 0.1}, {0.1, 0.1, 0.1}};
  groove.triangles = {{0, 1, 3}, {0, 3, 2}, {2, 3, 5}, {2, 5, 4}};
  return groove;
}

TriangleMesh make_rod_along_x() {
  TriangleMesh rod = make_cylinder(0.01, 0.04, 64);
  const auto along_x = turn_by({0.0, std::numbers::pi / 2, 0.0});
  for (Vec3& vertex : rod.vertices) vertex = along_x * vertex;
  return rod;
}

ToolInput rub_at(const Vec3& p, double turn_rad = 0.0) {
  ToolInput input;
  input.X_WD.translation() = p;
  input.X_WD.linear() = turn_by({0.0, 0.0, turn_rad}).toRotationMatrix();
  return input;
}

// Moves the tool down onto a plane until 2 N press it.
void press_down(ToolStep& step) {
  step.reset(rub_at({0.003, 0.004, 0.03}));
  for (int n = 0; n <= 220; ++n) step.step(rub_at({0.003, 0.004, 0.03 - 0.0001 * n}));
}

TEST(ToolFriction, ABoxSticksUpToTheStaticLimitAndThenLagsByTheDynamicOne) {
  const auto step = make_rough_step(make_plane_grid(0.2, 8), kRubFriction);
  press_down(*step);
  const double normal_n = kRubStiffness * kPressDepthM;
  double largest_n = 0.0;
  double x = 0.003;
  ToolOutput out;
  for (int n = 0; n < 60; ++n, x += 2e-5) {
    out = step->step(rub_at({x, 0.004, 0.008}));
    largest_n = std::max(largest_n, std::abs(out.force_n.x()));
  }
  EXPECT_NEAR(largest_n, kRubFriction.friction_static * normal_n, kRubStiffness * 2e-5 + 1e-3);
  EXPECT_NEAR(out.force_n.x(), -kRubFriction.friction_dynamic * normal_n, 2e-3);
  EXPECT_NEAR(out.force_n.z(), normal_n, 2e-3);
  EXPECT_NEAR(out.force_n.y(), 0.0, 1e-3);
  // On the way back, the box sticks until the pull has reversed.
  for (int n = 0; n < 20; ++n, x -= 2e-5) out = step->step(rub_at({x, 0.004, 0.008}));
  EXPECT_NEAR(out.force_n.x(), -kRubFriction.friction_dynamic * normal_n + kRubStiffness * 20 * 2e-5, kRubStiffness * 4e-5 + 2e-3);
}

TEST(ToolFriction, ARestingToolDoesNotCreep) {
  const auto step = make_rough_step(make_plane_grid(0.2, 8), kRubFriction);
  press_down(*step);
  for (int n = 0; n < 20; ++n) step->step(rub_at({0.003 + 2e-5 * n, 0.004, 0.008}));
  const Vec3 force_n = step->step(rub_at({0.0034, 0.004, 0.008})).force_n;
  const Vec3 at = step->proxy().placement().position;
  for (int n = 0; n < 5000; ++n) step->step(rub_at({0.0034, 0.004, 0.008}));
  EXPECT_LT((step->proxy().placement().position - at).norm(), 4.0 * ToolProxy::kContactOffset);
  EXPECT_LT((step->step(rub_at({0.0034, 0.004, 0.008})).force_n - force_n).norm(), 0.02 * force_n.norm());
}

// Each side of a right-angled groove carries the force divided by root 2, so friction along the groove is root 2 times that on a plane.
TEST(ToolFriction, AGrooveHoldsByItsSides) {
  auto made = ToolStep::make(make_rod_along_x(), {std::make_shared<TriangleMesh>(make_right_groove())},
                             {.stiffness_n_per_m = kRubStiffness}, {kRubFriction});
  ASSERT_TRUE(made) << made.error().what;
  ToolStep& step = **made;
  const double rest = 0.01 * std::numbers::sqrt2;
  step.reset(rub_at({0.0, 0.0, rest + 0.005}));
  for (int n = 0; n <= 70; ++n) step.step(rub_at({0.0, 0.0, rest + 0.005 - 1e-4 * n}));
  ToolOutput out;
  for (int n = 0; n < 100; ++n) out = step.step(rub_at({3e-5 * n, 0.0, rest - 0.002}));
  EXPECT_NEAR(out.force_n.z(), kRubStiffness * 0.002, 0.02);
  EXPECT_NEAR(out.force_n.x(), -kRubFriction.friction_dynamic * std::numbers::sqrt2 * out.force_n.z(), 0.02 * out.force_n.z());
}

// A box on four corners is turned about the normal. Its torque is friction times force times the distance of a corner from the axis.
TEST(ToolFriction, ABoxOnItsCornersResistsATurn) {
  const auto step = make_rough_step(make_plane_grid(0.2, 1), kRubFriction);
  step->reset(rub_at({0.0, 0.0, 0.03}));
  for (int n = 0; n <= 220; ++n) step->step(rub_at({0.0, 0.0, 0.03 - 0.0001 * n}));
  const double corner = 0.01 * std::numbers::sqrt2;
  const double limit_nm = kRubStiffness * kPressDepthM * corner;
  double largest_nm = 0.0;
  double turn = 0.0;
  // The box slides as long as the device turns, whichever of its contacts carry the force.
  for (int n = 0; n < 400; ++n, turn += 1e-3) {
    const ToolOutput out = step->step(rub_at({0.0, 0.0, 0.008}, turn));
    largest_nm = std::max(largest_nm, -out.torque_nm.z());
    ASSERT_NEAR(out.force_n.z(), kRubStiffness * kPressDepthM, 0.01) << n;
    if (n >= 140) {
      ASSERT_NEAR(-out.torque_nm.z(), kRubFriction.friction_dynamic * limit_nm, 0.15 * kRubFriction.friction_dynamic * limit_nm) << n;
    }
  }
  EXPECT_NEAR(largest_nm, kRubFriction.friction_static * limit_nm, 0.02 * limit_nm);
}

TEST(ToolFriction, WithoutFrictionNothingChangesToTheBit) {
  const auto plain = make_rough_step(make_bumpy_sphere(0.05, 0.05, 2000, 1), {});
  auto made = ToolStep::make(make_box({0.02, 0.02, 0.02}), {std::make_shared<TriangleMesh>(make_bumpy_sphere(0.05, 0.05, 2000, 1))},
                             {.stiffness_n_per_m = kRubStiffness});
  ASSERT_TRUE(made);
  for (int n = 0; n < 500; ++n) {
    const ToolInput input = rub_at({1e-5 * n, 0.0, 0.07 - 2e-5 * n});
    ASSERT_EQ(plain->step(input).force_n, (*made)->step(input).force_n);
  }
}

TEST(ToolFriction, TheFastTaskFeelsWhatTheWholeStepFeels) {
  HeldTool held(make_rough_step(make_plane_grid(0.2, 8), kRubFriction));
  const auto whole = make_rough_step(make_plane_grid(0.2, 8), kRubFriction);
  whole->reset(rub_at({0.003, 0.004, 0.03}));
  double largest_n = 0.0;
  double largest_difference_n = 0.0;
  for (int n = 0; n < 1500; ++n) {
    const double t = 1e-3 * n;
    const ToolInput input = rub_at({0.003 + 0.01 * std::sin(6.0 * t), 0.004 + 0.008 * std::sin(4.0 * t), std::max(0.03 - 0.1 * t, 0.008)});
    const ToolOutput expected = whole->step(input);
    std::uint64_t allocation_count = 0;
    const AllocationGuard guard;
    const ToolOutput felt = held.step(input, n * 1'000'000);
    allocation_count = AllocationGuard::is_available() ? guard.count() : 0;
    ASSERT_EQ(allocation_count, 0U);
    held.follow();
    if (n < 300) continue;
    largest_n = std::max(largest_n, expected.force_n.norm());
    largest_difference_n = std::max(largest_difference_n, (felt.force_n - expected.force_n).norm());
  }
  EXPECT_GT(largest_n, 2.0);
  EXPECT_LT(largest_difference_n, 0.03 * largest_n);
}

// A cube is pressed onto an edge or a corner; the fast task computes the force. The force stays the same while the hand holds still. While
// the cube slides, friction is the dynamic coefficient times the normal force, whichever way the cube is tilted.
TEST(ToolFriction, ATiltedToolSticksAndSlidesAsAFlatOneDoes) {
  const Vec3 tilts[] = {{0.0, 0.35, 0.0}, {0.0, std::numbers::pi / 4, 0.0}, {1.2, 0.0, 0.0}, {0.5, 0.6, 0.2}};
  for (const double coefficient : {0.3, 0.5, 0.8}) {
    for (const Vec3& tilt : tilts) {
      for (const Vec3& direction : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(-0.6, 0.8, 0)}) {
        HeldTool held(make_rough_step(make_plane_grid(0.2, 8), {coefficient, 0.8 * coefficient}));
        std::int64_t n = 0;
        const auto felt_at = [&](const Vec3& p) {
          ToolInput input;
          input.X_WD.translation() = p;
          input.X_WD.linear() = turn_by(tilt).toRotationMatrix();
          const ToolOutput out = held.step(input, n++ * 1'000'000);
          if (n % 3 == 0) held.follow();
          return out;
        };
        double lowest = 0.0;  // z of the cube's lowest corner, relative to its centre
        for (const double x : {-0.01, 0.01})
          for (const double y : {-0.01, 0.01})
            for (const double z : {-0.01, 0.01}) lowest = std::min(lowest, (turn_by(tilt) * Vec3(x, y, z)).z());
        Vec3 p(0.003, 0.004, -lowest + 0.001);
        for (int i = 0; i < 300; ++i) felt_at(p -= Vec3(0, 0, 1e-5));
        for (int i = 0; i < 100; ++i) felt_at(p);
        const Vec3 still_n = felt_at(p).force_n;
        for (int i = 0; i < 300; ++i) ASSERT_LT((felt_at(p).force_n - still_n).norm(), 2e-3 * still_n.norm()) << coefficient;
        ASSERT_GT(still_n.z(), 0.5);
        ToolOutput out;
        for (int i = 0; i < 400; ++i) out = felt_at(p += 3e-5 * direction);
        EXPECT_NEAR(-out.force_n.dot(direction) / out.force_n.z(), 0.8 * coefficient, 0.01) << coefficient << ", " << tilt.transpose();
        const Vec3 end_n = out.force_n;
        for (int i = 0; i < 200; ++i) ASSERT_LT((felt_at(p).force_n - end_n).norm(), 2e-3 * end_n.norm()) << coefficient;
        for (int i = 0; i < 300; ++i) ASSERT_GT(felt_at(p += Vec3(0, 0, 3e-5)).force_n.z(), -1e-9) << "pulled down";
      }
    }
  }
}

// Random motion with a cube on a plane and a rod in a groove: no force changes by more than the motion and a break-away explain, and the
// hand gains no energy.
TEST(ToolFriction, ARandomHandFeelsNoKick) {
  struct Rubbing {
    TriangleMesh tool;
    TriangleMesh scene;
    double height_m;
  };
  const Rubbing rubbing_bodies[] = {{make_box({0.02, 0.02, 0.02}), make_plane_grid(0.2, 8), 0.012},
                                    {make_rod_along_x(), make_right_groove(), 0.0135}};
  for (const Rubbing& bodies : rubbing_bodies) {
    for (const std::uint64_t seed : {1, 2, 3}) {
      auto made =
          ToolStep::make(bodies.tool, {std::make_shared<TriangleMesh>(bodies.scene)}, {.stiffness_n_per_m = kRubStiffness}, {{0.8, 0.64}});
      ASSERT_TRUE(made);
      HeldTool held(std::move(*made));
      std::mt19937_64 random(seed);
      std::normal_distribution<double> push;
      const Vec3 home(0, 0, bodies.height_m);
      Vec3 p = home + Vec3(0, 0, 0.01), v = Vec3::Zero(), turn = Vec3::Zero(), spin = Vec3::Zero(), before_n = Vec3::Zero();
      double energy_j = 0.0, largest_n = 0.0;
      for (int i = 0; i < 6000; ++i) {
        v = 0.98 * v + 3e-6 * Vec3(push(random), push(random), push(random)) - 2e-5 * (p - home);
        spin = 0.98 * spin + 2e-4 * Vec3(push(random), push(random), push(random)) - 2e-5 * turn;
        p += v;
        turn += spin;
        ToolInput input;
        input.X_WD.translation() = p;
        input.X_WD.linear() = turn_by(turn).toRotationMatrix();
        const ToolOutput out = held.step(input, i * std::int64_t{1'000'000});
        if (i % 2 == 0) held.follow();
        // The motion stretches the coupling, and a break-away drops the friction by 0.8 - 0.64 of the normal force.
        const double explained_n = kRubStiffness * (v.norm() + 0.02 * spin.norm()) + 0.16 * before_n.norm();
        ASSERT_LT((out.force_n - before_n).norm(), explained_n + 0.5) << "seed " << seed << ", step " << i;
        energy_j += 0.5 * (out.force_n + before_n).dot(v) + out.torque_nm.dot(spin);
        before_n = out.force_n;
        largest_n = std::max(largest_n, before_n.norm());
      }
      EXPECT_LT(energy_j, 0.0) << "seed " << seed;
      EXPECT_GT(largest_n, 3.0);
    }
  }
}

// If friction exceeds the slope from the edge to the cube's centre (1), a pull tips the cube, and it stays tipped while the hand is still.
// The cube turns back gradually when the hand lifts it, although its contacts were found at the tipped pose, far from the device.
TEST(ToolFriction, ACubeThatTipsComesBackGradually) {
  HeldTool held(make_rough_step(make_plane_grid(0.2, 8), {1.2, 0.96}));
  std::int64_t n = 0;
  const auto felt_at = [&](const Vec3& p) {
    const ToolOutput out = held.step(rub_at(p), n++ * 1'000'000);
    held.follow();
    return out;
  };
  const auto turn_of = [](const ToolOutput& out) { return Eigen::AngleAxisd(out.X_WP.linear()).angle(); };
  Vec3 p(0.003, 0.004, 0.014);
  for (int i = 0; i < 300; ++i) felt_at(p -= Vec3(0, 0, 2e-5));
  ToolOutput out;
  for (int i = 0; i < 600; ++i) out = felt_at(p += Vec3(3e-5, 0, 0));
  EXPECT_GT(turn_of(out), 0.5) << "it tips";
  double before = turn_of(out);
  for (int i = 0; i < 1000; ++i) {
    out = felt_at(i < 300 ? p : Vec3(p += Vec3(0, 0, 3e-5)));
    ASSERT_LT(std::abs(turn_of(out) - before), 0.11) << i;
    before = turn_of(out);
  }
  EXPECT_EQ(before, 0.0);
  EXPECT_EQ(out.force_n, Vec3(Vec3::Zero()));
}

// Whatever error the iteration leaves, the tool does not penetrate a known contact.
TEST(ToolFriction, NoKnownContactIsViolated) {
  std::mt19937_64 random(20261129);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int trial = 0; trial < 1000; ++trial) {
    LocalContacts local;
    local.is_blocked = false;
    local.tolerance = 1e-9;
    local.stiffness << Vec3::Ones(), Vec3::Constant(0.25);
    local.plain_inverse_root << Vec3::Ones(), Vec3::Constant(2.0);
    local.inverse_root = local.plain_inverse_root.asDiagonal();
    for (int i = 0; i < 6; ++i) {
      const Vec3 normal = Vec3(0.6 * uniform(random), 0.6 * uniform(random), 1.0).normalized();
      const Vec3 arm(0.3 * uniform(random), 0.3 * uniform(random), -0.2 + 0.1 * uniform(random));
      MotionBound bound;
      bound.row << normal, arm.cross(normal);
      local.add(bound, {.arm = arm, .friction = {1.2, 1.2}});
    }
    ToolFriction friction;
    friction.reset({});
    const Placement device{0.01 * Vec3(uniform(random), uniform(random), -3.0),
                           turn_by(0.02 * Vec3(uniform(random), uniform(random), uniform(random)))};
    const Placement at = friction.step(local, device).at;
    Vec6 motion;
    motion << at.position, turn_between(Quat::Identity(), at.orientation);
    for (std::size_t i = 0; i < local.count; ++i) ASSERT_GE(local.bounds[i].row.dot(motion), -1e-8) << trial;
  }
}

TEST(ToolFriction, ImpossibleFrictionIsRejected) {
  for (const CoulombFriction impossible : {CoulombFriction{0.1, 0.2}, {-0.1, -0.1}, {std::nan(""), 0.0}, {1.0, std::nan("")}}) {
    const auto made =
        ToolStep::make(make_box({0.02, 0.02, 0.02}), {std::make_shared<TriangleMesh>(make_plane_grid(0.2, 2))}, {}, {impossible});
    EXPECT_FALSE(made);
  }
}

}  // namespace
}  // namespace hapton
