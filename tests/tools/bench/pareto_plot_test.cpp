#include "tools/bench/pareto_plot.h"

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

// In panel bumpy 20k the sweep is slower and less accurate than the point proxy, and a sphere does not compete: the front is one mark.
TEST(ParetoPlot, DrawsTheFront) { EXPECT_THAT(make_pareto_plot(kMarks, "p.png"), HasSubstr("$front0 << EOD\n0.4 1\nEOD")); }

TEST(ParetoPlot, LeavesRoomAboveTheTopMarks) { EXPECT_THAT(make_pareto_plot(kMarks, "p.png"), HasSubstr("set yrange [1e-08:1000]")); }

TEST(ParetoPlot, LabelsOfMarksAtOnePositionAreInDifferentLines) {
  const std::vector<ParetoMark> close = {{"car", "sweep", "8", true, 2.0, 0.1}, {"car", "sweep", "16", true, 2.1, 0.1}};
  const std::string script = make_pareto_plot(close, "p.png");
  const auto height_after = [&](const std::string& row) {
    const auto at = script.find(row);
    EXPECT_NE(at, std::string::npos) << script;
    return std::stod(script.substr(at + row.size()));
  };
  const double first = height_after("2 10 \"8\" ");
  EXPECT_GT(first, 10.0);
  EXPECT_GT(height_after("2.1 10 \"16\" "), first);
}

TEST(ParetoPlot, SaysWhereAnErrorOfZeroIsDrawn) {
  EXPECT_THAT(make_pareto_plot(kMarks, "p.png"), Not(HasSubstr("or less")));
  std::vector<ParetoMark> marks = kMarks;
  marks.push_back({"car", "reference", "", true, 100.0, kMinShownError});
  EXPECT_THAT(make_pareto_plot(marks, "p.png"), HasSubstr("drawn here: 1e-10 %, or less"));
}

TEST(ParetoPlot, IsDrawnByGnuplot) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "pareto_plot_test";
  std::filesystem::create_directories(folder);
  const auto drawn = draw_pareto_plot(folder, kMarks);
  ASSERT_TRUE(drawn.has_value()) << drawn.error().what;
  EXPECT_GT(std::filesystem::file_size(*drawn), 5000U);
  std::filesystem::remove_all(folder);
}

TEST(ParetoPlot, WithoutMarksIsAnError) { EXPECT_FALSE(draw_pareto_plot(testing::TempDir(), {}).has_value()); }

}  // namespace
}  // namespace hapton
