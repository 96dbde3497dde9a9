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

// A datagram of before the restart that comes late.
TEST(MoveSource, AMoveThatWasOvertakenByAnotherProcessIsOld) {
  MoveSource source;
  source.note({.source = 5, .serial = 9}, Arrival::newest);
  source.note({.source = 6, .serial = 0}, Arrival::newest);
  EXPECT_EQ(source.note({.source = 5, .serial = 10}, Arrival::reordered), MoveVerdict::old);
  EXPECT_EQ(source.note({.source = 6, .serial = 1}, Arrival::newest), MoveVerdict::known);
}

// Each object has moves of its own: one that came late is as good as new.
TEST(MoveSource, AnOvertakenMoveOfTheSameProcessCounts) {
  MoveSource source;
  EXPECT_EQ(source.note({.source = 5, .serial = 2}, Arrival::reordered), MoveVerdict::other) << "nothing is known yet";
  EXPECT_EQ(source.note({.source = 5, .serial = 1}, Arrival::reordered), MoveVerdict::known);
}

// It waited while another one had its place.
TEST(MoveSource, AProcessMayReturn) {
  MoveSource source;
  source.note({.source = 5, .serial = 9}, Arrival::newest);
  source.note({.source = 6, .serial = 0}, Arrival::newest);
  EXPECT_EQ(source.note({.source = 5, .serial = 9}, Arrival::newest), MoveVerdict::other);
}

}  // namespace
}  // namespace hapton
