#include "core/force/sphere/contact_set.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/core/force/sphere/made_contacts.h"

namespace hapton {
namespace {

constexpr std::uint64_t kSeedOfSets = 241;

class ContactSetOf : public testing::Test {
 protected:
  ContactSetOf() { RecordProperty("seed", std::to_string(kSeedOfSets)); }
  MadeContacts made{kSeedOfSets};
};

// Searches the position nearest to `from` that is an offset from each contact, by ever smaller steps in random directions.
Vec3 search_nearest(MadeContacts& made, const ContactSet& contacts, const Vec3& from, const Vec3& start) {
  const auto cost = [&](const Vec3& c) { return (c - from).norm() + 1e3 * largest_offset_error(contacts, c); };
  Vec3 best = start;
  for (double step = 1e-2; step > 1e-10; step *= 0.7) {
    for (int i = 0; i < 60; ++i) {
      const Vec3 candidate = best + step * made.vector();
      if (cost(candidate) < cost(best)) best = candidate;
    }
  }
  return best;
}

TEST_F(ContactSetOf, RestoreEndsAnOffsetFromEachAndHardlyFartherThanTheNearestSuchPosition) {
  for (int i = 0; i < 600; ++i) {
    const Vec3 c = made.vector();
    const ContactSet contacts = made.set(1 + i % 3, c, 1e-3);
    Vec3 restored = c;
    ContactFrame frame;
    int work = 0;
    ASSERT_TRUE(contacts.restore_to_frame(restored, frame, work)) << i;
    EXPECT_GT(work, 0);
    EXPECT_LE(largest_offset_error(contacts, restored), MadeContacts::kClearance.tolerance) << i;
    for (int k = 0; k < contacts.active_count(); ++k) {
      EXPECT_LT((frame.normal[static_cast<std::size_t>(k)] - contacts[k].proximity(restored).normal).norm(), 1e-15);
      for (int j = 0; j < contacts.active_count(); ++j) {
        const double dot = frame.dual[static_cast<std::size_t>(j)].dot(contacts[k].proximity(restored).normal);
        EXPECT_NEAR(dot, j == k ? 1.0 : 0.0, 1e-13) << i;
      }
    }
    // Newton's steps go along the normals: their end differs from the nearest position in the second order only.
    if (i % 10 != 0) continue;
    const Vec3 nearest = search_nearest(made, contacts, c, restored);
    EXPECT_LT((restored - c).norm(), (nearest - c).norm() + 4e-4) << i;
    EXPECT_LT((restored - nearest).norm(), 1e-4) << i;
  }
}

TEST_F(ContactSetOf, ParallelNormalsHaveNoFrameAndNoPosition) {
  ContactSet contacts(MadeContacts::kClearance);
  const Vec3 c = Vec3::Zero();
  contacts.add(made.contact(0, Feature::face, c, Vec3::UnitZ(), 0.0));
  contacts.add(made.contact(1, Feature::vertex, c, Vec3::UnitZ(), 0.0));
  contacts.activate_all();
  ContactFrame frame;
  EXPECT_FALSE(contacts.find_frame(c, frame));
  Vec3 moved(0.0, 0.0, 0.01);
  int work = 0;
  EXPECT_FALSE(contacts.restore(moved, work));
}

TEST_F(ContactSetOf, HoldsOneContactOfATriangleAndNoMoreThanItHasRoomFor) {
  ContactSet contacts(MadeContacts::kClearance);
  const Vec3 c = Vec3::Zero();
  EXPECT_TRUE(contacts.is_empty());
  for (std::uint32_t i = 0; i < ContactSet::kMax; ++i) EXPECT_TRUE(contacts.add(made.contact(i, Feature::face, c, made.vector(), 0.0)));
  EXPECT_FALSE(contacts.add(made.contact(99, Feature::face, c, made.vector(), 0.0)));
  EXPECT_TRUE(contacts.add(made.contact(3, Feature::edge, c, made.vector(), 0.0)));
  EXPECT_EQ(contacts.count(), ContactSet::kMax);
  EXPECT_EQ(contacts[3].part, Feature::edge);
  EXPECT_EQ(contacts.active_count(), 0);
  contacts.activate(3);
  EXPECT_EQ(contacts[0].triangle, 3U);
  contacts.remove(1);
  EXPECT_EQ(contacts.active_count(), 1);
  EXPECT_EQ(contacts[1].triangle, 2U);
  contacts.keep_active();
  EXPECT_EQ(contacts.count(), 1);
  contacts.clear();
  EXPECT_TRUE(contacts.is_empty());
}

// The free part of a held pull is the vector nearest to the pull that leads into no contact. The multipliers of the active contacts are
// positive, and times the normals they sum up to the part that was taken away.
TEST_F(ContactSetOf, FindActiveGivesTheNearestFreePull) {
  for (int i = 0; i < 400; ++i) {
    const Vec3 c = made.vector();
    ContactSet contacts(MadeContacts::kClearance);
    const int count = 1 + i % 5;
    const Vec3 up = made.vector().normalized();
    for (int k = 0; k < count; ++k)
      contacts.add(made.contact(static_cast<std::uint32_t>(k), Feature::face, c, up + 0.6 * made.vector(), 0.0));
    const Vec3 pull = made.vector() - 0.5 * up;
    Vec3 free;
    ASSERT_TRUE(contacts.find_active(c, pull, Vec3::Zero(), free));
    if (contacts.active_count() == 0) {
      for (const OffsetContact& contact : contacts.all()) EXPECT_GE(contact.normal.dot(pull), 0.0) << i;
      continue;
    }
    for (const OffsetContact& contact : contacts.all()) EXPECT_GE(contact.normal.dot(free), -1e-14) << i;
    // Of sampled directions that lead into no contact, none has a larger component of the pull.
    double largest_component = 0.0;
    for (int k = 0; k < 300; ++k) {
      const Vec3 direction =
          (free.norm() > 1e-3 && k % 2 == 0 ? Vec3(free.normalized() + 0.1 * made.vector()) : made.vector()).normalized();
      bool is_free = true;
      for (const OffsetContact& contact : contacts.all()) is_free &= contact.normal.dot(direction) >= 0.0;
      if (is_free) largest_component = std::max(largest_component, direction.dot(pull));
    }
    EXPECT_LE(largest_component, free.norm() + 1e-14) << i;
    Vec3 residual = pull - free;
    ContactFrame frame;
    ASSERT_TRUE(contacts.find_frame(c, frame));
    const Vec3 removed_pull = residual;
    for (int k = 0; k < contacts.active_count(); ++k) {
      const double multiplier = -frame.dual[static_cast<std::size_t>(k)].dot(removed_pull);
      EXPECT_GT(multiplier, 0.0) << i;
      residual += multiplier * contacts[k].normal;
    }
    EXPECT_LT(residual.norm(), 1e-13) << i;
  }
}

TEST_F(ContactSetOf, WhereConstraintsBalanceTheMotionDecides) {
  ContactSet contacts(MadeContacts::kClearance);
  const Vec3 c = Vec3::Zero();
  contacts.add(made.contact(0, Feature::face, c, Vec3::UnitZ(), 0.0));
  Vec3 free;
  ASSERT_TRUE(contacts.find_active(c, Vec3::UnitX(), -Vec3::UnitZ(), free));
  EXPECT_EQ(contacts.active_count(), 1);
  ASSERT_TRUE(contacts.find_active(c, Vec3::UnitX(), Vec3::UnitZ(), free));
  EXPECT_EQ(contacts.active_count(), 0);
}

TEST_F(ContactSetOf, TheMultipliersSumUpToWhatHoldsTheCentre) {
  for (int i = 0; i < 200; ++i) {
    const Vec3 c = made.vector();
    ContactSet contacts = made.set(1 + i % 3, c, 0.0);
    std::array<double, 3> multipliers{};
    Vec3 device = c;
    for (int k = 0; k < contacts.active_count(); ++k) {
      multipliers[static_cast<std::size_t>(k)] = 0.5 + 0.4 * made.unit();
      device -= multipliers[static_cast<std::size_t>(k)] * contacts[k].proximity(c).normal;
    }
    contacts.note_multipliers(c, device);
    for (int k = 0; k < contacts.active_count(); ++k) EXPECT_NEAR(contacts[k].multiplier, multipliers[static_cast<std::size_t>(k)], 1e-12);
  }
}

TEST_F(ContactSetOf, GuidingCornersAreThoseOfActiveEdgesAndVertices) {
  const ContactTriangle shape(Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0));
  const ContactTriangle beside(Vec3(1, 0, 0), Vec3(0, 0, 0), Vec3(0, -1, 0));
  const Triangle vertices{};
  const ObjectGeometry::Corners corners{beside.corner(0), beside.corner(1), beside.corner(2), vertices};
  ContactSet contacts(MadeContacts::kClearance);
  contacts.add(OffsetContact::on_edge(0, shape, 0));
  EXPECT_EQ(contacts.guiding_corners(beside), 0U);  // not active
  EXPECT_FALSE(contacts.holds_part_of(corners, 1));
  contacts.activate_all();
  EXPECT_EQ(contacts.guiding_corners(beside), 3U);
  EXPECT_TRUE(contacts.holds_part_of(corners, 1));
  contacts.add(OffsetContact::on_edge(1, beside, 0));
  contacts.activate_all();
  EXPECT_TRUE(contacts.is_held_twice(1));
}

}  // namespace
}  // namespace hapton
