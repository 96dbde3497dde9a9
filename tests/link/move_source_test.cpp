#include "link/move_source.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

using MoveVerdict = MoveSource::Verdict;

TEST(MoveSource, TheFirstMoveOfAProcessMakesThoseOfTheOneBeforeVoid) {
  MoveSource source;
  EXPECT_EQ(source.note({.source = 5, .serial = 9}, Arrival::newest), MoveVerdict::other);
  EXPECT_EQ(source.note({.source = 5, .serial = 10}, Arrival::newest), MoveVerdict::known);
  EXPECT_EQ(source.note({.source = 6, .serial = 0}, Arrival::newest), MoveVerdict::other);
  EXPECT_EQ(source.note({.source = 6, .serial = 1}, Arrival::newest), MoveVerdict::known);
}

// A datagram that was sent before the restart comes late.
TEST(MoveSource, AMoveThatWasOvertakenByAnotherProcessIsOld) {
  MoveSource source;
  source.note({.source = 5, .serial = 9}, Arrival::newest);
  source.note({.source = 6, .serial = 0}, Arrival::newest);
  EXPECT_EQ(source.note({.source = 5, .serial = 10}, Arrival::reordered), MoveVerdict::old);
  EXPECT_EQ(source.note({.source = 6, .serial = 1}, Arrival::newest), MoveVerdict::known);
}

// Each object has its own moves, so a move counts although a later move of another object overtook it.
TEST(MoveSource, AnOvertakenMoveOfTheSameProcessCounts) {
  MoveSource source;
  EXPECT_EQ(source.note({.source = 5, .serial = 2}, Arrival::reordered), MoveVerdict::other) << "nothing is known yet";
  EXPECT_EQ(source.note({.source = 5, .serial = 1}, Arrival::reordered), MoveVerdict::known);
}

// This process waited while another one held the slot.
TEST(MoveSource, AProcessMayReturn) {
  MoveSource source;
  source.note({.source = 5, .serial = 9}, Arrival::newest);
  source.note({.source = 6, .serial = 0}, Arrival::newest);
  EXPECT_EQ(source.note({.source = 5, .serial = 9}, Arrival::newest), MoveVerdict::other);
}

}  // namespace
}  // namespace hapton
