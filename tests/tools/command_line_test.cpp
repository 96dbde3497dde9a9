#include "tools/command_line.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "runtime/config.h"
#include "tools/mesh_choice.h"

namespace hapton {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class CommandLineTest : public testing::Test {
 protected:
  // Empty if the words are accepted, otherwise why they are not.
  std::string rejection(const std::string& words) {
    require_exact_numbers(app_);
    try {
      app_.parse(words);
    } catch (const CLI::ParseError& error) {
      return error.what();
    }
    return {};
  }

  CLI::App app_{"A program", "program"};
  CommandLine line_{app_};
};

TEST_F(CommandLineTest, FillsVariablesOfEveryKind) {
  std::string text;
  std::filesystem::path path;
  int whole = 0;
  double number = 0.0;
  double doubled = 0.0;
  std::optional<double> given;
  std::optional<double> left_out;
  std::vector<std::string> words;
  bool flag = false;
  line_.add_option("WORD", text, "");
  line_.add_option("--path", path, "");
  line_.add_option("--whole", whole, "");
  line_.add_option("--number", number, "");
  line_.add_number(
      "--half", [&](double half) { doubled = 2.0 * half; }, "");
  line_.add_option("--given", given, "");
  line_.add_option("--left-out", left_out, "");
  line_.add_option("--words", words, "").again_for_more();
  line_.add_flag("--flag", flag, "");
  EXPECT_EQ(rejection("w --path a/b --whole -3 --number 2.5 --half 4 --given 7 --words x --words y --flag"), "");
  EXPECT_EQ(text, "w");
  EXPECT_EQ(path, "a/b");
  EXPECT_EQ(whole, -3);
  EXPECT_EQ(number, 2.5);
  EXPECT_EQ(doubled, 8.0);
  EXPECT_EQ(given, 7.0);
  EXPECT_FALSE(left_out);
  EXPECT_THAT(words, ElementsAre("x", "y"));
  EXPECT_TRUE(flag);
}

TEST_F(CommandLineTest, SaysWhatAnOptionTakesWhenItIsRejected) {
  int cpu = 0;
  double share = 0.0;
  double stiffness = 1.0;
  double friction = 0.0;
  std::string mode;
  std::string folder;
  line_.add_option("--cpu", cpu, "").between(-1, 7);
  line_.add_option("--share", share, "").between(0.0, 1.0);
  line_.add_option("--stiffness", stiffness, "").positive();
  line_.add_option("--friction", friction, "").not_negative();
  line_.add_option("--mode", mode, "").one_of({"try", "off"});
  line_.add_option("--folder", folder, "").existing_folder();
  EXPECT_THAT(rejection("--cpu 8"), HasSubstr("--cpu: 8 is out of range; give -1 to 7"));
  EXPECT_THAT(rejection("--share 1.5"), HasSubstr("--share: 1.5 is out of range; give 0 to 1"));
  EXPECT_THAT(rejection("--stiffness 0"), HasSubstr("--stiffness: 0 is not above zero"));
  EXPECT_THAT(rejection("--friction -0.1"), HasSubstr("--friction: -0.1 is below zero"));
  EXPECT_THAT(rejection("--mode maybe"), HasSubstr("{try,off}"));
  EXPECT_THAT(rejection("--folder /no/such/folder"), HasSubstr("/no/such/folder"));
  EXPECT_EQ(rejection("--cpu -1 --share 1 --stiffness 1e-9 --friction 0 --mode off --folder /"), "");
}

TEST_F(CommandLineTest, NeverTakesAWholeNumberForAnother) {
  std::size_t steps = 0;
  std::optional<std::uint64_t> seed;
  line_.add_option("--steps", steps, "");
  line_.add_option("--seed", seed, "");
  EXPECT_THAT(rejection("--steps 99999999999999999999"), HasSubstr("--steps: 99999999999999999999 is out of range"));
  EXPECT_THAT(rejection("--seed=-1"), HasSubstr("--seed: -1 is out of range"));
}

TEST_F(CommandLineTest, HoldsOptionsTogetherAndApart) {
  std::string needed;
  std::string key;
  std::string host;
  std::string own;
  line_.add_option("--needed", needed, "").required();
  const CommandOption hosts = line_.add_option("--host", host, "");
  line_.add_option("--key", key, "").needs(hosts);
  hosts.excludes(line_.add_option("--own", own, ""));
  EXPECT_THAT(rejection(""), HasSubstr("--needed"));
  EXPECT_THAT(rejection("--needed n --key k"), HasSubstr("--host"));
  EXPECT_THAT(rejection("--needed n --host h --own o"), HasSubstr("--own"));
  EXPECT_EQ(rejection("--needed n --host h --key k"), "");
}

TEST_F(CommandLineTest, RequiresAsManyOptionsOfAGroupAsAreSet) {
  std::string mesh;
  std::string shape;
  const CommandLine source = line_.add_group("source").require_options(1, 1);
  source.add_option("--mesh", mesh, "");
  source.add_option("--shape", shape, "");
  EXPECT_NE(rejection(""), "");
  EXPECT_NE(rejection("--mesh m --shape s"), "");
  EXPECT_EQ(rejection("--shape s"), "");
}

TEST_F(CommandLineTest, RequiresAMeshFileOrAShapeAndNotBoth) {
  MeshChoice choice;
  add_mesh_options(line_, choice);
  EXPECT_NE(rejection(""), "");
  EXPECT_NE(rejection("--mesh m.ply --shape torus"), "");
  EXPECT_EQ(rejection("--shape torus"), "");
}

TEST_F(CommandLineTest, ShowsInItsHelpWhatAVariableHolds) {
  double seconds = 12.5;
  line_.add_option("--seconds", seconds, "How long").shows_default();
  EXPECT_THAT(app_.help(), HasSubstr("12.5"));
}

TEST_F(CommandLineTest, RunsTheCommandThatWasGivenAndNoOther) {
  std::string commands_run;
  const CommandLine top = line_.add_subcommand("top", "").require_subcommands(0, 1);
  top.on_run([&] { commands_run += top.has_subcommand() ? "top of below " : "top "; });
  top.add_subcommand("below", "").on_run([&] { commands_run += "below "; });
  line_.add_subcommand("other", "").on_run([&] { commands_run += "other "; });
  EXPECT_EQ(rejection("top"), "");
  EXPECT_EQ(commands_run, "top ");
  EXPECT_EQ(rejection("top below"), "");
  EXPECT_EQ(commands_run, "top below top of below ");
}

}  // namespace
}  // namespace hapton
