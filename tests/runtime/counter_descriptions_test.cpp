#include "runtime/counter_descriptions.h"

#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <regex>
#include <string>

#include "runtime/prometheus_text.h"

namespace hapton {
namespace {

std::map<std::string, std::string> read_documented_counters() {
  static const std::regex row(R"(\| `([a-z0-9_]+)` \| (.+) \|)");
  std::map<std::string, std::string> counters;
  std::ifstream file(HAPTON_SOURCE_DIR "/docs/counters.md");
  std::smatch match;
  for (std::string line; std::getline(file, line);) {
    if (!std::regex_match(line, match, row)) continue;
    EXPECT_TRUE(counters.emplace(match[1], match[2]).second) << "twice: " << line;
  }
  return counters;
}

TEST(CounterDescriptions, AreThoseOfTheDocumentation) {
  std::map<std::string, std::string> described;
  for (const auto& [name, text] : counter_descriptions()) EXPECT_TRUE(described.emplace(name, text).second) << "twice: " << name;
  EXPECT_GT(described.size(), 80U);
  EXPECT_EQ(described, read_documented_counters());
}

TEST(CounterDescriptions, EachIsOneSentenceInOneLine) {
  for (const auto& [name, text] : counter_descriptions()) {
    EXPECT_TRUE(text.size() > 10 && text.ends_with('.')) << name;
    EXPECT_EQ(text.find_first_of("\n\\`|"), std::string_view::npos) << name << ": neither HELP nor a table can hold that";
  }
}

TEST(CounterDescriptions, AreTheHelpOfTheMetrics) {
  LatencyReport report;
  report.counters = {{"lost", 3}, {"loop_waited_us", 2500}, {"a_new_counter", 1}};
  const std::string text = to_prometheus(report);
  EXPECT_NE(text.find("# HELP hapton_lost_total Samples without a reply although a haptics node was present.\n"), std::string::npos)
      << text;
  EXPECT_NE(text.find("# HELP hapton_loop_waited_seconds_total Time that the servo loop"), std::string::npos) << text;
  EXPECT_NE(text.find("# HELP hapton_a_new_counter_total a_new_counter\n"), std::string::npos) << "no description: its name";
}

}  // namespace
}  // namespace hapton
