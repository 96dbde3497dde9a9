#include "tools/loop/zwidth_grid.h"

#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "closed_loop/random_stability.h"
#include "tools/loop/measured_latency.h"
#include "tools/loop/zwidth_plot.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

ZWidthGrid small_grid() {
  LoopFlags flags;
  flags.device = "touch,falcon";
  flags.hand = "light,stylus";
  return {.loops = *loops_of(flags), .rates_hz = {1000.0, 4000.0}, .delays_ms = {0.0, 5.0, 50.0}};
}

TEST(ZWidthGrid, EveryCellIsAnotherCombination) {
  const ZWidthGrid grid = small_grid();
  ASSERT_EQ(grid.cells(), 24U);
  std::set<std::string> lines;
  for (std::size_t cell = 0; cell < grid.cells(); ++cell) {
    const std::string line = csv_line(measure_cell(grid, cell));
    EXPECT_TRUE(lines.insert(line.substr(line.find(','))).second) << line;
    const std::string header = csv_header(grid);
    EXPECT_EQ(std::count(line.begin(), line.end(), ','), std::count(header.begin(), header.end(), ',')) << line;
  }
}

TEST(ZWidthGrid, JsonHasInputsAndBothLimits) {
  const ZWidthGrid grid = small_grid();
  const ZWidthRow row = measure_cell(grid, 4);
  const nlohmann::ordered_json json = to_json(row);
  EXPECT_EQ(json["schema"], "hapton.loop.zwidth/2");
  EXPECT_EQ(json["inputs"]["device"], "touch");
  EXPECT_EQ(json["inputs"]["rate_hz"], 4000.0);
  EXPECT_EQ(json["inputs"]["delay_ms"], 5.0);
  EXPECT_EQ(json["stable_stiffness_n_per_m"], row.zwidth.stiffness.value);
  EXPECT_EQ(json["passive_stiffness_n_per_m"], row.zwidth.passive.least_n_per_m());
  EXPECT_GT(row.zwidth.stiffness.value, row.zwidth.passive.least_n_per_m());
}

TEST(ZWidthGrid, OverARandomLinkTheLimitIsSimulated) {
  ZWidthGrid grid = small_grid();
  grid.loops.resize(1);
  grid.rates_hz = {1000.0};
  grid.delays_ms = {5.0};
  const double exact = measure_cell(grid, 0).zwidth.stiffness.value;
  grid.losses = {0.4};
  grid.seed = 7;
  const ZWidthRow row = measure_cell(grid, 0);
  EXPECT_TRUE(row.is_simulated());
  EXPECT_LT(row.zwidth.stiffness.value, exact);
  EXPECT_GT(row.zwidth.stiffness.value, 0.2 * exact);
  EXPECT_THAT(to_json(row)["methods"]["stable"].get<std::string>(), HasSubstr("simulation"));
  EXPECT_EQ(to_json(row)["inputs"]["seed"], 7);
}

// With jitter and loss the force is older than the delay: the passive stiffness and the stable damping must be lower accordingly.
TEST(ZWidthGrid, OverARandomLinkEveryLimitIsOfThatLink) {
  LoopFlags flags;
  flags.device = "falcon";
  ZWidthGrid grid{.loops = *loops_of(flags), .delays_ms = {20.0}, .losses = {0.0, 0.3}};
  const ZWidthRow without_loss = measure_cell(grid, 0);
  const ZWidthRow lossy = measure_cell(grid, 1);
  EXPECT_EQ(without_loss.mean_delay_s, 0.02);
  const double reply_share = 0.7 * 0.7;
  EXPECT_NEAR(lossy.mean_delay_s, 0.02 + 1e-3 * (1.0 - reply_share) / reply_share, 5e-5);
  EXPECT_NEAR(lossy.zwidth.passive.viscous_n_per_m, 1.0 / (0.5e-3 + lossy.mean_delay_s), 1e-3 / lossy.mean_delay_s);
  EXPECT_LT(lossy.zwidth.passive.viscous_n_per_m, 0.97 * without_loss.zwidth.passive.viscous_n_per_m);
  EXPECT_EQ(lossy.zwidth.passive.quantised_n_per_m, without_loss.zwidth.passive.quantised_n_per_m);
  EXPECT_LT(lossy.zwidth.damping_ns_per_m.value, 0.99 * without_loss.zwidth.damping_ns_per_m.value);
  const nlohmann::ordered_json json = to_json(lossy);
  EXPECT_NEAR(json["mean_delay_ms"].get<double>(), 1e3 * lossy.mean_delay_s, 1e-9);
  EXPECT_TRUE(json["stable_mass_kg"].is_null());
  EXPECT_THAT(json["methods"]["passive"].get<std::string>(), HasSubstr("on average"));
  EXPECT_FALSE(to_json(without_loss).contains("mean_delay_ms"));
}

// The passive stiffness of a row is computed for the mean delay, so the row has to state that delay.
TEST(ZWidthGrid, ARowHasTheMeanDelay) {
  LoopFlags flags;
  flags.device = "falcon";
  ZWidthGrid grid{.loops = *loops_of(flags), .delays_ms = {20.0}, .losses = {0.0, 0.3}};
  EXPECT_THAT(csv_header(grid), ::testing::EndsWith(",mean_delay_ms\n"));
  const auto last_field_of = [](const std::string& line) { return line.substr(line.rfind(',') + 1); };
  EXPECT_EQ(last_field_of(csv_line(measure_cell(grid, 0))), "20\n");
  const ZWidthRow lossy = measure_cell(grid, 1);
  EXPECT_DOUBLE_EQ(std::stod(last_field_of(csv_line(lossy))), 1e3 * lossy.mean_delay_s);
  grid.rates_hz = {10.0};
  grid.losses = {0.99};
  EXPECT_EQ(last_field_of(csv_line(measure_cell(grid, 0))), "\n") << "no force came back";
}

// A passive stiffness is stable with any hand, so also without one. The two limits are found in different ways and differ only by chance.
TEST(ZWidthGrid, OverARandomLinkWhatIsPassiveIsStable) {
  LoopFlags flags;
  flags.device = "falcon";
  flags.hand = "off";
  const ZWidthGrid grid{.loops = *loops_of(flags), .delays_ms = {5.0, 50.0}, .jitters_ms = {0.0, 10.0}, .losses = {0.2}};
  for (std::size_t cell = 0; cell < grid.cells(); ++cell) {
    const ZWidthRow row = measure_cell(grid, cell);
    const double passive = row.zwidth.passive.viscous_n_per_m;
    EXPECT_LT(passive, 1.01 * row.zwidth.stiffness.value) << row.delay_ms << " ms, " << row.jitter_ms << " ms";
    EXPECT_GT(passive, 0.9 * row.zwidth.stiffness.value) << row.delay_ms << " ms, " << row.jitter_ms << " ms";
    EXPECT_NEAR(row.zwidth.linear_rule_n_per_m, passive, 0.02 * passive);
  }
}

// 20 s of simulation are only two delays here: that a force has not come back yet must not count as stability.
TEST(ZWidthGrid, ALongDelayIsSimulatedForLonger) {
  LoopFlags flags;
  flags.device = "falcon";
  const ZWidthGrid without_jitter{.loops = *loops_of(flags), .rates_hz = {100.0}, .delays_ms = {9000.0}};
  ZWidthGrid jittered = without_jitter;
  jittered.jitters_ms = {1e-3};
  const double exact = measure_cell(without_jitter, 0).zwidth.stiffness.value;
  EXPECT_NEAR(measure_cell(jittered, 0).zwidth.stiffness.value, exact, 0.02 * exact);
}

// The mean delay is measured over the same time.
TEST(ZWidthGrid, OverALinkWithJitterALoopIsSimulatedForNinetyOfTheLongestDelays) {
  LoopFlags flags;
  flags.device = "falcon";
  const ZWidthGrid grid{.loops = *loops_of(flags), .rates_hz = {100.0}, .delays_ms = {400.0}, .jitters_ms = {200.0}};
  const LinkFaults one_way = {.delay_ns = 200'000'000, .jitter_ns = 200'000'000};
  RandomLoop loop{.period_ns = 10'000'000, .to_law = one_way, .from_law = one_way, .seed = grid.seed};
  const double in_default_time_s = measure_mean_delay_s(loop);
  loop.seconds = 90.0 * 0.8;  // at most 400 ms each way
  EXPECT_EQ(measure_cell(grid, 0).mean_delay_s, measure_mean_delay_s(loop));
  EXPECT_NE(measure_mean_delay_s(loop), in_default_time_s);
}

// There are 200 samples, and only one in ten thousand has a force.
TEST(ZWidthGrid, WhereNoForceComesBackNothingIsKnown) {
  LoopFlags flags;
  flags.device = "touch";
  const ZWidthGrid grid{.loops = *loops_of(flags), .rates_hz = {10.0}, .losses = {0.99}};
  const ZWidthRow row = measure_cell(grid, 0);
  EXPECT_TRUE(std::isnan(row.zwidth.stiffness.value));
  EXPECT_EQ(row.zwidth.passive.least_n_per_m(), 0.0);
  EXPECT_TRUE(to_json(row)["stable_stiffness_n_per_m"].is_null());
}

TEST(ZWidthGrid, ChanceDoesNotMakeAnUndampedLoopStable) {
  LoopFlags flags;
  flags.mass_kg = 0.2;
  flags.damping_ns_per_m = 0.0;
  const ZWidthGrid grid{.loops = *loops_of(flags), .losses = {0.2}};
  EXPECT_EQ(measure_cell(grid, 0).zwidth.stiffness.value, 0.0);
}

TEST(ReadShard, TakesPartsOfAWhole) {
  const auto shard = read_shard("2/3");
  ASSERT_TRUE(shard);
  EXPECT_FALSE(shard->has(0));
  EXPECT_TRUE(shard->has(1));
  EXPECT_TRUE(shard->has(4));
  for (const char* text : {"", "2", "0/3", "4/3", "1/0", "a/b", "1/2/3", "-1/2", "1/2 "}) EXPECT_FALSE(read_shard(text)) << text;
}

class MergeTest : public ::testing::Test {
 protected:
  MergeTest() : folder_(std::filesystem::temp_directory_path() / ("zwidth_" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(folder_);
  }
  ~MergeTest() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
  std::filesystem::path write_shard(const ZWidthGrid& grid, std::size_t index, std::size_t count) const {
    std::string csv = csv_header(grid);
    for (std::size_t cell = 0; cell < grid.cells(); ++cell) {
      if (Shard{index, count}.has(cell)) csv += csv_line(measure_cell(grid, cell));
    }
    return write(std::to_string(index) + "_" + std::to_string(count), csv);
  }

  std::filesystem::path folder_;
};

TEST_F(MergeTest, ShardsInAnyOrderAreTheWholeGrid) {
  const ZWidthGrid grid = small_grid();
  const auto merged = merge_csv({write_shard(grid, 3, 3), write_shard(grid, 1, 3), write_shard(grid, 2, 3)});
  ASSERT_TRUE(merged) << merged.error().what;
  const auto whole = merge_csv({write_shard(grid, 1, 1)});
  ASSERT_TRUE(whole);
  EXPECT_EQ(*merged, *whole);
}

TEST_F(MergeTest, RejectsWhatIsMissingDoubleOrOfAnotherGrid) {
  const ZWidthGrid grid = small_grid();
  ZWidthGrid other = grid;
  other.delays_ms.back() = 60.0;
  const auto first = write_shard(grid, 1, 2);
  ZWidthGrid softer = grid;
  softer.loops.front().device_model.modes[0].stiffness_n_per_m *= 0.5;
  EXPECT_THAT(merge_csv({first, write_shard(softer, 2, 2)}).error().what, HasSubstr("another grid"));
  EXPECT_THAT(merge_csv({first}).error().what, HasSubstr("cell 1 of 24"));
  EXPECT_THAT(merge_csv({first, first}).error().what, HasSubstr("line 3: cell 0 is a duplicate"));
  EXPECT_THAT(merge_csv({first, write_shard(other, 2, 2)}).error().what, HasSubstr("another grid"));
  EXPECT_THAT(merge_csv({write("text", "t_s,x_m\n1,2\n")}).error().what, HasSubstr("not a grid of hapton loop"));
  EXPECT_THAT(merge_csv({write("odd", csv_header(grid) + "x\n")}).error().what, HasSubstr("line 3"));
  EXPECT_THAT(merge_csv({write("far", csv_header(grid) + "24,a\n")}).error().what, HasSubstr("line 3"));
  EXPECT_THAT(merge_csv({folder_ / "none"}).error().what, HasSubstr("cannot be read"));
}

TEST_F(MergeTest, ADamagedNumberOfCellsIsRejectedInOneLine) {
  const ZWidthGrid grid = small_grid();
  const auto with_cells = [&](const std::string& cells) {
    std::string csv = csv_header(grid) + csv_line(measure_cell(grid, 0));
    csv.replace(csv.find("cells=24"), 8, "cells=" + cells);
    return merge_csv({write("damaged", csv)});
  };
  for (const char* cells : {"24000000000000", "18446744073709551615"}) {
    const auto merged = with_cells(cells);
    ASSERT_FALSE(merged) << cells;
    EXPECT_EQ(merged.error().what, fmt::format("cell 1 of {} is in none of the files; is a file missing?", cells));
  }
  for (const char* cells : {"99999999999999999999", "x", ""}) {
    const auto merged = with_cells(cells);
    ASSERT_FALSE(merged) << cells;
    EXPECT_THAT(merged.error().what, HasSubstr("line 1: is not a grid of hapton loop")) << cells;
  }
}

TEST(ZWidthPlot, DrawsACurveForEachLoopAndRate) {
  const ZWidthGrid grid = small_grid();
  std::vector<ZWidthRow> rows;
  for (std::size_t cell = 0; cell < grid.cells(); ++cell) rows.push_back(measure_cell(grid, cell));
  const std::string script = make_zwidth_plot(grid, rows, "z.png.part");
  EXPECT_THAT(script, HasSubstr("touch, hand light, 1000 Hz: stable"));
  EXPECT_THAT(script, HasSubstr("falcon, hand stylus, 4000 Hz: passive"));
  EXPECT_THAT(script, HasSubstr("delay from sample to force, ms"));
  EXPECT_THAT(script, HasSubstr("$curve7 "));
}

TEST(MeasuredLatency, IsTheRoundTripsAtP999) {
  const nlohmann::ordered_json report = {{"hops", {{"round_trip", {{"n", 10}, {"p99_9_us", 250.0}}}}},
                                         {"rates_hz", {{"servo_requested", 2000}}}};
  const auto latency = read_measured_latency(report);
  ASSERT_TRUE(latency);
  EXPECT_DOUBLE_EQ(latency->delay_s, 250e-6);
  EXPECT_EQ(latency->rate_hz, 2000.0);
}

TEST(MeasuredLatency, RejectsAReportWithoutARoundTrip) {
  EXPECT_FALSE(read_measured_latency({}));
  EXPECT_FALSE(read_measured_latency(nlohmann::ordered_json::array()));
  EXPECT_FALSE(read_measured_latency({{"hops", {{"round_trip", {{"p99_9_us", 250.0}}}}}}));
  EXPECT_FALSE(read_measured_latency({{"hops", 3}, {"rates_hz", {{"servo_requested", 2000}}}}));
}

}  // namespace
}  // namespace hapton
