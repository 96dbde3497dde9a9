#include "tools/gnuplot.h"

#include <gtest/gtest.h>

#include <filesystem>

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

}  // namespace
}  // namespace hapton
