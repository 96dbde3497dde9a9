#include "tools/latency/latency_plot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include <cstdlib>
#include <fstream>

#include "tests/support/one_line.h"

namespace hapton {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

const std::vector<HopCounts> kHops = {{"round_trip", {{10000, 11000, 5}, {20000, 22000, 5}}}, {"bare_echo", {{8000, 9000, 10}}}};

// A folder whose name would do harm in a shell, with a table in it.
class LatencyPlotTest : public ::testing::Test {
 protected:
  LatencyPlotTest() : folder_(std::filesystem::temp_directory_path() / ("hapton plot'; touch injected #" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(folder_);
    std::ofstream(folder_ / "latency.csv") << "hop,lower_ns,upper_ns,count\nround_trip,10000,11000,5\nround_trip,20000,22000,5\n"
                                              "bare_echo,8000,9000,10\n";
  }
  ~LatencyPlotTest() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path folder_;
};

TEST(LatencyPlot, CurvesAreSharesOfSlowerSamplesInMicroseconds) {
  const std::string script = make_latency_plot(kHops, "p.png");
  EXPECT_THAT(script, HasSubstr("<< EOD\n10 1\n11 0.5\n22 0.5\nEOD\n"));
  EXPECT_THAT(script, HasSubstr("<< EOD\n8 1\n9 1\nEOD\n"));
  EXPECT_THAT(script, HasSubstr("set output 'p.png'"));
  EXPECT_THAT(script, HasSubstr("round trip  (p50 10.5, p99 21 us, n 10)"));
  EXPECT_THAT(script, HasSubstr("set xrange [1:100]"));
  EXPECT_THAT(script, HasSubstr("set yrange [0.1:1]"));
  // The first and the last bucket decide the ends of one axis, and all samples that of the other.
  EXPECT_THAT(make_latency_plot(std::vector<HopCounts>{{"round_trip", {{90'000, 110'000, 5}, {200'000, 2'200'000, 96}}}}, "p.png"),
              AllOf(HasSubstr("set xrange [10:10000]"), HasSubstr("set yrange [0.001:1]")));
}

TEST_F(LatencyPlotTest, DrawsAPng) {
  const auto picture = draw_latency_plot(folder_);
  if (!picture && picture.error().what.find("gnuplot-nox") != std::string::npos) {
    GTEST_SKIP() << picture.error().what;
  }
  ASSERT_TRUE(picture) << picture.error().what;
  EXPECT_EQ(*picture, folder_ / "latency.png");
  std::ifstream file(*picture, std::ios::binary);
  std::string head(8, '\0');
  file.read(head.data(), 8);
  EXPECT_EQ(head, "\x89PNG\r\n\x1a\n");
  EXPECT_GT(std::filesystem::file_size(*picture), 5000U);
  std::size_t files = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder_)) {
    ++files;
  }
  EXPECT_EQ(files, 2U);  // the table and the picture, nothing left over
  EXPECT_FALSE(std::filesystem::exists("injected"));
}

TEST_F(LatencyPlotTest, WithoutGnuplotOneLineSaysWhatToInstall) {
  const std::string path = std::getenv("PATH");
  ::setenv("PATH", folder_.c_str(), 1);
  const auto picture = draw_latency_plot(folder_);
  ::setenv("PATH", path.c_str(), 1);
  ASSERT_FALSE(picture);
  EXPECT_THAT(picture.error().what, HasSubstr("gnuplot-nox"));
  EXPECT_EQ(picture.error().what.find('\n'), std::string::npos);
}

TEST_F(LatencyPlotTest, WithoutATableOneLineSaysWhereItShouldBe) {
  std::filesystem::remove(folder_ / "latency.csv");
  const auto picture = draw_latency_plot(folder_);
  ASSERT_FALSE(picture);
  EXPECT_THAT(picture.error().what, AllOf(HasSubstr("latency.csv"), IsOneLine()));
}

}  // namespace
}  // namespace hapton
