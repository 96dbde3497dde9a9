#include "vision_node/line_breaks.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

std::string break_at(std::size_t letters, std::string_view text) {
  return break_lines(text, [&](std::string_view line) { return line.size() <= letters; });
}

TEST(LineBreaks, WhatFitsStaysAsItIs) {
  EXPECT_EQ(break_at(20, "force 1.2 N   free\nmono"), "force 1.2 N   free\nmono");
  EXPECT_EQ(break_at(20, ""), "");
  EXPECT_EQ(break_at(20, "one\n\ntwo"), "one\n\ntwo");
}

TEST(LineBreaks, ALineIsBrokenBetweenItsEntries) {
  EXPECT_EQ(break_at(16, "x X knob box   b cull   h hand   q quit"), "x X knob box\nb cull   h hand\nq quit");
  EXPECT_EQ(break_at(12, "x X knob box   b cull   h hand   q quit"), "x X knob box\nb cull\nh hand\nq quit");
}

TEST(LineBreaks, AnEntryIsBrokenBetweenItsWordsAndAWordNowhere) {
  EXPECT_EQ(break_at(12, "free   a device that is away   mono"), "free\na device\nthat is away\nmono");
  EXPECT_EQ(break_at(4, "recalibrating"), "recalibrating");
}

}  // namespace
}  // namespace hapton
