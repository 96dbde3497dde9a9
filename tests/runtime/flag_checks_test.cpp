#include "runtime/flag_checks.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "core/base/result.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

// Empty if the text is accepted.
std::string rejection(const CLI::Validator& check, std::string text) { return check(text); }

TEST(FlagChecks, RejectWhatIsNotAWholeNumberOfTheType) {
  const CLI::Validator seed = whole_number<std::uint64_t>();
  for (const char* good : {"0", "7", "0x10", "18446744073709551615", "abc", "nan"}) EXPECT_EQ(rejection(seed, good), "") << good;
  const std::string advice = "; give a whole number from 0 to 18446744073709551615";
  EXPECT_EQ(rejection(seed, "-1"), "-1 is out of range" + advice);
  EXPECT_EQ(rejection(seed, "99999999999999999999"), "99999999999999999999 is out of range" + advice);
  EXPECT_EQ(rejection(seed, "0x1ffffffffffffffff"), "0x1ffffffffffffffff is out of range" + advice);
  EXPECT_EQ(rejection(seed, "1e9"), "1e9 is not a whole number in digits" + advice);
  EXPECT_EQ(rejection(seed, "010"), "010 begins with a zero" + advice + ", without it");
  const CLI::Validator cpu = whole_number<int>();
  for (const char* good : {"-1", "+3", "-2147483648", "2147483647"}) EXPECT_EQ(rejection(cpu, good), "") << good;
  EXPECT_EQ(rejection(cpu, "-2147483649"), "-2147483649 is out of range; give a whole number from -2147483648 to 2147483647");
}

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

TEST(FlagChecks, TakeFoldersAndFilesThatCanBeWritten) {
  const ScratchFolder scratch;
  const std::string made = (scratch.path() / "deep" / "made").string();
  EXPECT_EQ(rejection(folder_to_write(), scratch.path().string()), "");
  EXPECT_EQ(rejection(folder_to_write(), made), "");
  EXPECT_EQ(rejection(file_to_write(), (scratch.path() / "file").string()), "");
  EXPECT_NE(rejection(folder_to_write(), "/proc/nowhere").find("/proc"), std::string::npos);
  EXPECT_NE(rejection(file_to_write(), "/proc/nowhere/file").find("/proc"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(scratch.path() / "deep")) << "a check makes nothing";
}

TEST(FlagChecks, AcceptsWhatAParserAcceptsAndGivesItsError) {
  const CLI::Validator only_two = accepts([](const std::string& text) -> Result<int> {
    if (text == "2") return 2;
    return fail("'{}' is not two", text);
  });
  EXPECT_EQ(rejection(only_two, "2"), "");
  EXPECT_EQ(rejection(only_two, "3"), "'3' is not two");
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
