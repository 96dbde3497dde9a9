#include "tools/method_flags.h"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <string>

namespace hapton {
namespace {

// The method settings that these words of a command line give. Throws if the parser rejects the words.
Result<MethodSettings> settings_from(const std::string& words) {
  CLI::App app("A program", "program");
  MethodFlags flags;
  add_method_flags(CommandLine(app), flags);
  app.parse(words);
  return settings_of(flags);
}

TEST(MethodFlags, LeftOutAreTheMethodsOwn) {
  const auto settings = settings_from("");
  ASSERT_TRUE(settings) << settings.error().what;
  EXPECT_DOUBLE_EQ(settings->offset_m, MethodSettings{}.offset_m);
  EXPECT_EQ(settings->grid_division, MethodSettings{}.grid_division);
  EXPECT_EQ(settings->name, MethodSettings{}.name);
}

TEST(MethodFlags, SetTheSweepsGridAndOffset) {
  const auto settings = settings_from("--method sweep --grid 4x3x2 --offset-in 0.01");
  ASSERT_TRUE(settings) << settings.error().what;
  EXPECT_EQ(settings->grid_division, (std::array<int, 3>{4, 3, 2}));
  EXPECT_DOUBLE_EQ(settings->offset_m, 0.000254);
}

TEST(MethodFlags, RejectUnknownSettings) {
  EXPECT_THROW(settings_from("--offset-in 0"), CLI::ValidationError);
  EXPECT_THROW(settings_from("--probe-radius -1"), CLI::ValidationError);
  EXPECT_FALSE(settings_from("--grid 0"));
  EXPECT_FALSE(settings_from("--simplify soon"));
}

}  // namespace
}  // namespace hapton
