#include "runtime/config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>
#include <vector>

#include "core/base/result.h"

namespace hapton {
namespace {

using testing::HasSubstr;

class ConfigTest : public testing::Test {
 protected:
  ConfigTest() {
    app_.add_option("-r,--rate", rate_, "Hz")->check(CLI::Range(250.0, 10'000.0));
    app_.add_option("--name", name_);
    app_.add_option("--gains", gains_);
    app_.add_flag("--headless", headless_);
    app_.add_option("--count", count_);
  }
  ~ConfigTest() override { std::filesystem::remove(path_); }

  // Writes a configuration file with this text; returns its path.
  std::string config_file(const std::string& text) {
    std::ofstream(path_) << text;
    return path_.string();
  }

  // The exit code, or -1 to continue; the text on stderr is in error_.
  int parse(std::vector<std::string> arguments) {
    std::vector<const char*> argv = {"/some/where/io_node"};
    for (const std::string& argument : arguments) {
      argv.push_back(argument.c_str());
    }
    testing::internal::CaptureStderr();
    testing::internal::CaptureStdout();
    const std::optional<int> exit_code = parse_command_line(app_, static_cast<int>(argv.size()), argv.data());
    output_ = testing::internal::GetCapturedStdout();
    error_ = testing::internal::GetCapturedStderr();
    return exit_code.value_or(-1);
  }

  void expect_one_error(const std::string& part) {
    EXPECT_THAT(error_, testing::StartsWith("io_node: "));
    EXPECT_THAT(error_, HasSubstr(part));
    EXPECT_EQ(error_.find('\n'), error_.size() - 1) << error_;
    EXPECT_THAT(error_, testing::Not(HasSubstr(" \n")));
  }

  std::filesystem::path path_ = std::filesystem::temp_directory_path() / fmt::format("hapton_config_{}.toml", getpid());
  CLI::App app_{"A node"};
  double rate_ = 1000.0;
  std::string name_ = "default";
  std::vector<double> gains_;
  bool headless_ = false;
  int count_ = 0;
  std::string output_;
  std::string error_;
};

TEST_F(ConfigTest, WithoutAFileTheCommandLineAloneCounts) {
  EXPECT_EQ(parse({"--rate", "500", "--headless"}), -1);
  EXPECT_EQ(rate_, 500.0);
  EXPECT_TRUE(headless_);
}

TEST_F(ConfigTest, ReadsEveryKindOfValue) {
  EXPECT_EQ(parse({"--config", config_file("rate = 2500.5\nname = \"a b = c\"\ngains = [1, -2.5, 3]\nheadless = true\ncount = -7\n")}), -1)
      << error_;
  EXPECT_EQ(rate_, 2500.5);
  EXPECT_EQ(name_, "a b = c");
  EXPECT_EQ(gains_, (std::vector<double>{1, -2.5, 3}));
  EXPECT_TRUE(headless_);
  EXPECT_EQ(count_, -7);
}

TEST_F(ConfigTest, FalseLeavesAFlagOff) {
  headless_ = true;
  EXPECT_EQ(parse({"--config=" + config_file("headless = false\n")}), -1) << error_;
  EXPECT_FALSE(headless_);
}

TEST_F(ConfigTest, AnEmptyTextIsAValue) {
  EXPECT_EQ(parse({"--config", config_file("name = \"\"\n")}), -1) << error_;
  EXPECT_EQ(name_, "");
}

TEST_F(ConfigTest, TheCommandLineWins) {
  const std::string config = config_file("rate = 2000\nname = \"file\"\ngains = [1]\n");
  EXPECT_EQ(parse({"-r", "3000", "--config", config, "--name=line"}), -1) << error_;
  EXPECT_EQ(rate_, 3000.0);
  EXPECT_EQ(name_, "line");
  EXPECT_EQ(gains_, std::vector<double>{1});
}

TEST_F(ConfigTest, NamesAnUnknownKeyWithFileAndLine) {
  EXPECT_EQ(parse({"--config", config_file("rate = 2000\n\nraet = 1\n")}), 2);
  expect_one_error(path_.string() + ":3: unknown key 'raet'; did you mean 'rate'?");
}

TEST_F(ConfigTest, NamesTheFlagThatWasMeant) {
  EXPECT_EQ(parse({"--raet", "500"}), 2);
  expect_one_error("; did you mean '--rate'?; see io_node --help");
  EXPECT_EQ(parse({"--headles"}), 2);
  expect_one_error("did you mean '--headless'?");
  EXPECT_EQ(parse({"--gaisn=3"}), 2);
  expect_one_error("did you mean '--gains'?");
  EXPECT_EQ(parse({"--zzzzzz"}), 2);
  expect_one_error("--zzzzzz; see io_node --help");
}

TEST_F(ConfigTest, NamesTheFlagOfACommandThatWasMeant) {
  CLI::App* command = app_.add_subcommand("replay");
  std::string out;
  command->add_option_group("what is written")->add_option("--out", out);
  EXPECT_EQ(parse({"replay", "--ott", "x"}), 2);
  expect_one_error("did you mean '--out'?");
}

TEST_F(ConfigTest, NamesASyntaxErrorWithItsLine) {
  EXPECT_EQ(parse({"--config", config_file("rate = 2000\nname = \"open\n")}), 2);
  expect_one_error(path_.string() + ":2: ");
}

TEST_F(ConfigTest, RejectsSectionsAndDates) {
  EXPECT_EQ(parse({"--config", config_file("[rate]\nvalue = 3\n")}), 2);
  expect_one_error(":1: 'rate' is not a text, number, true or false");
  EXPECT_EQ(parse({"--config", config_file("rate = 2020-01-01\n")}), 2);
  expect_one_error(":1: 'rate' is not a text");
  EXPECT_EQ(parse({"--config", config_file("gains = [1, [2]]\n")}), 2);
  expect_one_error("an element of 'gains'");
}

// An empty list once counted as the flag without a value.
TEST_F(ConfigTest, AnEmptyListSwitchesNothingOn) {
  EXPECT_EQ(parse({"--config", config_file("rate = 2000\nheadless = []\n")}), 2);
  expect_one_error(path_.string() + ":2: 'headless' is an empty list");
  EXPECT_FALSE(headless_);
  EXPECT_EQ(parse({"--config", config_file("gains = []\n")}), 2);
  expect_one_error(path_.string() + ":1: 'gains' is an empty list");
  EXPECT_EQ(parse({"--headless", "--config", config_file("headless = []\n")}), -1) << "the command line wins";
}

TEST_F(ConfigTest, AFileMayNotNameAnother) {
  EXPECT_EQ(parse({"--config", config_file("config = \"x\"\n")}), 2);
  expect_one_error("unknown key 'config'");
}

TEST_F(ConfigTest, WhatFollowsTheEndOfTheFlagsIsNoFlag) {
  std::vector<std::string> files;
  app_.add_option("files", files);
  EXPECT_EQ(parse({"--config", config_file("rate = 2000\n"), "--", "--config", "none.toml"}), -1) << error_;
  EXPECT_EQ(rate_, 2000.0);
  EXPECT_EQ(files, (std::vector<std::string>{"--config", "none.toml"}));
}

TEST_F(ConfigTest, AMissingFileOrAFolderIsAnError) {
  EXPECT_EQ(parse({"--config", "/no/such/file.toml"}), 2);
  expect_one_error("/no/such/file.toml: cannot be read");
  EXPECT_EQ(parse({"--config", "/tmp"}), 2);
  expect_one_error("/tmp: cannot be read");
}

// As from a script with a variable that is not set: without an error, the limits in the file would be missing.
TEST_F(ConfigTest, AnEmptyNameOfTheFileIsAnError) {
  for (const std::vector<std::string>& words : {std::vector<std::string>{"--config", ""}, {"--config=", "--rate", "500"}}) {
    EXPECT_EQ(parse(words), 2);
    expect_one_error("--config is empty");
  }
}

TEST_F(ConfigTest, ABadValueOfTheFileNamesTheFile) {
  EXPECT_EQ(parse({"--config", config_file("rate = 5\n")}), 2);
  expect_one_error("--rate");
  EXPECT_THAT(error_, HasSubstr("(from " + path_.string() + ")"));
  EXPECT_EQ(parse({"--config", config_file("count = \"many\"\n")}), 2);
  expect_one_error("--count");
}

TEST_F(ConfigTest, ABadCommandLineIsOneLineAndExitCodeTwo) {
  EXPECT_EQ(parse({"--rate", "5"}), 2);
  expect_one_error("--rate");
  EXPECT_THAT(error_, testing::Not(HasSubstr("(from")));
  EXPECT_EQ(parse({"--no-such-flag"}), 2);
  expect_one_error("--no-such-flag");
  EXPECT_EQ(parse({"--config"}), 2);
  expect_one_error("--config");
}

// CLI11 reads 010 as 8, and -1 as the largest number if the flag takes unsigned numbers.
TEST_F(ConfigTest, AWholeNumberIsNeverTakenForAnother) {
  std::uint64_t seed = 5;
  app_.add_option("--seed", seed);
  EXPECT_EQ(parse({"--count", "010"}), 2);
  expect_one_error("--count: 010 begins with a zero");
  EXPECT_EQ(parse({"--seed=-1"}), 2);
  expect_one_error("--seed: -1");
  EXPECT_EQ(parse({"--seed", "18446744073709551616"}), 2);
  expect_one_error("--seed: 18446744073709551616");
  EXPECT_EQ(parse({"--count=-3", "--seed", "0x10"}), -1);
  EXPECT_EQ(count_, -3);
  EXPECT_EQ(seed, 16U);
}

TEST_F(ConfigTest, VersionIsOneLineOnStdoutAndNoKeyOfAFile) {
  EXPECT_EQ(parse({"--version"}), 0);
  EXPECT_THAT(output_, testing::MatchesRegex("io_node [0-9]+\\.[0-9]+\\.[0-9]+\n"));
  EXPECT_EQ(error_, "");
  EXPECT_EQ(parse({"--config", config_file("version = true\n")}), 2);
  expect_one_error("unknown key 'version'");
}

TEST_F(ConfigTest, HelpGoesToStdoutAndEndsWell) {
  EXPECT_EQ(parse({"--help"}), 0);
  EXPECT_THAT(output_, HasSubstr("--config"));
  EXPECT_THAT(output_, HasSubstr("--rate"));
  EXPECT_EQ(error_, "");
}

}  // namespace
}  // namespace hapton
