#include "core/force/sphere/local_minimum.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/core/force/sphere/made_contacts.h"

namespace hapton {
namespace {

constexpr std::uint64_t kSeedOfMinima = 2411;

class LocalMinimumOf : public testing::Test {
 protected:
  LocalMinimumOf() { RecordProperty("seed", std::to_string(kSeedOfMinima)); }

  // A position beside the minimum that is also on the contacts.
  Vec3 beside(const HeldCentre& held, double step) {
    Vec3 c = held.centre + step * made.vector();
    int work = 0;
    EXPECT_TRUE(held.contacts.restore(c, work));
    return c;
  }
  MadeContacts made{kSeedOfMinima};
};

TEST_F(LocalMinimumOf, SolveFindsTheNearestPosition) {
  for (int i = 0; i < 400; ++i) {
    const HeldCentre at = made.held(1 + i % 2);
    const LocalMinimum minimum(at.contacts);
    if (!(minimum.find_stability(at.centre, at.device) > 0.2)) continue;
    Vec3 c = beside(at, 1e-3);
    int work = 0;
    ASSERT_TRUE(minimum.solve(at.device, c, work)) << i;
    EXPECT_LE((c - at.centre).norm(), (at.contacts.active_count() == 1 ? 0x1p-40 : 0x1p-26) * MadeContacts::kOffset) << i;
    EXPECT_LE(largest_offset_error(at.contacts, c), MadeContacts::kClearance.tolerance) << i;
    for (int k = 0; k < 50; ++k) EXPECT_GT((beside(at, 1e-2) - at.device).norm(), (c - at.device).norm() - 1e-14) << i;
  }
}

// The second derivative, by differences, is that of half the squared distance to the device along the curve.
TEST_F(LocalMinimumOf, StabilityOfACurveIsTheSecondDerivative) {
  constexpr double kStep = 1e-4;
  for (int i = 0; i < 200; ++i) {
    const HeldCentre at = made.held(2);
    ContactFrame frame;
    ASSERT_TRUE(at.contacts.find_frame(at.centre, frame));
    const auto value = [&](double step) {
      Vec3 c = at.centre + step * frame.along;
      int work = 0;
      EXPECT_TRUE(at.contacts.restore(c, work));
      return 0.5 * (c - at.device).squaredNorm();
    };
    const double second = (value(kStep) + value(-kStep) - 2.0 * value(0.0)) / (kStep * kStep);
    EXPECT_NEAR(LocalMinimum(at.contacts).find_stability(at.centre, at.device), second, 1e-4) << i;
  }
}

TEST_F(LocalMinimumOf, TheRateIsThatOfTheMinimaOfADeviceThatMoves) {
  constexpr double kStep = 1e-5;
  for (int i = 0; i < 400; ++i) {
    const HeldCentre at = made.held(1 + i % 2);
    const LocalMinimum minimum(at.contacts);
    if (!(minimum.find_stability(at.centre, at.device) > 0.2)) continue;
    const Vec3 motion = made.vector();
    Vec3 before = at.centre;
    Vec3 after = at.centre;
    int work = 0;
    ASSERT_TRUE(minimum.solve(at.device - kStep * motion, before, work)) << i;
    ASSERT_TRUE(minimum.solve(at.device + kStep * motion, after, work)) << i;
    const Vec3 rate = (after - before) / (2.0 * kStep);
    EXPECT_LT((minimum.find_rate(at.centre, at.device, motion) - rate).norm(), 1e-6 * (1.0 + rate.norm())) << i;
  }
}

TEST_F(LocalMinimumOf, AnEdgeTurnsTheCentreByTheAngleAcrossIt) {
  ContactSet contacts(MadeContacts::kClearance);
  const Vec3 c(0.0, 0.0, MadeContacts::kOffset);
  contacts.add(OffsetContact::on_edge(0, {Vec3(-1, 0, 0), Vec3(1, 0, 0), Vec3(0, 0, -1)}, 0));
  contacts.activate_all();
  const LocalMinimum minimum(contacts);
  EXPECT_EQ(minimum.find_turn(Vec3(5.0, 0.0, 0.0)), 0.0);
  EXPECT_DOUBLE_EQ(minimum.find_turn(Vec3(5.0, 0.1, 0.0)), 0.1 / MadeContacts::kOffset);
  EXPECT_TRUE(minimum.is_on_axis(Vec3(0.3, 0.0, 0.0)));
  EXPECT_FALSE(minimum.is_on_axis(Vec3(0.3, 0.0, -1e-9)));
  const double time = minimum.time_off_axis(Vec3(0.3, 0.0, 0.0), Vec3(0.3, 0.0, -1.0), 0.0);
  EXPECT_DOUBLE_EQ(time, 4.0 * LocalMinimum::kAtAxis);
}

// A vertex holds the centre straight above it against a device below, and a wall presses from the side with almost no force.
TEST_F(LocalMinimumOf, ABarrierOfNextToNothingIsShallow) {
  const Vec3 c = Vec3::Zero();
  ContactSet contacts(MadeContacts::kClearance);
  contacts.add(made.contact(0, Feature::vertex, c, Vec3::UnitZ(), 0.0));
  contacts.add(made.contact(1, Feature::face, c, Vec3::UnitX(), 0.0));
  contacts.activate_all();
  Vec3 over;
  const Vec3 below(0.0, 0.0, -2.0 * MadeContacts::kOffset);
  EXPECT_TRUE(LocalMinimum(contacts).is_shallow(c, below - Vec3(1e-6, 0.0, 0.0), over));
  EXPECT_GT(over.dot(Vec3::UnitX()), 0.99);
  EXPECT_FALSE(LocalMinimum(contacts).is_shallow(c, below - Vec3(1e-3, 0.0, 0.0), over));
}

TEST_F(LocalMinimumOf, AContactThatTheMinimumWouldEnterBecomesActive) {
  const Vec3 c = Vec3::Zero();
  ContactSet contacts(MadeContacts::kClearance);
  contacts.add(made.contact(0, Feature::face, c, Vec3::UnitZ(), 0.0));
  contacts.activate_all();
  contacts.add(made.contact(1, Feature::face, c, Vec3::UnitX(), 0.0));
  const Vec3 device = -Vec3::UnitZ();
  activate_opposing(contacts, c, device, Vec3::UnitX());
  EXPECT_EQ(contacts.active_count(), 1);
  activate_opposing(contacts, c, device, -Vec3::UnitX());
  EXPECT_EQ(contacts.active_count(), 2);
}

}  // namespace
}  // namespace hapton
