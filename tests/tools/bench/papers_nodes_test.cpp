#include "tools/bench/papers_nodes.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include <filesystem>

namespace hapton {
namespace {

// The folder of this test program contains no nodes, like a build without them: no row has a value, and each says why.
TEST(MeasurePaperNodes, ARowWithoutItsNodeSaysWhy) {
  const auto folder = std::filesystem::temp_directory_path() / ("hapton_papers_" + std::to_string(::getpid()));
  PapersReport report = make_papers_report();
  measure_paper_nodes(
      {.out = folder, .scene = std::filesystem::path(HAPTON_SOURCE_DIR) / "scenes" / "car_front.toml", .frames = 2, .seconds = 0.5},
      report);
  for (const auto key : {kStereoCulled, kStereoUnculled, kRoundTrip, kSystemLatency}) {
    EXPECT_FALSE(report.row(key).ours) << key;
    EXPECT_TRUE(report.row(key).how.starts_with("could not be measured: ")) << key << ": " << report.row(key).how;
    EXPECT_GT(report.row(key).how.size(), 30U) << key;
  }
  EXPECT_FALSE(report.is_complete());
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace hapton
