#include "runtime/flag_checks.h"

#include <gtest/gtest.h>

#include "core/base/result.h"

namespace hapton {
namespace {

// Empty when the text is taken.
std::string rejection(const CLI::Validator& check, std::string text) { return check(text); }

TEST(FlagChecks, BetweenTakesItsEndsAndNamesThemInShort) {
  const CLI::Validator rate = between(250.0, 10'000.0);
  EXPECT_EQ(rejection(rate, "250"), "");
  EXPECT_EQ(rejection(rate, "1e4"), "");
  EXPECT_EQ(rejection(rate, "249.9"), "249.9 is out of range; give 250 to 10000");
  EXPECT_EQ(rejection(rate, "abc"), "abc is not a number; give 250 to 10000");
  EXPECT_EQ(rejection(rate, "10 Hz"), "10 Hz is not a number; give 250 to 10000");
  EXPECT_NE(rejection(rate, "nan"), "");
  EXPECT_NE(rejection(rate, "inf"), "");
  EXPECT_EQ(rejection(between(0, 1e9), "-1"), "-1 is out of range; give 0 to 1000000000");
}

TEST(FlagChecks, AboveZeroLeavesZeroOut) {
  EXPECT_EQ(rejection(above_zero(), "1e-300"), "");
  EXPECT_EQ(rejection(above_zero(), "0"), "0 is not above zero; give a number above zero");
  EXPECT_EQ(rejection(above_zero("inches"), "-2"), "-2 is not above zero; give inches above zero");
  EXPECT_EQ(rejection(above_zero("inches"), "two"), "two is not a number; give inches above zero");
  EXPECT_NE(rejection(above_zero(), "nan"), "");
}

TEST(FlagChecks, ZeroOrMoreTakesZero) {
  EXPECT_EQ(rejection(zero_or_more(), "0"), "");
  EXPECT_EQ(rejection(zero_or_more("metres"), "-1"), "-1 is below zero; give metres, zero or more");
  EXPECT_EQ(rejection(zero_or_more("metres"), ""), "'' is not a number; give metres, zero or more");
  EXPECT_NE(rejection(zero_or_more(), "nan"), "");
}

TEST(FlagChecks, AcceptsWhatAParserTakesAndSaysWhatItSays) {
  const CLI::Validator even = accepts([](const std::string& text) -> Result<int> {
    if (text == "2") return 2;
    return fail("'{}' is not two", text);
  });
  EXPECT_EQ(rejection(even, "2"), "");
  EXPECT_EQ(rejection(even, "3"), "'3' is not two");
}

TEST(FlagChecks, HelpShowsThemInAWord) {
  CLI::App app;
  double number = 0.5;
  app.add_option("--share", number, "")->check(between(0.0, 1.0));
  app.add_option("--offset", number, "")->check(above_zero());
  app.add_option("--radius", number, "")->check(zero_or_more());
  const std::string help = app.help();
  for (const char* shown : {"FLOAT:[0, 1]", "FLOAT:POSITIVE", "FLOAT:NONNEGATIVE"}) EXPECT_NE(help.find(shown), std::string::npos) << help;
}

}  // namespace
}  // namespace hapton
