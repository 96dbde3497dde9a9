#include "core/force/sphere/minimum_legs.h"

#include <gtest/gtest.h>

#include <string>

#include "core/math/straight_motion.h"
#include "tests/core/force/sphere/made_contacts.h"

namespace hapton {
namespace {

constexpr std::uint64_t kSeedOfLegs = 2412;
constexpr int kLegSamples = 64;

class MinimumLegOf : public testing::Test {
 protected:
  MinimumLegOf() { RecordProperty("seed", std::to_string(kSeedOfLegs)); }
  MadeContacts made{kSeedOfLegs};
};

// The least multiplier of the active contacts for a centre and a device.
double least_multiplier(const ContactSet& contacts, const Vec3& c, const Vec3& device) {
  ContactFrame frame;
  EXPECT_TRUE(contacts.find_frame(c, frame));
  double least = 1.0;
  for (int i = 0; i < contacts.active_count(); ++i) least = std::min(least, frame.dual[static_cast<std::size_t>(i)].dot(c - device));
  return least;
}

TEST_F(MinimumLegOf, FollowsTheMinimaUntilTheDeviceArrivesOrAMultiplierIsZero) {
  int released_legs = 0;
  int whole_legs = 0;
  for (int i = 0; i < 600; ++i) {
    const HeldCentre at = made.held(1 + i % 2);
    const LocalMinimum minimum(at.contacts);
    if (!(minimum.find_stability(at.centre, at.device) > 0.2)) continue;
    const Vec3 to = at.device + (i % 3 == 0 ? 0.5 : 0.02) * made.vector();
    int work = 0;
    MinimumLeg leg;
    ASSERT_TRUE(MinimumLegs(at.contacts, at.centre, work).make(at.device, to, 0.0, leg)) << i;
    if (leg.is_on_curve) continue;
    ASSERT_GE(leg.time, 0.0);
    ASSERT_LE(leg.time, 1.0);
    EXPECT_EQ(leg.path.start(), at.centre);
    Vec3 exact = at.centre;
    for (int k = 1; k <= kLegSamples; ++k) {
      const double share = static_cast<double>(k) / kLegSamples;
      const Vec3 device = on_path(at.device, to, share * leg.time);
      ASSERT_TRUE(minimum.solve(device, exact, work)) << i;
      EXPECT_GT(least_multiplier(at.contacts, exact, device), -4.0 * LocalMinimum::kAtMinimum) << i << " at " << share;
      EXPECT_LE(largest_offset_error(at.contacts, leg.path.at(share)), MadeContacts::kClearance.tolerance) << i;
      // The cubic is where the minima are at the same time, to within a share of its length; events correct the rest.
      EXPECT_LT((leg.path.at(share) - exact).norm(), 1e-9 + 0.05 * (leg.path.end() - at.centre).norm()) << i << " at " << share;
    }
    EXPECT_LE((leg.path.end() - exact).norm(), 0x1p-26 * MadeContacts::kOffset) << i;
    if (leg.released >= 0) {
      EXPECT_NEAR(least_multiplier(at.contacts, leg.path.end(), on_path(at.device, to, leg.time)), 0.0, 1e-9) << i;
      ++released_legs;
    }
    whole_legs += leg.time >= 1.0 ? 1 : 0;
  }
  EXPECT_GT(released_legs, 20);
  EXPECT_GT(whole_legs, 100);
}

// The path itself is exact, and the times at which its positions are the minimum for the device rise along it.
TEST_F(MinimumLegOf, AlongACurveTheTimesRise) {
  int on_curve = 0;
  for (int i = 0; i < 600; ++i) {
    const HeldCentre at = made.held(2);
    const LocalMinimum minimum(at.contacts);
    if (!(minimum.find_stability(at.centre, at.device) > 0.05)) continue;
    const Vec3 to = at.device + made.vector();
    int work = 0;
    MinimumLeg leg;
    if (!MinimumLegs(at.contacts, at.centre, work).make(at.device, to, 0.0, leg) || !leg.is_on_curve) continue;
    ++on_curve;
    double last_time = 0.0;
    for (int k = 1; k <= kLegSamples; ++k) {
      Vec3 c = leg.path.at(static_cast<double>(k) / kLegSamples);
      ASSERT_LE(largest_offset_error(at.contacts, c), MadeContacts::kClearance.tolerance) << i;
      const double time = MinimumLegs(at.contacts, c, work).time_on_curve(at.device, to);
      EXPECT_GE(time, last_time - 1e-9) << i;
      last_time = time;
      const Vec3 device = on_path(at.device, to, std::min(time, 1.0));
      ContactFrame frame;
      ASSERT_TRUE(at.contacts.find_frame(c, frame));
      EXPECT_NEAR(frame.along.dot(c - on_path(at.device, to, time)), 0.0, 1e-9) << i;
      EXPECT_GT(least_multiplier(at.contacts, c, device), -1e-9) << i;
    }
    if (leg.vanishes) {
      EXPECT_LT(minimum.find_stability(leg.path.end(), on_path(at.device, to, leg.time)), 1e-4) << i;
    } else {
      EXPECT_NEAR(last_time, leg.time, 1e-7) << i;
    }
  }
  EXPECT_GT(on_curve, 20);
}

TEST_F(MinimumLegOf, OnTheAxisOfAnEdgeTheCentreKeepsItsAngle) {
  const Vec3 c(0.0, 0.0, MadeContacts::kOffset);
  ContactSet contacts(MadeContacts::kClearance);
  contacts.add(OffsetContact::on_edge(0, {Vec3(-1, 0, 0), Vec3(1, 0, 0), Vec3(0, 0, -1)}, 0));
  contacts.activate_all();
  int work = 0;
  MinimumLeg leg;
  ASSERT_TRUE(MinimumLegs(contacts, c, work).make(Vec3::Zero(), Vec3(0.5, 0.0, 0.0), 0.0, leg));
  EXPECT_EQ(leg.time, 1.0);
  EXPECT_EQ(leg.released, -1);
  EXPECT_LT((leg.path.end() - (c + Vec3(0.5, 0.0, 0.0))).norm(), 1e-15);
}

}  // namespace
}  // namespace hapton
