#include "bench/papers/papers_report.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

namespace hapton {
namespace {

PapersReport make_filled_report() {
  PapersReport report = make_papers_report();
  for (PaperRow& row : report.rows) row.ours = 2.0;
  return report;
}

// The numbers as printed in the papers: a change here must be checked against the paper.
TEST(PapersReport, HoldsBothPapersFigures) {
  PapersReport report = make_papers_report();
  const std::pair<const char*, double> figures[] = {
      {"memo.grid_occupied", 25.0},    {"memo.grid_mean", 3.0},  {"memo.grid_max", 23.0},       {"memo.force_rate_grid", 1000.0},
      {"memo.force_rate_all", 1000.0}, {"memo.haptons", 1.0},    {"memo.haptons_capable", 5.0}, {"memo.stereo_culled", 20.0},
      {"memo.stereo_unculled", 8.0},   {"memo.round_trip", 0.7}, {"memo.system_latency", 50.0}, {"fdh.query_typical", 3.0},
      {"fdh.query_most", 10.0},        {"fdh.idle_3khz", 50.0},  {"fdh.rate", 10000.0}};
  for (const auto& [key, value] : figures) EXPECT_DOUBLE_EQ(report.row(key).paper_value.value_or(-1.0), value) << key;
  std::set<std::string> keys;
  for (const PaperRow& row : report.rows) EXPECT_TRUE(keys.insert(row.key).second) << row.key;
}

TEST(PapersReport, ARowWithoutAValueMakesItIncomplete) {
  PapersReport report = make_papers_report();
  EXPECT_FALSE(report.is_complete());
  report = make_filled_report();
  EXPECT_TRUE(report.is_complete());
  report.row(kStereoCulled).ours.reset();
  report.row(kStereoCulled).how = "could not be measured: vision_node is not built";
  EXPECT_FALSE(report.is_complete());
  EXPECT_NE(to_text(report).find("vision_node is not built"), std::string::npos);
  report.leave_out_nodes();
  EXPECT_TRUE(report.is_complete()) << "rows that were not requested are not missing";
}

TEST(PapersReport, TheRatioIsOursOverTheirs) {
  PaperRow row;
  row.paper_value = 0.7;
  EXPECT_FALSE(row.ratio());
  row.ours = 0.07;
  EXPECT_NEAR(row.ratio().value_or(0.0), 0.1, 1e-12);
  row.paper_value.reset();
  EXPECT_FALSE(row.ratio());
}

// Counts the fields: commas within quotes do not separate, and a quote in a field is doubled.
std::size_t count_fields(const std::string& line) {
  bool is_quoted = false;
  std::size_t fields = 1;
  for (const char c : line) {
    if (c == '"') is_quoted = !is_quoted;
    if (c == ',' && !is_quoted) ++fields;
  }
  return fields;
}

TEST(PapersReport, TextCsvAndJsonSayTheSame) {
  PapersReport report = make_filled_report();
  report.row(kRoundTrip).ours = 0.0315;
  report.row(kRoundTrip).how = "p50, \"sealed\", over loopback";
  report.tasks.emplace_back().rate_hz = 3000.0;
  report.tasks.back().busy_mean_ns = 3333.0;
  report.hulls.emplace_back().directions = 14;
  const auto json = nlohmann::json::parse(to_json(report));
  EXPECT_EQ(json["rows"].size(), report.rows.size());
  EXPECT_TRUE(json["complete"].get<bool>());
  bool is_found = false;
  for (const auto& row : json["rows"]) {
    if (row["key"] != std::string(kRoundTrip)) continue;
    is_found = true;
    EXPECT_DOUBLE_EQ(row["ours"].get<double>(), 0.0315);
    EXPECT_NEAR(row["ours_over_paper"].get<double>(), 0.045, 1e-12);
  }
  EXPECT_TRUE(is_found);
  EXPECT_NEAR(json["tasks"][0]["idle_share"].get<double>(), 1.0 - 3333e-9 * 3000.0, 1e-12);
  const std::string text = to_text(report);
  EXPECT_NE(text.find("0.0315 ms"), std::string::npos) << text;
  EXPECT_NE(text.find("0.045"), std::string::npos);
  for (const std::string& csv : {to_csv(report), tasks_csv(report), hulls_csv(report)}) {
    std::istringstream lines(csv);
    std::string header;
    std::getline(lines, header);
    std::size_t rows = 0;
    for (std::string line; std::getline(lines, line); ++rows) EXPECT_EQ(count_fields(line), count_fields(header)) << line;
    EXPECT_GT(rows, 0U);
  }
}

TEST(ParseBenchRate, ReadsVisionNodesLine) {
  const std::string line = "bench: 200 frames, 47.3 Hz, side_by_side, 640x720 an eye, drawing p50 20.1 ms p99 25.0 ms, llvmpipe";
  EXPECT_DOUBLE_EQ(parse_bench_rate("log\n" + line + "\n").value_or(0.0), 47.3);
  for (const char* none : {"", "bench: ", "bench: 200 frames, ", "bench: 200 frames, fast", "bench: 200 frames, 0.0 Hz", "47.3 Hz"}) {
    EXPECT_FALSE(parse_bench_rate(none)) << none;
  }
}

}  // namespace
}  // namespace hapton
