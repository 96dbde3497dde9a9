#include "tools/pareto_plot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

namespace hapton {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

const std::vector<ParetoMark> kMarks = {{"bumpy_20k", "proxy point", "", true, 0.4, 0.01},
                                        {"bumpy_20k", "sweep", "32", true, 0.9, 0.3},
                                        {"bumpy_20k", "proxy sphere", "", false, 0.1, 1e-9},
                                        {"car", "smooth", "64", true, 2.0, 0.05}};

TEST(ParetoPlot, HasAPanelForEachMeshAndAMarkForEachFamily) {
  const std::string script = make_pareto_plot(kMarks, "p.png");
  EXPECT_THAT(script, HasSubstr("layout 1,2"));
  EXPECT_THAT(script, HasSubstr("set title 'bumpy 20k'"));
  EXPECT_THAT(script, HasSubstr("set title 'car'"));
  EXPECT_THAT(script, HasSubstr("title 'sweep'"));
  EXPECT_THAT(script, Not(HasSubstr("title 'reference'")));
}

// The sweep is slower and worse than the proxy, and a sphere does not compete: the front of that panel is the point proxy alone.
TEST(ParetoPlot, DrawsTheFront) { EXPECT_THAT(make_pareto_plot(kMarks, "p.png"), HasSubstr("$front0 << EOD\n0.4 1\nEOD")); }

TEST(ParetoPlot, IsDrawnByGnuplot) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "pareto_plot_test";
  std::filesystem::create_directories(folder);
  const auto drawn = draw_pareto_plot(folder, kMarks);
  ASSERT_TRUE(drawn.has_value()) << drawn.error().what;
  EXPECT_GT(std::filesystem::file_size(*drawn), 5000U);
  std::filesystem::remove_all(folder);
}

TEST(ParetoPlot, OfNothingIsAnError) { EXPECT_FALSE(draw_pareto_plot(testing::TempDir(), {}).has_value()); }

}  // namespace
}  // namespace hapton
