#include "patch/move_table.h"

#include <gtest/gtest.h>

#include <vector>

namespace hapton {
namespace {

ObjectMove numbered_move(std::uint32_t serial, std::int32_t object, std::uint32_t source = 7) {
  return {.source = source, .serial = serial, .object = object, .start_ns = serial, .end_ns = serial + 10};
}

TEST(MoveTable, KeepsTheNewestMoveOfEachObject) {
  MoveTable table;
  EXPECT_TRUE(table.take(numbered_move(1, 3)));
  EXPECT_TRUE(table.take(numbered_move(2, 5)));
  EXPECT_TRUE(table.take(numbered_move(4, 3)));
  EXPECT_FALSE(table.take(numbered_move(4, 3))) << "again";
  EXPECT_FALSE(table.take(numbered_move(1, 3))) << "overtaken";
  ASSERT_EQ(table.moves().size(), 2U);
  EXPECT_EQ(table.find(3)->serial, 4U);
  EXPECT_EQ(table.find(5)->serial, 2U);
  EXPECT_EQ(table.find(4), nullptr);
  std::vector<std::uint32_t> recent;
  table.visit_recent([&](const ObjectMove& move) { recent.push_back(move.serial); });
  EXPECT_EQ(recent, (std::vector<std::uint32_t>{1, 2, 4}));
}

TEST(MoveTable, SaysWhichSerialsHaveCome) {
  MoveTable table;
  EXPECT_EQ(table.newest(), 0U);
  (void)table.take(numbered_move(1, 0));
  (void)table.take(numbered_move(4, 0));
  (void)table.take(numbered_move(2, 0));
  EXPECT_EQ(table.newest(), 4U);
  EXPECT_EQ(table.received(), 0b1101U);
  (void)table.take(numbered_move(500, 0));
  EXPECT_EQ(table.received(), 1U);
  (void)table.take(numbered_move(3, 0));
  EXPECT_EQ(table.received(), 1U) << "too long ago";
}

TEST(MoveTable, AnotherProcessBeginsAnew) {
  MoveTable table;
  (void)table.take(numbered_move(9, 3));
  EXPECT_TRUE(table.take(numbered_move(1, 4, 8)));
  EXPECT_EQ(table.find(3), nullptr);
  EXPECT_EQ(table.newest(), 1U);
  EXPECT_FALSE(table.take(numbered_move(0, 4, 9))) << "announces itself, and has moved nothing";
  EXPECT_EQ(table.moves().size(), 0U);
}

TEST(MoveTable, KeepsABoundedNumberOfMovesAndRejectsBadRotations) {
  MoveTable table;
  for (std::int32_t object = 0; object < 100; ++object) (void)table.take(numbered_move(static_cast<std::uint32_t>(object) + 1, object));
  EXPECT_EQ(table.moves().size(), PatchBody::kMaxBodies);
  int recent = 0;
  table.visit_recent([&](const ObjectMove&) { ++recent; });
  EXPECT_EQ(recent, 16);
  ObjectMove not_a_rotation = numbered_move(200, 0);
  not_a_rotation.to_q = Quat(1.0005, 0.0, 0.0, 0.0);
  EXPECT_FALSE(table.take(not_a_rotation));
}

}  // namespace
}  // namespace hapton
