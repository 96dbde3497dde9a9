// hapton demo, as a person or a script starts it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>

#include "tests/process/program.h"

namespace hapton::process {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(Demo, ListsItsSteps) {
  const TestFolder folder;
  const auto ended = run("hapton", {"demo", "--list"}, folder.path());
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->exit_code, 0) << ended->err;
  EXPECT_THAT(ended->out,
              AllOf(HasSubstr("1  rest on the car\n"), HasSubstr("2  slide in a groove\n"), HasSubstr("3  a wall thinner than a step\n"),
                    HasSubstr("4  a heavy mesh\n"), HasSubstr("5  a slow network\n"), HasSubstr("6  a node dies\n")));
}

TEST(Demo, RejectsWhatItCannotDoInALine) {
  const TestFolder folder;
  struct Case {
    std::vector<std::string> words;
    int code;
    const char* says;
  };
  for (const Case& c : {Case{{"--only", "7"}, 2, "--only"},
                        {{"--only", "0"}, 2, "--only"},
                        {{"--only", "2", "--seconds", "0.1"}, 2, "--seconds"},
                        {{"--headles"}, 2, "did you mean '--headless'?"},
                        {{"--headless", "--out", "/dev/null/there"}, 2, "--out"},
                        {{"1"}, 2, "1"},
                        {{}, 1, "--headless"}}) {
    std::vector<std::string> words = {"demo"};
    words.insert(words.end(), c.words.begin(), c.words.end());
    const auto ended = run("hapton", words, folder.path());
    ASSERT_TRUE(ended) << ::testing::PrintToString(words);
    EXPECT_EQ(ended->exit_code, c.code) << ended->err;
    EXPECT_THAT(ended->err, HasSubstr(c.says));
    EXPECT_EQ(std::count(ended->err.begin(), ended->err.end(), '\n'), 1) << ended->err;
  }
}

#ifdef HAPTON_WITH_VISION

bool is_png(const std::filesystem::path& path) { return read_text(path).starts_with("\x89PNG"); }

class DemoStep : public ::testing::TestWithParam<std::pair<std::string, std::string>> {};

TEST_P(DemoStep, ShowsWhatItPromisesAndLeavesAPictureAndALine) {
  const TestFolder folder;
  const auto& [number, name] = GetParam();
  // On a machine that stops now and then, 4 s may be too short.
  std::optional<Ended> ended;
  for (const char* seconds : {"4", "16"}) {
    ended = run("hapton", {"demo", "--headless", "--only", number, "--seconds", seconds, "--out", (folder.path() / "tour").string()},
                folder.path(), 4 * kPatience);
    ASSERT_TRUE(ended) << "still runs";
    if (ended->exit_code == 0) break;
  }
  EXPECT_EQ(ended->exit_code, 0) << ended->out << ended->err;
  EXPECT_THAT(ended->out, AllOf(HasSubstr(number + " "), HasSubstr(": shown; in contact ")));
  EXPECT_TRUE(is_png(folder.path() / "tour" / (number + "-" + name + ".png")));
  EXPECT_THAT(ended->out, HasSubstr(read_text(folder.path() / "tour" / "demo.txt")));
  EXPECT_FALSE(read_text(folder.path() / "tour" / (number + "-" + name) / "report.json").empty());
}

INSTANTIATE_TEST_SUITE_P(Tour, DemoStep,
                         ::testing::Values(std::pair("2", "slide-in-a-groove"), std::pair("3", "a-wall-thinner-than-a-step"),
                                           std::pair("6", "a-node-dies")));

// A haptics node that reports that it is ready, and then never replies.
TEST(Demo, AStepThatFailsIsReportedAndCounts) {
  const TestFolder folder;
  const std::filesystem::path bin = folder.path() / "bin";
  std::filesystem::create_directories(bin);
  // hapton is copied, because it looks for the other programs beside itself.
  std::filesystem::copy(HAPTON_BIN_DIR "/hapton", bin / "hapton");
  for (const char* name : {"io_node", "vision_node", "hapton_watchdog"}) {
    std::filesystem::create_symlink(std::filesystem::path(HAPTON_BIN_DIR) / name, bin / name);
  }
  std::ofstream(bin / "haptics_node") << "#!/bin/sh\ntrap 'exit 0' TERM\necho ready\nwhile :; do sleep 0.1; done\n";
  std::filesystem::permissions(bin / "haptics_node", std::filesystem::perms::owner_all);
  std::filesystem::create_directories(folder.path() / "share" / "hapton");
  for (const char* name : {"scenes", "meshes"}) {
    std::filesystem::create_directory_symlink(std::filesystem::path(HAPTON_SOURCE_DIR) / name, folder.path() / "share" / "hapton" / name);
  }
  const std::filesystem::path out = folder.path() / "tour";
  const auto ended = run((bin / "hapton").string(), {"demo", "--headless", "--only", "2", "--seconds", "4", "--out", out.string()},
                         folder.path(), 4 * kPatience);
  ASSERT_TRUE(ended) << "still runs";
  EXPECT_EQ(ended->exit_code, 1) << ended->out << ended->err;
  EXPECT_THAT(ended->out, HasSubstr("2 slide in a groove: NOT SHOWN; touched nothing"));
  EXPECT_TRUE(is_png(out / "2-slide-in-a-groove.png")) << "of what there is";
}

// Without a terminal in which keys can be pressed, the demo continues by the clock.
TEST(Demo, RunsInAWindowByTheClock) {
  const TestFolder folder;
  const VirtualDisplay display;
  Program tour("hapton", {"demo", "--only", "3", "--seconds", "4"}, folder.path(), display.name());
  const auto ended = tour.wait(4 * kPatience);
  ASSERT_TRUE(ended) << "still runs";
  EXPECT_EQ(ended->exit_code, 0) << ended->err;
  EXPECT_THAT(ended->out, HasSubstr("3  a wall thinner than a step\nThe wall is 0.1 mm thick"));
}

// Ctrl-C, the stop of a service and the close of a terminal send these signals.
class DemoStop : public ::testing::TestWithParam<int> {};

TEST_P(DemoStop, EndsItsNodesAndSaysSo) {
  const TestFolder folder;
  const std::filesystem::path out = folder.path() / "tour" / "2-slide-in-a-groove";
  Program tour("hapton", {"demo", "--headless", "--only", "2", "--seconds", "300", "--out", (folder.path() / "tour").string()},
               folder.path());
  const auto has_hub = [&] { return read_text(out / "io_node.log").find("hub on ") != std::string::npos; };
  for (int i = 0; i < 600 && !has_hub() && tour.is_running(); ++i) (void)tour.wait(Seconds(0.05));
  EXPECT_TRUE(has_hub()) << tour.err();
  tour.send_signal(GetParam());
  const auto ended = tour.wait(2 * kPatience);
  ASSERT_TRUE(ended) << "still runs";
  EXPECT_EQ(ended->exit_code, 1);
  EXPECT_THAT(ended->err, HasSubstr("stopped"));
  EXPECT_FALSE(read_text(out / "report.json").empty()) << "io_node ended in order";
}

INSTANTIATE_TEST_SUITE_P(Signals, DemoStop, ::testing::Values(SIGINT, SIGTERM, SIGHUP));

#endif

}  // namespace
}  // namespace hapton::process
