#include "tools/soak/soak_plot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

const std::vector<std::string> kNodes = {"haptics_node", "io_node"};
const SoakSample kSample = {.seconds = 2.0, .samples_hz = 1000.0, .round_trip_max_us = 90.0, .processes = {{2000, 9, 3}, {1000, 12, 2}}};

TEST(SoakPlot, ARowHasAsManyColumnsAsTheHeader) {
  const std::string header = soak_csv_header(kNodes);
  const std::string row = soak_csv_row(kSample);
  EXPECT_EQ(std::count(header.begin(), header.end(), ','), std::count(row.begin(), row.end(), ','));
  EXPECT_THAT(header, HasSubstr(",io_node_resident_kib,io_node_descriptors,io_node_threads\n"));
  EXPECT_THAT(row, StartsWith("2.000,1000.00,"));
  EXPECT_THAT(row, HasSubstr(",2000,9,3,1000,12,2\n"));
}

TEST(SoakPlot, EachFigureOfARowIsUnderItsName) {
  const SoakSample sample = {.seconds = 1.0,
                             .samples_hz = 2.0,
                             .forces_hz = 3.0,
                             .contacts_hz = 4.0,
                             .drawn_hz = 5.0,
                             .lost = 6,
                             .late = 7,
                             .superseded = 8,
                             .missed_cycles = 9,
                             .round_trip_p50_us = 10.0,
                             .round_trip_p99_us = 11.0,
                             .round_trip_max_us = 12.0,
                             .drift_ms = -13.0,
                             .processes = {{.resident_kib = 14, .descriptors = 15, .threads = 16}}};
  EXPECT_EQ(soak_csv_header({"io_node"}),
            "t_s,samples_hz,forces_hz,contacts_hz,drawn_hz,lost,late,superseded,missed_cycles,round_trip_p50_us,round_trip_p99_us,"
            "round_trip_max_us,drift_ms,io_node_resident_kib,io_node_descriptors,io_node_threads\n");
  EXPECT_EQ(soak_csv_row(sample), "1.000,2.00,3.00,4.00,5.00,6,7,8,9,10.00,11.00,12.00,-13.000,14,15,16\n");
}

TEST(SoakPlot, IsDrawnFromTheTable) {
  const ScratchFolder folder;
  SoakSample later = kSample;
  later.seconds = 4.0;
  folder.write("soak.csv", soak_csv_header(kNodes) + soak_csv_row(kSample) + soak_csv_row(later));
  const auto picture = draw_soak_plot(folder.path(), kNodes);
  if (!picture && picture.error().what.find("gnuplot-nox") != std::string::npos) GTEST_SKIP() << picture.error().what;
  ASSERT_TRUE(picture) << picture.error().what;
  std::ifstream file(*picture, std::ios::binary);
  std::string head(4, '\0');
  file.read(head.data(), 4);
  EXPECT_EQ(head, "\x89PNG");
}

}  // namespace
}  // namespace hapton
