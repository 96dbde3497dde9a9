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
  constexpr int kMostPieces = 400;
  int arrived = 0;
  for (int i = 0; i < 300; ++i) {
    const HeldCentre at = made.held(1 + i % 2);
    const LocalMinimum minimum(at.contacts);
    const Vec3 device = at.device + 0.1 * made.vector();
    Vec3 c = at.c;
    int work = 0;
    bool goes_on = true;
    for (int piece = 0; goes_on && piece < kMostPieces; ++piece) {
      CentrePath path;
      if (!DescentPath(at.contacts, c, work).make(device, Vec3::UnitX(), false, path)) break;
      EXPECT_EQ(path.start(), c);
      EXPECT_LE(minimum.find_turn(path.end() - c), 2.0 * LocalMinimum::kTurn) << i;
      double before = (device - c).norm();
      for (int k = 1; k <= kSamples; ++k) {
        const Vec3 p = path.at(static_cast<double>(k) / kSamples);
        EXPECT_LE(distance_off(at.contacts, p), MadeContacts::kClearance.tolerance) << i;
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

// Straight above a vertex all directions are alike: the hint decides.
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

}  // namespace
}  // namespace hapton
