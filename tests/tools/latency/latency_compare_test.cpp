#include "tools/latency/latency_compare.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>

#include "tests/support/one_line.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

nlohmann::ordered_json report(double p50_us, int lost) {
  const auto hop = [](int n, double us) {
    return nlohmann::ordered_json{{"n", n}, {"p50_us", us}, {"p99_us", 2 * us}, {"p99_9_us", 3 * us}, {"max_us", 4 * us}};
  };
  return {{"schema", "hapton.report/4"},
          {"hops", {{"round_trip", hop(100, p50_us)}, {"device_to_drawn", hop(0, 0.0)}}},
          {"ratios", {{"round_trip_over_echo_p50", 1.25}}},
          {"rates_hz", {{"samples", 1000.0}}},
          {"counters", {{"lost", lost}, {"samples", 10'000}}}};
}

TEST(LatencyCompare, SetsBothRunsAndTheirRatioSideBySide) {
  const auto json = compare_json(report(20.0, 0), report(30.0, 4));
  EXPECT_EQ(json["hops"]["round_trip"]["p50_us"]["a"], 20.0);
  EXPECT_EQ(json["hops"]["round_trip"]["p50_us"]["b"], 30.0);
  EXPECT_EQ(json["hops"]["round_trip"]["max_us"]["ratio"], 1.5);
  EXPECT_FALSE(json["hops"].contains("device_to_drawn"));  // nothing was measured
  EXPECT_EQ(json["ratios"]["round_trip_over_echo_p50"]["ratio"], 1.0);
  EXPECT_EQ(json["counters"]["lost"]["b"], 4.0);
  EXPECT_FALSE(json["counters"]["lost"].contains("ratio"));  // there is no ratio to zero
  EXPECT_FALSE(json["counters"].contains("samples"));        // the same in both
  const std::string text = compare_text(report(20.0, 0), report(30.0, 4));
  EXPECT_THAT(text, HasSubstr("round_trip             20.00     30.00    1.50"));
  EXPECT_THAT(text, HasSubstr("lost"));
}

TEST(LatencyCompare, ReadsAFolderOrAFileAndNothingElse) {
  const ScratchFolder folder;
  folder.write("report.json", report(20.0, 0).dump());
  folder.write("other.json", "{\"schema\": \"hapton.report/9\", \"hops\": {}}");
  folder.write("text.json", "hello");
  EXPECT_TRUE(read_report_json(folder.path()));
  EXPECT_TRUE(read_report_json(folder.path() / "report.json"));
  for (const char* bad : {"other.json", "text.json", "gone.json"}) {
    const auto read = read_report_json(folder.path() / bad);
    ASSERT_FALSE(read) << bad;
    EXPECT_THAT(read.error().what, HasSubstr(bad));
  }
}

TEST(LatencyCompare, AValueOfAnotherTypeIsRejectedInOneLine) {
  const ScratchFolder folder;
  for (const char* bad : {R"({"schema": 1, "hops": {}})", R"({"schema": "hapton.report/4", "hops": []})",
                          R"({"schema": "hapton.report/4", "hops": {"round_trip": 5}})",
                          R"({"schema": "hapton.report/4", "hops": {"round_trip": {"n": "many"}}})",
                          R"({"schema": "hapton.report/4", "hops": {}, "seconds": "long"})",
                          R"({"schema": "hapton.report/3", "hops": {}, "counters": {"late": {}}})",
                          R"({"schema": "hapton.report/4", "hops": {}, "notes": {"reach": 7}})"}) {
    const auto read = read_report_json(folder.write("bad.json", bad));
    ASSERT_FALSE(read) << bad;
    EXPECT_THAT(read.error().what, AllOf(HasSubstr("bad.json: is not a latency report"), IsOneLine())) << bad;
  }
  // A null stands for a ratio that is not finite.
  EXPECT_TRUE(read_report_json(folder.write("good.json", R"({"schema": "hapton.report/4", "hops": {}, "ratios": {"x": null}})")));
}

TEST(LatencyCompare, CountsMayBeLargerThan32Bits) {
  nlohmann::ordered_json a = report(20.0, 0);
  a["hops"]["round_trip"]["n"] = std::int64_t{1} << 32;
  const auto json = compare_json(a, report(30.0, 4));
  ASSERT_TRUE(json["hops"].contains("round_trip"));
  EXPECT_EQ(json["hops"]["round_trip"]["n"].dump(), R"({"a":4294967296,"b":100})");
}

}  // namespace
}  // namespace hapton
