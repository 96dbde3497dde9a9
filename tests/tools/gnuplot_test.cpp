#include "tools/gnuplot.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

// The folder of a plot is made like the folder of a table. Whether gnuplot is installed here does not matter.
TEST(Gnuplot, TheFolderOfAPlotIsMade) {
  const ScratchFolder scratch;
  const auto folder = scratch.path() / "a" / "b";
  const auto drawn = draw_with_gnuplot(folder, "plot.txt", "set terminal dumb\nset output 'plot.txt.part'\nplot x\n");
  EXPECT_TRUE(std::filesystem::is_directory(folder)) << drawn.error().what;
  EXPECT_EQ(drawn.has_value(), std::filesystem::exists(folder / "plot.txt"));
}

// gnuplot, if it is installed, waits for a minute here; without it, the error says so.
TEST(Gnuplot, AnErrorTellsThatItTookTooLong) {
  const ScratchFolder scratch;
  const auto drawn = draw_with_gnuplot(scratch.path(), "plot.txt", "pause 60\n", 0.3);
  ASSERT_FALSE(drawn.has_value());
  const std::string& what = drawn.error().what;
  if (what.find("cannot be started") != std::string::npos) GTEST_SKIP() << what;
  EXPECT_NE(what.find("longer than 0.3 s"), std::string::npos) << what;
  EXPECT_NE(what.find((scratch.path() / "plot.txt").string()), std::string::npos) << what;
}

}  // namespace
}  // namespace hapton
