#include "runtime/report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

namespace hapton {
namespace {

using testing::HasSubstr;

LatencyReport sample_report() {
  LatencyReport report;
  report.program = "io_node";
  report.machine = read_machine_info();
  report.seconds = 2.5;
  report.rates_hz = {{"servo", 999.5}};
  report.counters = {{"force_lost", 3}, {"samples", 2500}};
  report.ratios = {{"round_trip_over_echo_p50", 1.25}};
  report.notes = {{"seed", "42"}, {"scene", "a \"quoted\" name"}};
  report.nodes = {{"haptics", "10.0.0.2:4444", 2.0, 2000, 3, 1, 0, 2003, 0}};
  LatencyHistogram round_trip;
  for (int i = 1; i <= 1000; ++i) {
    round_trip.record(i * 1000);
  }
  report.hops.push_back({"force_round_trip", round_trip});
  report.hops.push_back({"empty", {}});
  return report;
}

TEST(ReportTest, JsonHoldsEveryFigure) {
  const nlohmann::json json = nlohmann::json::parse(to_json(sample_report()));
  EXPECT_EQ(json["schema"], "hapton.report/4");
  EXPECT_EQ(json["program"], "io_node");
  EXPECT_EQ(json["seconds"], 2.5);
  EXPECT_EQ(json["rates_hz"]["servo"], 999.5);
  EXPECT_EQ(json["counters"]["force_lost"], 3);
  EXPECT_EQ(json["ratios"]["round_trip_over_echo_p50"], 1.25);
  EXPECT_EQ(json["notes"]["scene"], "a \"quoted\" name");
  ASSERT_EQ(json["nodes"].size(), 1U);
  EXPECT_EQ(json["nodes"][0]["role"], "haptics");
  EXPECT_EQ(json["nodes"][0]["lost"], 3);
  const nlohmann::json& hop = json["hops"]["force_round_trip"];
  EXPECT_EQ(hop["n"], 1000);
  EXPECT_NEAR(hop["p50_us"].get<double>(), 500.0, 5.0);
  EXPECT_NEAR(hop["p90_us"].get<double>(), 900.0, 9.0);
  EXPECT_NEAR(hop["p99_us"].get<double>(), 990.0, 10.0);
  EXPECT_NEAR(hop["p99_9_us"].get<double>(), 999.0, 10.0);
  EXPECT_EQ(hop["max_us"], 1000.0);
  EXPECT_NEAR(hop["mean_us"].get<double>(), 500.5, 1e-9);
  EXPECT_EQ(json["hops"]["empty"]["n"], 0);
}

TEST(ReportTest, NamesTheMachine) {
  const MachineInfo machine = read_machine_info();
  std::stringstream cpuinfo;
  cpuinfo << std::ifstream("/proc/cpuinfo").rdbuf();
  const bool is_named = cpuinfo.str().find("model name\t: ") != std::string::npos;
  EXPECT_EQ(machine.cpu != "unknown", is_named);
  if (is_named) {
    EXPECT_NE(cpuinfo.str().find("model name\t: " + machine.cpu + "\n"), std::string::npos) << machine.cpu;
  }
  EXPECT_GE(machine.cpu_count, 1);
  EXPECT_THAT(machine.kernel, HasSubstr("Linux"));
  EXPECT_THAT(machine.compiler, testing::AnyOf(HasSubstr("g++"), HasSubstr("clang")));
}

TEST(ReportTest, BytesThatAreNoTextDoNotBreakIt) {
  LatencyReport report = sample_report();
  report.notes["device"] = "\xFF\xFE";
  EXPECT_EQ(nlohmann::json::parse(to_json(report))["schema"], kReportSchema);
}

TEST(ReportTest, CsvRowsAddUpToTheRecords) {
  std::istringstream csv(to_csv(sample_report()));
  std::string line;
  std::getline(csv, line);
  EXPECT_EQ(line, "hop,lower_ns,upper_ns,count");
  std::uint64_t total = 0;
  std::int64_t last_upper = 0;
  while (std::getline(csv, line)) {
    long long lower = 0;
    long long upper = 0;
    unsigned long long count = 0;
    ASSERT_EQ(std::sscanf(line.c_str(), "force_round_trip,%lld,%lld,%llu", &lower, &upper, &count), 3) << line;
    EXPECT_GE(lower, last_upper);
    EXPECT_GT(upper, lower);
    last_upper = upper;
    total += count;
  }
  EXPECT_EQ(total, 1000U);
}

TEST(ReportTest, WritesBothFilesOrSaysWhyNot) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / fmt::format("hapton_report_{}", getpid());
  ASSERT_TRUE(write_report(sample_report(), folder / "out"));
  std::ifstream json(folder / "out" / "report.json");
  EXPECT_EQ(nlohmann::json::parse(json)["program"], "io_node");
  EXPECT_TRUE(std::filesystem::exists(folder / "out" / "latency.csv"));

  const Result<void> rejected = write_report(sample_report(), folder / "out" / "report.json" / "below");
  ASSERT_FALSE(rejected);
  EXPECT_THAT(rejected.error().what, HasSubstr("cannot write"));
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace hapton
