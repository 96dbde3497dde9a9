#include "runtime/log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace hapton {
namespace {

std::string lines_of(LogLevel lowest, void (*write_lines)()) {
  testing::internal::CaptureStderr();
  start_log("io_node", lowest);
  write_lines();
  return testing::internal::GetCapturedStderr();
}

TEST(LogTest, ALineHasTimeProgramLevelAndText) {
  const std::string line = lines_of(LogLevel::info, [] { log_warning("peer {} is silent", 3); });
  EXPECT_THAT(line, testing::MatchesRegex("[0-9]+:[0-9]+:[0-9]+\\.[0-9]+ io_node  warning  peer 3 is silent\n"));
}

TEST(LogTest, LevelsBelowTheLowestAreLeftOut) {
  EXPECT_EQ(lines_of(LogLevel::warning,
                     [] {
                       log_info("no");
                       log_debug("no");
                     }),
            "");
  EXPECT_THAT(lines_of(LogLevel::debug, [] { log_debug("fine"); }), testing::HasSubstr("debug  fine"));
  EXPECT_THAT(lines_of(LogLevel::error, [] { log_error("bad"); }), testing::HasSubstr("error  bad"));
}

TEST(LogTest, TextIsNotTakenForAFormat) {
  EXPECT_THAT(lines_of(LogLevel::info, [] { log_info("{}", "{} %n {x"); }), testing::HasSubstr("{} %n {x"));
}

}  // namespace
}  // namespace hapton
