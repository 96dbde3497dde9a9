#include "core/force/sphere/descent_path.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/core/force/sphere/made_contacts.h"

namespace hapton {
namespace {

constexpr std::uint64_t kSeedOfDescents = 2413;

class DescentPathOf : public testing::Test {
 protected:
  DescentPathOf() { RecordProperty("seed", std::to_string(kSeedOfDescents)); }
  MadeContacts made{kSeedOfDescents};
};

TEST_F(DescentPathOf, EachPieceStaysOnTheContactsAndComesNearerUntilAMinimum) {
  constexpr int kSamples = 32;
  constexpr int kMaxPieces = 400;
  int arrived = 0;
  for (int i = 0; i < 300; ++i) {
    const HeldCentre at = made.held(1 + i % 2);
    const LocalMinimum minimum(at.contacts);
    const Vec3 device = at.device + 0.1 * made.vector();
    Vec3 c = at.centre;
    int work = 0;
    bool goes_on = true;
    for (int piece = 0; goes_on && piece < kMaxPieces; ++piece) {
      CentrePath path;
      if (!DescentPath(at.contacts, c, work).make(device, Vec3::UnitX(), false, path)) break;
      EXPECT_EQ(path.start(), c);
      EXPECT_LE(minimum.find_turn(path.end() - c), 2.0 * LocalMinimum::kTurn) << i;
      double before = (device - c).norm();
      for (int k = 1; k <= kSamples; ++k) {
        const Vec3 p = path.at(static_cast<double>(k) / kSamples);
        EXPECT_LE(largest_offset_error(at.contacts, p), MadeContacts::kClearance.tolerance) << i;
        if (at.contacts.active_count() == 2 && k < kSamples) continue;  // along a curve a piece may pass the minimum
        EXPECT_LE((device - p).norm(), before + 1e-9) << i;
        before = (device - p).norm();
      }
      goes_on = (path.end() - c).norm() > 1e-11;
      c = path.end();
    }
    if (goes_on) continue;
    ++arrived;
    ContactFrame frame;
    ASSERT_TRUE(at.contacts.find_frame(c, frame));
    Vec3 pull = device - c;
    for (int k = 0; k < at.contacts.active_count(); ++k)
      pull -= frame.dual[static_cast<std::size_t>(k)].dot(device - c) * frame.normal[static_cast<std::size_t>(k)];
    EXPECT_LT(pull.norm(), 1e-9) << i;
  }
  EXPECT_GT(arrived, 200);
}

// A point between the two faces of a blade is nearer to both than the offset, by half of the slop. The position where it would be an offset
// from both is many offsets away.
TEST_F(DescentPathOf, BetweenNearlyOppositeFacesACentreReturnsToWhereBothAreAtTheOffset) {
  constexpr Clearance kClearanceOfPoint{0x1p-31, 0x1p-40, 0x1p-46};
  for (const double angle : {1e-3, 1e-4, 1e-5, 1e-6, 1e-7}) {
    for (int i = 0; i < 50; ++i) {
      const Vec3 along = made.vector().normalized();
      const Vec3 up = along.unitOrthogonal();
      const Vec3 out = along.cross(up);
      ContactSet contacts(kClearanceOfPoint);
      for (const double side : {1.0, -1.0}) {
        const Vec3 far = std::cos(0.5 * angle) * out + side * std::sin(0.5 * angle) * up;
        contacts.add(OffsetContact::on_face(side > 0.0 ? 0U : 1U, {-along, along, far}, -side * up));
      }
      contacts.activate_all();
      // A position at the offset from both faces is `tip` out from the edge; the centre is nearer to the edge, by half of the slop.
      const double tip = kClearanceOfPoint.offset / std::sin(0.5 * angle);
      const double short_by = 0.5 * kClearanceOfPoint.slop / std::sin(0.5 * angle);
      const Vec3 c = 0.2 * made.unit() * along + (tip - short_by) * out;
      int work = 0;
      CentrePath path;
      ASSERT_TRUE(DescentPath(contacts, c, work).return_to_crease(path)) << angle;
      EXPECT_TRUE(path.is_straight());
      EXPECT_EQ(path.start(), c);
      EXPECT_LE(largest_offset_error(contacts, path.end()), kClearanceOfPoint.tolerance);
      EXPECT_NEAR((path.end() - c).dot(out) / short_by, 1.0, 1e-3) << angle;
      const Vec3 there = path.end();
      EXPECT_FALSE(DescentPath(contacts, there, work).return_to_crease(path)) << angle << ": it is there";
    }
  }
}

TEST_F(DescentPathOf, FacesAtALargerAngleNeedNoReturn) {
  for (int i = 0; i < 300; ++i) {
    const HeldCentre at = made.held(1 + i % 3);
    int work = 0;
    CentrePath path;
    EXPECT_FALSE(DescentPath(at.contacts, at.centre + 1e-10 * made.vector(), work).return_to_crease(path));
  }
}

// Straight above a vertex all directions are equally steep: the hint decides.
TEST_F(DescentPathOf, TheHintDecidesStraightAboveAVertex) {
  const Vec3 c(0.0, 0.0, MadeContacts::kOffset);
  ContactSet contacts(MadeContacts::kClearance);
  contacts.add(OffsetContact::on_vertex(0, {Vec3::Zero(), Vec3(1, 0, -1), Vec3(0, 1, -1)}, 0));
  contacts.activate_all();
  for (const double turn : {0.0, 1.0, 2.0, 4.0}) {
    const Vec3 hint(std::cos(turn), std::sin(turn), 0.0);
    CentrePath path;
    int work = 0;
    ASSERT_TRUE(DescentPath(contacts, c, work).make(Vec3(0.0, 0.0, -1.0), hint, false, path));
    const Vec3 moved = path.end() - c;
    EXPECT_GT(moved.dot(hint), 0.1 * MadeContacts::kOffset);
    EXPECT_NEAR(moved.dot(Vec3(-hint.y(), hint.x(), 0.0)), 0.0, 1e-12);
  }
}

// Of a hint along the edge or the normal, nothing but rounding is left in the direction across them.
TEST_F(DescentPathOf, StraightAboveAnEdgeAHintAlongItIsNoDirection) {
  for (int i = 0; i < 300; ++i) {
    const Vec3 axis = made.vector().normalized();
    const Vec3 normal = axis.cross(made.vector()).normalized();
    const Vec3 c = MadeContacts::kOffset * normal;
    ContactSet contacts(MadeContacts::kClearance);
    contacts.add(OffsetContact::on_edge(0, {-axis, axis, axis.cross(normal) - normal}, 0));
    contacts.activate_all();
    const Vec3 hint = std::ldexp(1.0, -50 * (i % 2)) * (made.unit() * axis + (i % 3 == 0 ? 0.0 : made.unit()) * normal);
    CentrePath path;
    int work = 0;
    ASSERT_TRUE(DescentPath(contacts, c, work).make(-normal, hint, false, path));
    const Vec3 moved = path.end() - c;
    EXPECT_GT(moved.norm(), 0.1 * MadeContacts::kOffset);
    EXPECT_NEAR(path.end().norm(), MadeContacts::kOffset, 1e-9 * MadeContacts::kOffset);
    EXPECT_NEAR(path.slope(0.0).dot(normal), 0.0, 1e-9 * path.slope(0.0).norm());
  }
}

}  // namespace
}  // namespace hapton
