#include "tools/bench/sixdof_plot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

SixdofRow plot_row(const std::string& name, const std::string& method, double ns, double percent) {
  SixdofRow row;
  row.name = name;
  row.method = method;
  row.has_errors = true;
  row.contact.count = 10;
  row.contact.p50_ns = ns;
  row.force_error_percent = percent;
  return row;
}

const std::vector<SixdofRow> kToolRows = {plot_row("box on plane", "proxy", 5e4, 0.01), plot_row("box on plane", "voxels, 1 mm", 9e4, 12.0),
                                          plot_row("gear pair", "proxy", 2e5, 0.0)};

TEST(SixdofPlot, HasAPanelForEachScenarioAndAMarkForEachMethod) {
  const std::string script = make_sixdof_plot(kToolRows, "p.png");
  EXPECT_THAT(script, HasSubstr("layout 1,2"));
  EXPECT_THAT(script, HasSubstr("set title 'gear pair'"));
  EXPECT_THAT(script, HasSubstr("title 'voxels, 1 mm'"));
  EXPECT_THAT(script, HasSubstr("\n50 0.01\ne\n90 12\ne\n"));
  EXPECT_THAT(script, HasSubstr("\n200 0.0001\ne\ne\n")) << "an error of nothing is drawn at the bottom, a missing mark not at all";
}

// With all methods that the command compares. Those that compute only a force take less than a microsecond.
TEST(SixdofPlot, ShowsEachMethodByAMarkOfItsOwnAndTheFastestOne) {
  std::vector<SixdofRow> rows;
  for (const char* method : {"proxy", "force", "force, 5 ms", "voxels, 1 mm", "voxels, 0.5 mm", "voxels, 0.25 mm", "bullet", "fcl"}) {
    rows.push_back(plot_row("box on plane", method, 800.0, 1.0));
  }
  const std::string script = make_sixdof_plot(rows, "p.png");
  EXPECT_THAT(script, HasSubstr("set xrange [0.1:"));
  std::set<std::string> marks;
  std::set<std::string> colours;
  const auto word_after = [&](const std::string& key, std::size_t from) {
    const std::size_t begin = script.find(key, from) + key.size();
    return script.substr(begin, script.find(' ', begin) - begin);
  };
  for (std::size_t at = script.find("pointtype"); at != std::string::npos; at = script.find("pointtype", at + 1)) {
    marks.insert(word_after("pointtype ", at));
    colours.insert(word_after("linecolor rgb ", at));
  }
  EXPECT_EQ(marks.size(), rows.size());
  EXPECT_EQ(colours.size(), rows.size());
}

TEST(SixdofPlot, LeavesOutWhatHasNoKnownForce) {
  std::vector<SixdofRow> rows = kToolRows;
  rows.push_back(plot_row("peg", "proxy", 1e5, 0.0));
  rows.back().has_errors = false;
  EXPECT_THAT(make_sixdof_plot(rows, "p.png"), Not(HasSubstr("peg")));
}

TEST(SixdofPlot, IsDrawn) {
  const ScratchFolder folder;
  const auto picture = draw_sixdof_plot(folder.path(), kToolRows);
  ASSERT_TRUE(picture) << picture.error().what;
  EXPECT_GT(std::filesystem::file_size(*picture), 5000U);
  const auto none = draw_sixdof_plot(folder.path(), {});
  ASSERT_FALSE(none);
  EXPECT_THAT(none.error().what, HasSubstr("nothing to draw"));
}

}  // namespace
}  // namespace hapton
