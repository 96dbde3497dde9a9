#include "core/tool/contact_damping.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <random>

#include "core/geometry/mesh_shapes.h"
#include "core/tool/held_tool.h"
#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

using DragContact = ContactDamping::Contact;

constexpr double kCubeStiffness = 1000.0;  // N/m, of the coupling
constexpr double kSamplePeriodS = 1e-3;
constexpr DampingCoefficients kHoney = {.normal_ns_per_m = 3.0, .along_ns_per_m = 5.0};

Placement drag_placement(const Vec3& p, const Vec3& turn = Vec3::Zero()) { return {p, turn_by(turn)}; }

// Number of samples after which less than 1e-14 of an earlier drag is left.
constexpr int kSettlingSamples = 200;

// The drag after kSettlingSamples samples of a steady motion with these contacts; the local unit is 1 m.
ContactDamping::Wrench move_steadily(ContactDamping& drag, const std::vector<DragContact>& contacts, const Vec3& velocity,
                                     const Vec3& turn_rate = Vec3::Zero()) {
  ContactDamping::Wrench wrench;
  for (int n = 0; n < kSettlingSamples; ++n) {
    drag.move(drag_placement(n * kSamplePeriodS * velocity, n * kSamplePeriodS * turn_rate), {}, kSamplePeriodS);
    wrench = drag.step(contacts, true);
  }
  return wrench;
}

TEST(ContactDamping, OneContactIsTheDamperOfItsMaterial) {
  ContactDamping drag({{kHoney}}, 1.0, 1.0);
  const ContactDamping::Wrench wrench =
      move_steadily(drag, {{.arm = {0.1, 0.2, -0.3}, .normal = Vec3::UnitZ(), .force_n = 2.0}}, {0.02, 0.01, -0.04});
  const Vec3 expected(-5.0 * 0.02, -5.0 * 0.01, 3.0 * 0.04);
  EXPECT_LT((wrench.force_n - expected).norm(), 1e-12);
  EXPECT_LT((wrench.torque_nm - Vec3(0.1, 0.2, -0.3).cross(expected)).norm(), 1e-12);
}

TEST(ContactDamping, ManyContactsOfAFaceShareItsDamping) {
  for (const int count : {1, 2, 3, 6}) {
    ContactDamping drag({{kHoney}}, 1.0, 1.0);
    std::vector<DragContact> contacts;
    for (int k = 0; k < count; ++k) {
      contacts.push_back({.arm = {0.01 * k, 0.02 * (k % 2), 0.0}, .normal = Vec3::UnitZ(), .force_n = 2.0 / count});
    }
    const ContactDamping::Wrench wrench = move_steadily(drag, contacts, {0.05, 0.0, 0.01});
    EXPECT_NEAR(wrench.force_n.x(), -5.0 * 0.05, 1e-12) << count;
    EXPECT_NEAR(wrench.force_n.z(), -3.0 * 0.01, 1e-12) << count;
  }
}

// The sum of both materials would be 12 Ns/m along x.
TEST(ContactDamping, SurfacesAcrossEachOtherHaveTheLargestOfTheirMaterials) {
  ContactDamping drag({{{.along_ns_per_m = 5.0}, {.along_ns_per_m = 7.0}}}, 1.0, 1.0);
  const std::vector<DragContact> contacts = {{.normal = Vec3::UnitZ(), .force_n = 4.0},
                                             {.normal = Vec3::UnitY(), .force_n = 1.0, .object = 1}};
  EXPECT_NEAR(move_steadily(drag, contacts, {0.03, 0.0, 0.0}).force_n.x(), -7.0 * 0.03, 1e-12);
  EXPECT_NEAR(move_steadily(drag, contacts, {0.0, 0.03, 0.0}).force_n.y(), -5.0 * 7.0 / 12.0 * 0.03, 1e-12);
}

// Contacts of a peg that is held askew in a hole: two opposite ones, four around it or six on all sides, on one part or on several.
TEST(ContactDamping, NoDirectionIsDampedMoreThanByTheLargestMaterial) {
  const unsigned seed = 230;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const auto vector = [&] { return Vec3(uniform(random), uniform(random), uniform(random)); };
  const std::vector<Vec3> sides = {Vec3::UnitY(), -Vec3::UnitY(), Vec3::UnitZ(), -Vec3::UnitZ(), Vec3::UnitX(), -Vec3::UnitX()};
  double largest_ratio = 0.0;
  for (int round = 0; round < 300; ++round) {
    const DampingCoefficients first_material{.normal_ns_per_m = std::max(0.0, 5.0 * uniform(random)),
                                             .along_ns_per_m = std::max(0.0, 5.0 * uniform(random))};
    const DampingCoefficients second_material{.normal_ns_per_m = 2.0, .along_ns_per_m = 1.0};
    ContactDamping drag({{first_material, second_material}, {first_material}}, 1.0, 1.0);
    std::vector<DragContact> contacts;
    for (int k = 0; k < 1 + round % 6; ++k) {
      contacts.push_back({.normal = round % 2 == 0 ? sides[static_cast<std::size_t>(k)] : Vec3(vector().normalized()),
                          .force_n = 9.0 + uniform(random),
                          .part = k % 3 == 2 ? 1 : 0,
                          .object = round % 4 < 2 && k == 1 ? 1U : 0U});
    }
    double largest_ns_per_m = 0.0;
    for (const DragContact& contact : contacts) {
      const DampingCoefficients& material = contact.part == 0 && contact.object == 1 ? second_material : first_material;
      largest_ns_per_m = std::max({largest_ns_per_m, material.normal_ns_per_m, material.along_ns_per_m});
    }
    for (int n = 0; n < 5; ++n) {
      const Vec3 direction = n < 3 ? Vec3(Vec3::Unit(n)) : Vec3(vector().normalized());
      const double damping_along_ns_per_m = -move_steadily(drag, contacts, 0.01 * direction).force_n.dot(direction) / 0.01;
      ASSERT_LE(damping_along_ns_per_m, largest_ns_per_m * (1.0 + 1e-9)) << round;
      if (largest_ns_per_m > 0.0) largest_ratio = std::max(largest_ratio, damping_along_ns_per_m / largest_ns_per_m);
    }
  }
  EXPECT_NEAR(largest_ratio, 1.0, 1e-9);
}

TEST(ContactDamping, TwoMaterialsUnderOneFaceCountByTheirForces) {
  ContactDamping drag({{{.along_ns_per_m = 5.0}, {.along_ns_per_m = 20.0}}}, 1.0, 1.0);
  const ContactDamping::Wrench wrench = move_steadily(
      drag, {{.normal = Vec3::UnitZ(), .force_n = 3.0}, {.normal = Vec3::UnitZ(), .force_n = 1.0, .object = 1}}, {0.01, 0.0, 0.0});
  EXPECT_NEAR(wrench.force_n.x(), -(0.75 * 5.0 + 0.25 * 20.0) * 0.01, 1e-12);
}

TEST(ContactDamping, BeginsAndEndsWithTheForceOfItsContact) {
  ContactDamping drag({{kHoney}}, 1.0, 1.0);
  for (const double force_n : {1e-9, 1e-3, 0.1}) {
    const ContactDamping::Wrench wrench =
        move_steadily(drag, {{.arm = {0.1, 0.0, 0.0}, .normal = Vec3::UnitZ(), .force_n = force_n}}, {2.0, 0.0, 3.0});
    EXPECT_NEAR(wrench.force_n.x(), -force_n, 1e-9 * force_n);
    EXPECT_NEAR(wrench.force_n.z(), -force_n, 1e-9 * force_n) << "no more than the spring pushes: it never attracts";
  }
  // With two surfaces, the drag of each is bounded by its own contact force.
  const ContactDamping::Wrench with_second_surface = move_steadily(
      drag, {{.normal = Vec3::UnitZ(), .force_n = 0.1}, {.normal = Vec3::UnitY(), .force_n = 50.0, .object = 1}}, {2.0, 0.0, 0.0});
  EXPECT_NEAR(with_second_surface.force_n.x(), -0.1, 1e-9);
  EXPECT_TRUE(drag.step({}, false).force_n.isZero(0.0));
}

double longest_arm_of(const std::vector<DragContact>& contacts) {
  double arm = 0.0;
  for (const DragContact& contact : contacts) arm = std::max(arm, contact.arm.norm());
  return arm;
}

double sum_of_forces(const std::vector<DragContact>& contacts) {
  double sum_n = 0.0;
  for (const DragContact& contact : contacts) sum_n += contact.force_n;
  return sum_n;
}

// The velocity from which the drag is computed: the mean of the last samples.
struct VelocityTwin {
  SmoothVelocity velocity;
  SmoothVelocity turn_rate;

  void move(const Placement& from, const Placement& to, double dt_s) {
    velocity.move_last(from.position);
    velocity.add(to.position, dt_s);
    turn_rate.move_last(Vec3::Zero());
    turn_rate.add(turn_between(from.orientation, to.orientation), dt_s);
  }
  double power_w(const ContactDamping::Wrench& wrench) const {
    return wrench.force_n.dot(velocity.mean()) + wrench.torque_nm.dot(turn_rate.mean());
  }
};

// Contacts, motions and forces are random: contacts come and go from step to step, and the motion reverses.
TEST(ContactDamping, NeverGivesEnergyAndStaysWithinItsBound) {
  const unsigned seed = 228;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const auto vector = [&] { return Vec3(uniform(random), uniform(random), uniform(random)); };
  ContactDamping drag({{{3.0, 0.0}, {0.0, 40.0}, {9.0, 100.0}}}, 1.0, 2.0);
  Placement at;
  VelocityTwin twin;
  twin.move(at, at, kSamplePeriodS);
  drag.move(at, {}, kSamplePeriodS);
  double energy_given_j = 0.0;
  double lag_energy_j = 0.0;
  double last_bound_n = 0.0;
  double arm = 0.0;  // the longest lever of any contact so far
  for (int n = 0; n < 20000; ++n) {
    // The motion is steady for some samples, so that the velocity of the damper becomes that of the motion.
    const Vec3 shift = std::pow(10.0, -5.0 + 3.0 * std::abs(uniform(random))) * vector();
    const Vec3 turn = std::pow(10.0, -5.0 + 3.0 * std::abs(uniform(random))) * vector();
    std::vector<DragContact> contacts;
    for (int k = 0; k < n % 7; ++k) {
      contacts.push_back({.arm = vector(),
                          .normal = vector().normalized(),
                          .force_n = std::abs(uniform(random)),
                          .object = static_cast<std::uint32_t>((n + k) % 3)});
    }
    const bool is_held = !contacts.empty() || n % 14 == 0;
    arm = std::max(arm, longest_arm_of(contacts));
    ContactDamping::Wrench wrench;
    for (int k = 0; k < 10; ++k) {
      const Placement from = at;
      at = {at.position + shift, turn_by(turn) * at.orientation};
      drag.move(at, {}, kSamplePeriodS);
      twin.move(from, at, kSamplePeriodS);
      wrench = drag.step(contacts, is_held);
      const double norm_n = wrench.force_n.norm();
      const double bound_n = contacts.empty() ? last_bound_n : 2.0 * sum_of_forces(contacts);
      ASSERT_LE(norm_n, bound_n * (1.0 + 1e-12)) << n;
      ASSERT_LE(wrench.torque_nm.norm(), arm * bound_n * (1.0 + 1e-12)) << n;
      if (!contacts.empty()) last_bound_n = bound_n;
      if (!is_held) last_bound_n = 0.0;
      ASSERT_LE(twin.power_w(wrench), 1e-15) << n << ", " << k << ": whatever changes, it acts against the velocity that it knows";
      const double step_energy_j = wrench.force_n.dot(shift) + wrench.torque_nm.dot(turn);
      energy_given_j += step_energy_j;
      lag_energy_j += std::abs(step_energy_j - kSamplePeriodS * twin.power_w(wrench));
    }
    ASSERT_LE(wrench.force_n.dot(shift) + wrench.torque_nm.dot(turn), 0.0) << n;
  }
  EXPECT_LT(energy_given_j, 0.0) << "over all reversals";
  EXPECT_LE(energy_given_j, lag_energy_j) << "and never more than the lag of the velocity explains";
}

// If contacts stay, with forces far above the damping, the averaging of the velocity gives no energy back either (see SmoothVelocity).
TEST(ContactDamping, ReversalsGiveNoEnergyWhereContactsStay) {
  const unsigned seed = 17;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const auto vector = [&] { return Vec3(uniform(random), uniform(random), uniform(random)); };
  for (int round = 0; round < 50; ++round) {
    ContactDamping drag({{{3.0, 4.0}, {9.0, 1.0}}}, 1.0, 2.0);
    std::vector<DragContact> contacts;
    for (int k = 0; k <= round % 6; ++k) {
      contacts.push_back({.arm = vector(), .normal = vector().normalized(), .force_n = 50.0, .object = static_cast<std::uint32_t>(k % 2)});
    }
    move_steadily(drag, contacts, Vec3::Zero());
    Placement at;
    double energy_given_j = 0.0;
    for (int n = 0; n < 2000; ++n) {
      // The motion reverses every 1 to 16 samples: at these frequencies the mean lags most.
      const double sign = (n / (1 + round % 16)) % 2 == 0 ? 1.0 : -1.0;
      const Vec3 shift = 1e-5 * sign * Vec3(1.0, 0.5, -0.3) + 1e-6 * vector();
      const Vec3 turn = 1e-5 * sign * Vec3(0.4, -1.0, 0.2) + 1e-6 * vector();
      at = {at.position + shift, turn_by(turn) * at.orientation};
      drag.move(at, {}, kSamplePeriodS);
      const ContactDamping::Wrench wrench = drag.step(contacts, true);
      energy_given_j += wrench.force_n.dot(shift) + wrench.torque_nm.dot(turn);
    }
    ASSERT_LE(energy_given_j, 0.0) << round;
  }
}

// The largest change of the drag from one sample to the next, while the tool moves on at `speed` along x.
double largest_change_n(ContactDamping& drag, const std::vector<DragContact>& contacts, double speed, int first_sample, int sample_count) {
  double last_n = drag.step(contacts, true).force_n.x();
  double largest_n = 0.0;
  for (int n = first_sample; n < first_sample + sample_count; ++n) {
    drag.move(drag_placement({n * kSamplePeriodS * speed, 0.0, 0.0}), {{Placement()}}, kSamplePeriodS);
    const double force_n = drag.step(contacts, true).force_n.x();
    largest_n = std::max(largest_n, std::abs(force_n - last_n));
    last_n = force_n;
  }
  return largest_n;
}

TEST(ContactDamping, AChangeToASurfaceWithoutDampingIsSmoothed) {
  const double filter_share = kSamplePeriodS / (ContactDamping::kSmoothS + kSamplePeriodS);  // the part of a change that one sample makes
  for (const DampingCoefficients& damping : {DampingCoefficients{.along_ns_per_m = 5.0}, {.normal_ns_per_m = 5.0}}) {
    // The motion is in the direction that the surface damps.
    const Vec3 normal = damping.along_ns_per_m > 0.0 ? Vec3::UnitZ() : Vec3::UnitX();
    for (const int part : {0, 1}) {
      ContactDamping drag({{damping, {}}, {{}}}, 1.0, 1.0);
      const std::vector<DragContact> damped = {{.normal = normal, .force_n = 9.0}};
      const std::vector<DragContact> plain = {{.normal = normal, .force_n = 9.0, .part = part, .object = part == 0 ? 1U : 0U}};
      // 5 Ns/m at 0.2 m/s: the drag is 1 N.
      EXPECT_NEAR(move_steadily(drag, damped, {0.2, 0.0, 0.0}).force_n.x(), -1.0, 1e-12);
      EXPECT_LT(largest_change_n(drag, plain, 0.2, kSettlingSamples, 100), 1.001 * filter_share) << part;
      drag.move(drag_placement({0.2 * (kSettlingSamples + 100) * kSamplePeriodS, 0.0, 0.0}), {{Placement()}}, kSamplePeriodS);
      EXPECT_NEAR(drag.step(plain, true).force_n.x(), 0.0, 1e-7) << part;
      EXPECT_LT(largest_change_n(drag, damped, 0.2, kSettlingSamples + 101, 100), 1.001 * filter_share) << "and back";
    }
  }
}

// A contact that the slow task found late begins with a contact force, but without drag: the drag grows from zero.
TEST(ContactDamping, BeginsAtZeroWithContact) {
  ContactDamping drag({{kHoney}}, 1.0, 1.0);
  move_steadily(drag, {}, {0.2, 0.0, 0.0});
  EXPECT_LT(largest_change_n(drag, {{.normal = Vec3::UnitZ(), .force_n = 9.0}}, 0.2, kSettlingSamples, 50),
            1.001 * kSamplePeriodS / (ContactDamping::kSmoothS + kSamplePeriodS));
  drag.release();
  drag.move(drag_placement({0.2 * (kSettlingSamples + 50) * kSamplePeriodS, 0.0, 0.0}), {}, kSamplePeriodS);
  const double first_n = drag.step(std::vector<DragContact>{{.normal = Vec3::UnitZ(), .force_n = 9.0}}, true).force_n.norm();
  EXPECT_NEAR(first_n, kSamplePeriodS / (ContactDamping::kSmoothS + kSamplePeriodS), 1e-9);
}

TEST(ContactDamping, DecaysWhereTheToolIsHeldByContactsThatAreNotKnown) {
  ContactDamping drag({{{.along_ns_per_m = 5.0}}}, 1.0, 1.0);
  const std::vector<DragContact> contacts = {{.normal = Vec3::UnitZ(), .force_n = 9.0}};
  for (const double speed : {0.2, 20.0}) {  // the drag is below its bound, and at it
    double last_n = move_steadily(drag, contacts, {speed, 0.0, 0.0}).force_n.x();
    EXPECT_NEAR(last_n, -std::min(9.0, 5.0 * speed), 1e-9);
    for (int n = kSettlingSamples; n < kSettlingSamples + 80; ++n) {
      drag.move(drag_placement({n * kSamplePeriodS * speed, 0.0, 0.0}), {}, kSamplePeriodS);
      const double force_n = drag.step({}, true).force_n.x();
      ASSERT_NEAR(force_n, last_n / (1.0 + kSamplePeriodS / ContactDamping::kSmoothS), 2e-4) << n;
      last_n = force_n;
    }
    EXPECT_EQ(drag.step({}, true).force_n, Vec3(Vec3::Zero())) << "forgotten";
  }
  move_steadily(drag, contacts, {0.2, 0.0, 0.0});
  EXPECT_EQ(drag.step({}, false).force_n, Vec3(Vec3::Zero())) << "nothing holds the tool";
  EXPECT_EQ(drag.step({}, true).force_n, Vec3(Vec3::Zero()));
}

TEST(ContactDamping, AChangeOfContactsIsSmoothed) {
  ContactDamping drag({{{.along_ns_per_m = 5.0}}}, 1.0, 1.0);
  const std::vector<DragContact> near = {{.arm = {0.1, 0.0, 0.0}, .normal = Vec3::UnitZ(), .force_n = 9.0}};
  const std::vector<DragContact> far = {{.arm = {0.3, 0.0, 0.0}, .normal = Vec3::UnitZ(), .force_n = 9.0}};
  const double before_nm = move_steadily(drag, near, Vec3::Zero(), {0.0, 0.0, 0.5}).torque_nm.z();
  EXPECT_NEAR(before_nm, -5.0 * 0.1 * 0.1 * 0.5, 1e-12);
  double last_nm = before_nm;
  double largest_change_nm = 0.0;
  for (int n = kSettlingSamples; n < kSettlingSamples + 100; ++n) {
    drag.move(drag_placement(Vec3::Zero(), {0.0, 0.0, 0.5 * n * kSamplePeriodS}), {}, kSamplePeriodS);
    const double torque_nm = drag.step(far, true).torque_nm.z();
    largest_change_nm = std::max(largest_change_nm, std::abs(torque_nm - last_nm));
    last_nm = torque_nm;
  }
  const double change_nm = 5.0 * (0.09 - 0.01) * 0.5;
  EXPECT_NEAR(last_nm, -5.0 * 0.09 * 0.5, 1e-6);
  EXPECT_LT(largest_change_nm, 1.01 * change_nm * kSamplePeriodS / (ContactDamping::kSmoothS + kSamplePeriodS));
}

// The tests below make steps of a whole tool: a cube of 20 mm over `scene`.
std::unique_ptr<ToolStep> make_damped_step(const std::vector<TriangleMesh>& scene, const std::vector<DampingCoefficients>& damping,
                                           const std::vector<int>& parts = {}) {
  std::vector<std::shared_ptr<const TriangleMesh>> meshes;
  for (const TriangleMesh& mesh : scene) meshes.push_back(std::make_shared<TriangleMesh>(mesh));
  auto made = ToolStep::make(make_box({0.02, 0.02, 0.02}), std::move(meshes), {.stiffness_n_per_m = kCubeStiffness}, {}, nullptr, parts);
  EXPECT_TRUE(made) << made.error().what;
  EXPECT_TRUE((*made)->damp(damping));
  return std::move(*made);
}

ToolInput drag_input(const Vec3& p, double turn_rad = 0.0) {
  ToolInput input;
  input.X_WD.translation() = p;
  input.X_WD.linear() = turn_by({0.0, 0.0, turn_rad}).toRotationMatrix();
  input.dt_s = kSamplePeriodS;
  return input;
}

// Presses the cube 2 mm into a plane at z = 0 and holds it there until the damping has its full value.
void press_until_damped(ToolStep& step) {
  step.reset(drag_input({0.003, 0.004, 0.03}));
  for (int n = 0; n <= 220 + kSettlingSamples; ++n) step.step(drag_input({0.003, 0.004, 0.03 - 0.0001 * std::min(n, 220)}));
}

TEST(ContactDamping, ABoxThatSlidesOnAPlaneIsHeldBackByTheViscosity) {
  const auto step = make_damped_step({make_plane_grid(0.2, 8)}, {kHoney});
  const auto plain = make_damped_step({make_plane_grid(0.2, 8)}, {});
  press_until_damped(*step);
  press_until_damped(*plain);
  ToolOutput out;
  ToolOutput without;
  for (int n = 0; n < 60; ++n) {
    const ToolInput input = drag_input({0.003 + 4e-5 * n, 0.004 - 2e-5 * n, 0.008});
    out = step->step(input);
    without = plain->step(input);
    ASSERT_EQ(step->proxy().placement(), plain->proxy().placement()) << "the proxy is that of a tool without damping";
    if (n < 10) continue;
    const Vec3 drag_n = out.force_n - without.force_n;
    ASSERT_LT((drag_n - Vec3(-5.0 * 0.04, 5.0 * 0.02, 0.0)).norm(), 1e-6) << n;
    // The drag acts at the bottom of the box, where the force presses on the plane: in its middle, 10 mm below the grip point.
    ASSERT_LT((out.torque_nm - without.torque_nm - Vec3(0.0, 0.0, -0.01).cross(drag_n)).norm(), 1e-4 * drag_n.norm()) << n;
  }
}

TEST(ContactDamping, ABoxPressedFurtherInFeelsTheDampingAlongTheNormal) {
  const auto step = make_damped_step({make_plane_grid(0.2, 8)}, {kHoney});
  press_until_damped(*step);
  for (int n = 0; n < 30; ++n) {
    const double z = 0.008 - 1e-5 * n;
    const ToolOutput out = step->step(drag_input({0.003, 0.004, z}));
    if (n >= 10) {
      ASSERT_NEAR(out.force_n.z(), kCubeStiffness * (0.01 - z) + 3.0 * 0.01, 2e-3) << n;
    }
  }
}

// A face rests on four corners: the torque is coefficient times turn rate times the squared distance of a corner from the middle.
TEST(ContactDamping, ABoxThatTurnsOnAPlaneFeelsATorque) {
  const auto step = make_damped_step({make_plane_grid(0.2, 1)}, {{.along_ns_per_m = 5.0}});
  step->reset(drag_input({0.0, 0.0, 0.03}));
  for (int n = 0; n <= 220; ++n) step->step(drag_input({0.0, 0.0, 0.03 - 0.0001 * n}));
  for (int n = 0; n < 300; ++n) {
    const ToolOutput out = step->step(drag_input({0.0, 0.0, 0.008}, 2e-3 * n));
    // In other samples the corners may cross the diagonal between the plane's two triangles; then the diagonal carries the box.
    if (n >= 20 && n < 60) {
      ASSERT_NEAR(out.torque_nm.z(), -5.0 * 2e-4 * 2.0, 0.03 * 5.0 * 2e-4 * 2.0) << n;
    }
    ASSERT_LE(out.torque_nm.z(), 1e-9) << n;
    ASSERT_NEAR(out.force_n.z(), kCubeStiffness * 0.002, 0.01) << n;
  }
}

TriangleMesh wall_at_y(double y) {
  TriangleMesh wall = make_plane_grid(0.2, 4);
  for (Vec3& v : wall.vertices) v = turn_by({-std::numbers::pi / 2, 0.0, 0.0}) * v + Vec3(0.0, y, 0.0);
  return wall;
}

// The drag is that of the wall (7 Ns/m), not the sum of floor (5 Ns/m) and wall.
TEST(ContactDamping, InACornerTheMoreViscousSurfaceDetermines) {
  const auto step = make_damped_step({make_plane_grid(0.2, 4), wall_at_y(-0.03)}, {{.along_ns_per_m = 5.0}, {.along_ns_per_m = 7.0}});
  step->reset(drag_input({0.0, 0.0, 0.03}));
  for (int n = 0; n <= 220; ++n) step->step(drag_input({0.0, -1e-4 * n, 0.03 - 0.0001 * n}));
  ToolOutput out;
  for (int n = 0; n < 40; ++n) out = step->step(drag_input({3e-5 * n, -0.022, 0.008}));
  EXPECT_NEAR(out.force_n.x(), -7.0 * 0.03, 1e-4);
  EXPECT_NEAR(out.force_n.y(), kCubeStiffness * 0.002, 0.01);
}

TriangleMesh ridge_at_x(double x) {
  TriangleMesh ridge;
  ridge.vertices = {{x - 0.002, -0.1, -0.01}, {x + 0.002, -0.1, -0.01}, {x, -0.1, 0.0},
                    {x - 0.002, 0.1, -0.01},  {x + 0.002, 0.1, -0.01},  {x, 0.1, 0.0}};
  ridge.triangles = {{0, 2, 5}, {0, 5, 3}, {2, 1, 4}, {2, 4, 5}, {1, 0, 3}, {1, 3, 4}};
  return ridge;
}

// Two rails under the box carry it by the law of the lever: the rail at x = 5 mm takes (5 + 2) / 10 of the force.
TEST(ContactDamping, ABoxOnTwoRailsFeelsTheMeanOfTheirMaterialsByForce) {
  const auto step = make_damped_step({ridge_at_x(-0.005), ridge_at_x(0.005)}, {{.along_ns_per_m = 4.0}, {.along_ns_per_m = 14.0}});
  step->reset(drag_input({0.002, 0.0, 0.03}));
  for (int n = 0; n <= 220; ++n) step->step(drag_input({0.002, 0.0, 0.03 - 0.0001 * n}));
  ToolOutput out;
  for (int n = 0; n < 40; ++n) out = step->step(drag_input({0.002, 3e-5 * n, 0.008}));
  EXPECT_NEAR(out.force_n.y(), -(0.3 * 4.0 + 0.7 * 14.0) * 0.03, 2e-3 * 11.0 * 0.03);
}

TEST(ContactDamping, AnObjectThatMovesPastAToolAtRestFeelsTheSame) {
  const auto tool_moves = make_damped_step({make_plane_grid(0.2, 1)}, {kHoney}, {1});
  const auto plane_moves = make_damped_step({make_plane_grid(0.2, 1)}, {kHoney}, {1});
  std::vector<Pose> poses_at_rest = {Pose::Identity()};
  std::vector<Pose> moved_poses = poses_at_rest;
  ToolOutput of_moving_tool;
  ToolOutput of_moving_plane;
  for (int n = 0; n <= 300; ++n) {
    const Vec3 path(3e-5 * std::max(0, n - 220), -1e-5 * n, -0.0001 * std::min(n, 220));
    ToolInput input = drag_input(Vec3(0.0, 0.0, 0.03) + path);
    input.X_SO = poses_at_rest;
    ToolInput input_at_rest = drag_input({0.0, 0.0, 0.03});
    moved_poses[0].translation() = -path;
    input_at_rest.X_SO = moved_poses;
    if (n == 0) {
      tool_moves->reset(input);
      plane_moves->reset(input_at_rest);
    }
    of_moving_tool = tool_moves->step(input);
    of_moving_plane = plane_moves->step(input_at_rest);
    ASSERT_LT((of_moving_tool.force_n - of_moving_plane.force_n).norm(), 4e-3) << n;
  }
  EXPECT_NEAR(of_moving_tool.force_n.x(), -5.0 * 0.03, 1e-4);
  EXPECT_NEAR(of_moving_plane.force_n.x(), -5.0 * 0.03, 1e-4);
  // A jump of a part does not count as a velocity.
  moved_poses[0].translation().x() += 0.01;
  ToolInput input_at_rest = drag_input({0.0, 0.0, 0.03});
  input_at_rest.X_SO = moved_poses;
  const Vec3 after_jump_n = plane_moves->step(input_at_rest).force_n;
  EXPECT_LE(std::abs(after_jump_n.x()), 5.0 * 0.03 + 1e-4);
}

TEST(ContactDamping, TheFastTaskFeelsItAndPassesItOnToThePart) {
  HeldTool held(make_damped_step({make_plane_grid(0.2, 8)}, {kHoney}, {1}));
  HeldTool plain(make_damped_step({make_plane_grid(0.2, 8)}, {}, {1}));
  const std::vector<Pose> parts = {Pose::Identity()};
  Vec3 drag_n;
  for (int n = 0; n < 280; ++n) {
    ToolInput input = drag_input({0.003 + 4e-5 * std::max(0, n - 220), 0.004, std::max(0.008, 0.03 - 0.0001 * n)});
    input.X_SO = parts;
    const std::int64_t time_ns = 1'000'000 * n;
    const ToolOutput without = plain.step(input, time_ns);
    const AllocationGuard guard;
    const ToolOutput felt = held.step(input, time_ns);
    const std::uint64_t allocation_count = AllocationGuard::is_available() ? guard.count() : 0;
    ASSERT_EQ(allocation_count, 0U);
    held.follow();
    plain.follow();
    drag_n = felt.force_n - without.force_n;
    const Vec3 drag_nm = felt.torque_nm - without.torque_nm;
    ASSERT_LT((held.push_on(0).force_n - plain.push_on(0).force_n + drag_n).norm(), 1e-12) << n;
    ASSERT_LT((held.push_on(0).torque_nm - plain.push_on(0).torque_nm + drag_nm).norm(), 1e-12) << n;
  }
  EXPECT_NEAR(drag_n.x(), -5.0 * 0.04, 1e-5);
}

TEST(ContactDamping, HostileInputGivesAFiniteForce) {
  ContactDamping drag({{{1e300, 1e300}}}, 1e6, 1.0);
  for (int n = 0; n < 20; ++n) {
    drag.move(drag_placement({1e200 * n, 0.0, 0.0}), {}, 1e-300);
    const ContactDamping::Wrench wrench =
        drag.step(std::vector<DragContact>{{.arm = {1e100, 0.0, 0.0}, .normal = Vec3::UnitZ(), .force_n = 1e300},
                                           {.normal = Vec3::UnitZ(), .part = 7}},
                  true);
    ASSERT_TRUE(wrench.force_n.allFinite() && wrench.torque_nm.allFinite());
  }
}

}  // namespace
}  // namespace hapton
