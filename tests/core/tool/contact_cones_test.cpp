#include "core/tool/contact_cones.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <span>

namespace hapton {
namespace {

// A tool with contacts at these points (relative to the grip point), each on a surface with the normal given beside it.
LocalContacts make_contacts_at(std::initializer_list<std::pair<Vec3, Vec3>> points, const CoulombFriction& friction,
                               double turn_length = 0.5) {
  LocalContacts local;
  local.is_blocked = false;
  local.tolerance = 1e-9;
  local.stiffness << Vec3::Ones(), Vec3::Constant(turn_length * turn_length);
  local.plain_inverse_root << Vec3::Ones(), Vec3::Constant(1.0 / turn_length);
  local.inverse_root = local.plain_inverse_root.asDiagonal();
  for (const auto& [arm, normal] : points) {
    MotionBound bound;
    bound.row << normal, arm.cross(normal);
    local.add(bound, {.arm = arm, .friction = friction});
  }
  return local;
}

LocalContacts::Solution solve_frictionless(const LocalContacts& local, const Vec6& wanted) {
  const Vec3 turn = wanted.tail<3>();
  return local.solve({wanted.head<3>(), turn_by(turn)});
}

Vec6 solve_motion(ContactCones& cones, const LocalContacts& local, const Vec6& wanted, bool is_static = false,
                  const Vec6& from = Vec6::Zero()) {
  cones.solve(local, wanted, from, solve_frictionless(local, wanted), is_static);
  return cones.motion();
}

// Four corners of a box on a floor, below its grip point.
LocalContacts box_on_floor(const CoulombFriction& friction) {
  const Vec3 up = Vec3::UnitZ();
  return make_contacts_at({{{0.1, 0.1, -0.1}, up}, {{-0.1, 0.1, -0.1}, up}, {{0.1, -0.1, -0.1}, up}, {{-0.1, -0.1, -0.1}, up}}, friction);
}

TEST(ContactCones, ABoxThatIsPressedSticksUntilTheCoefficientIsReached) {
  const LocalContacts local = box_on_floor({0.5, 0.3});
  for (const double along : {0.0, 0.002, 0.0049, 0.0051, 0.02}) {
    ContactCones cones;
    Vec6 wanted = Vec6::Zero();
    wanted.head<3>() << along, 0.0, -0.01;
    const Vec6 motion = solve_motion(cones, local, wanted, true);
    EXPECT_NEAR(motion[2], 0.0, 2e-6);
    EXPECT_NEAR(motion[0], along < 0.005 ? 0.0 : along - 0.005, 2e-6) << along;
    EXPECT_EQ(cones.slip() > 1e-6, along > 0.005);
  }
}

TEST(ContactCones, ABoxThatSlidesLagsByTheDynamicCoefficient) {
  const LocalContacts local = box_on_floor({0.5, 0.3});
  ContactCones cones;
  Vec6 wanted = Vec6::Zero();
  wanted.head<3>() << 0.006, 0.008, -0.01;
  const Vec6 motion = solve_motion(cones, local, wanted);
  EXPECT_NEAR((wanted - motion).head<2>().norm(), 0.003, 1e-7);
  EXPECT_NEAR(motion[0] * 0.8 - motion[1] * 0.6, 0.0, 1e-6) << "against the slide";
}

// Friction in a groove with a right angle is root 2 times that on a floor.
TEST(ContactCones, AGrooveHoldsByItsSides) {
  const double h = std::sqrt(0.5);
  const LocalContacts local = make_contacts_at(
      {{{0.2, 0.1, -0.1}, {0, -h, h}}, {{-0.2, 0.1, -0.1}, {0, -h, h}}, {{0.2, -0.1, -0.1}, {0, h, h}}, {{-0.2, -0.1, -0.1}, {0, h, h}}},
      {0.3, 0.3});
  ContactCones cones;
  Vec6 wanted = Vec6::Zero();
  wanted.head<3>() << 0.02, 0.0, -0.01;
  EXPECT_NEAR(wanted[0] - solve_motion(cones, local, wanted)[0], 0.3 * std::sqrt(2.0) * 0.01, 2e-7);
}

// Random contacts on one tool, friction up to 1.2: penetration is no more than what the iteration leaves, the energy of the coupling is at
// most 5 % above that of the tool that stays, and the forces, each within its friction cone, balance the coupling.
TEST(ContactCones, RandomContactsHoldTheTool) {
  std::mt19937_64 random(20261128);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  int sliding_trials = 0, sticking_trials = 0, unconverged_trials = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    LocalContacts local = make_contacts_at({}, {});
    const int count = 1 + trial % 6;
    for (int i = 0; i < count; ++i) {
      const Vec3 normal = Vec3(0.6 * uniform(random), 0.6 * uniform(random), 1.0).normalized();
      const Vec3 arm(0.3 * uniform(random), 0.3 * uniform(random), -0.2 + 0.1 * uniform(random));
      const double coefficient = 0.6 * (1.0 + uniform(random));
      MotionBound bound;
      bound.row << normal, arm.cross(normal);
      local.add(bound, {.arm = arm, .friction = {coefficient, coefficient}});
    }
    Vec6 wanted;
    for (int k = 0; k < 6; ++k) wanted[k] = 0.01 * uniform(random);
    wanted[2] -= 0.02;
    ContactCones cones;
    const Vec6 motion = solve_motion(cones, local, wanted);
    const auto energy = [&](const Vec6& at) { return local.stiffness.cwiseProduct(at - wanted).dot(at - wanted); };
    ASSERT_LE(energy(motion), energy(Vec6::Zero()) * 1.05) << trial;
    double deepest = 0.0;
    for (std::size_t i = 0; i < local.count; ++i) deepest = std::max(deepest, -local.bounds[i].row.dot(motion));
    ASSERT_LT(deepest, 3e-3) << trial;
    Vec6 sum = Vec6::Zero();
    std::array<ContactForce, ContactCones::kMax> forces;
    const std::size_t force_count = cones.list_forces(local, forces);
    ASSERT_GT(force_count, 0U) << trial;
    for (const ContactForce& force : std::span(forces).first(force_count)) {
      const auto i = static_cast<std::size_t>(force.index);
      const Vec3 tangential = force.wrench.head<3>() - force.normal * local.bounds[i].row.head<3>();
      ASSERT_GT(force.normal, 0.0) << trial;
      ASSERT_LE(tangential.norm(), local.contacts[i].friction.friction_dynamic * force.normal + 1e-15) << trial;
      ASSERT_LT((force.wrench.tail<3>() - local.contacts[i].arm.cross(force.wrench.head<3>())).norm(), 1e-15) << trial;
      sum += force.wrench;
    }
    ASSERT_LT((sum - local.stiffness.cwiseProduct(motion - wanted)).norm(), 1e-14) << trial;
    unconverged_trials += deepest > 1e-4 ? 1 : 0;
    ++(cones.slip() > 1e-5 ? sliding_trials : sticking_trials);
  }
  EXPECT_LT(unconverged_trials, 100) << "trials that ran out of rounds";
  EXPECT_GT(sliding_trials, 400);
  EXPECT_GT(sticking_trials, 400);
}

TEST(ContactCones, TheLastStepIsTheFirstGuess) {
  const LocalContacts local = box_on_floor({0.5, 0.5});
  ContactCones cones;
  Vec6 wanted = Vec6::Zero();
  wanted.head<3>() << 0.004, 0.0, -0.01;
  const Vec6 first = solve_motion(cones, local, wanted);
  const int rounds_without_guess = cones.rounds();
  const Vec6 again = solve_motion(cones, local, wanted);
  EXPECT_LT(cones.rounds(), rounds_without_guess);
  EXPECT_LT((again - first).norm(), 5e-6);
  cones.forget();
  solve_motion(cones, local, wanted);
  EXPECT_EQ(cones.rounds(), rounds_without_guess);
}

TEST(ContactCones, AContactThatWasLeftOutIsAdded) {
  // The frictionless solution that is passed on has no active contact; with friction the tool stays on the floor and needs its contacts.
  LocalContacts local = box_on_floor({0.9, 0.9});
  ContactCones cones;
  Vec6 wanted = Vec6::Zero();
  wanted.head<3>() << 0.0, 0.0, -0.01;
  cones.solve(local, wanted, Vec6::Zero(), {}, true);
  EXPECT_NEAR(cones.motion().norm(), 0.0, 1e-6);
}

}  // namespace
}  // namespace hapton
