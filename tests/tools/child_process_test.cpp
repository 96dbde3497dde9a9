#include "tools/child_process.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <fstream>
#include <sstream>

namespace hapton {
namespace {

std::filesystem::path scratch_file(const std::string& name) {
  return std::filesystem::temp_directory_path() / ("hapton_child_" + std::to_string(::getpid()) + "_" + name);
}

std::string read_and_remove(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::stringstream text;
  text << file.rdbuf();
  std::filesystem::remove(path);
  return text.str();
}

TEST(ChildProcess, GivesTheExitCode) {
  auto child = ChildProcess::start({.program = "sh", .arguments = {"-c", "exit 7"}, .folder = {}, .output = {}});
  ASSERT_TRUE(child);
  EXPECT_EQ(child->wait(30.0), 7);
  EXPECT_EQ(child->wait(0.0), 7);
  EXPECT_EQ(child->stop(), 7);
}

TEST(ChildProcess, ArgumentsArriveAsTheyAre) {
  const auto out = scratch_file("out");
  auto child =
      ChildProcess::start({.program = "printf", .arguments = {"%s|", "a b", "$HOME", "'; exit 3", "*"}, .folder = "/", .output = out});
  ASSERT_TRUE(child);
  EXPECT_EQ(child->wait(30.0), 0);
  EXPECT_EQ(read_and_remove(out), "a b|$HOME|'; exit 3|*|");
}

TEST(ChildProcess, RunsInItsFolder) {
  const auto out = scratch_file("pwd");
  auto child = ChildProcess::start({.program = "pwd", .arguments = {}, .folder = "/usr", .output = out});
  ASSERT_TRUE(child);
  EXPECT_EQ(child->wait(30.0), 0);
  EXPECT_EQ(read_and_remove(out), "/usr\n");
}

TEST(ChildProcess, StopsWhatWouldGoOn) {
  auto child = ChildProcess::start({.program = "sleep", .arguments = {"100"}, .folder = {}, .output = {}});
  ASSERT_TRUE(child);
  EXPECT_EQ(child->wait(0.05), std::nullopt);
  EXPECT_EQ(child->stop(), 128 + SIGTERM);
}

TEST(ChildProcess, KillsWhatWillNotStop) {
  const auto out = scratch_file("deaf");
  auto child = ChildProcess::start(
      {.program = "sh", .arguments = {"-c", "trap '' TERM; echo on; while :; do sleep 0.05; done"}, .folder = {}, .output = out});
  ASSERT_TRUE(child);
  while (!std::filesystem::exists(out) || std::filesystem::file_size(out) == 0) {
    ASSERT_EQ(child->wait(0.01), std::nullopt);
  }
  EXPECT_EQ(child->stop(0.2), 128 + SIGKILL);
  std::filesystem::remove(out);
}

TEST(ChildProcess, AMissingProgramIsNamed) {
  const auto child = ChildProcess::start({.program = "no_such_program_here", .arguments = {}, .folder = {}, .output = {}});
  ASSERT_FALSE(child);
  EXPECT_THAT(child.error().what, ::testing::HasSubstr("no_such_program_here"));
}

TEST(ChildProcess, FindsItsOwnFolder) {
  EXPECT_TRUE(find_own_folder().is_absolute());
  EXPECT_TRUE(std::filesystem::exists(find_own_folder() / program_invocation_short_name));
}

}  // namespace
}  // namespace hapton
