#include "link/haptics_source.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

using SourceVerdict = HapticsSource::Verdict;

TEST(HapticsSource, TheFirstMoveOfAProcessMakesThoseOfTheOneBeforeVoid) {
  HapticsSource source;
  EXPECT_EQ(source.note({.source = 5, .serial = 9}, Arrival::newest), SourceVerdict::other);
  EXPECT_EQ(source.note({.source = 5, .serial = 10}, Arrival::newest), SourceVerdict::known);
  EXPECT_EQ(source.note({.source = 6, .serial = 0}, Arrival::newest), SourceVerdict::other);
  EXPECT_EQ(source.note({.source = 6, .serial = 1}, Arrival::newest), SourceVerdict::known);
}

// A datagram that was sent before the restart comes late.
TEST(HapticsSource, AMoveThatWasOvertakenByAnotherProcessIsOld) {
  HapticsSource source;
  source.note({.source = 5, .serial = 9}, Arrival::newest);
  source.note({.source = 6, .serial = 0}, Arrival::newest);
  EXPECT_EQ(source.note({.source = 5, .serial = 10}, Arrival::reordered), SourceVerdict::old);
  EXPECT_EQ(source.note({.source = 6, .serial = 1}, Arrival::newest), SourceVerdict::known);
}

// Each object has its own moves, so a move counts although a later move of another object overtook it.
TEST(HapticsSource, AnOvertakenMoveOfTheSameProcessCounts) {
  HapticsSource source;
  EXPECT_EQ(source.note({.source = 5, .serial = 2}, Arrival::reordered), SourceVerdict::other) << "nothing is known yet";
  EXPECT_EQ(source.note({.source = 5, .serial = 1}, Arrival::reordered), SourceVerdict::known);
}

// This process waited while another one held the slot.
TEST(HapticsSource, AProcessMayReturn) {
  HapticsSource source;
  source.note({.source = 5, .serial = 9}, Arrival::newest);
  source.note({.source = 6, .serial = 0}, Arrival::newest);
  EXPECT_EQ(source.note({.source = 5, .serial = 9}, Arrival::newest), SourceVerdict::other);
}

}  // namespace
}  // namespace hapton
