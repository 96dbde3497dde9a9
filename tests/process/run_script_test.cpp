// Runs deploy/run, and starts and stops it as a person does.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <regex>
#include <string>
#include <vector>

#include "tests/process/program.h"

#ifdef HAPTON_WITH_VISION

namespace hapton::process {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// Far longer than a run takes on a busy machine, where it may need a minute; kPatience is longer with a sanitizer.
constexpr Seconds kRunPatience = 3 * kPatience;

class RunScript : public ::testing::Test {
 protected:
  Program start(const std::vector<std::string>& more, const std::string& display = "") {
    std::vector<std::string> words = {"--bin", HAPTON_BIN_DIR};
    if (std::find(more.begin(), more.end(), "--out") == more.end()) words.insert(words.end(), {"--out", out().string()});
    words.insert(words.end(), more.begin(), more.end());
    return Program(HAPTON_SOURCE_DIR "/deploy/run", words, folder_.path(), display);
  }
  // Runs for 5 s. If nothing was touched, as on a machine that stood still, runs once more for 20 s.
  std::optional<Ended> run_headless(const std::vector<std::string>& more) {
    std::optional<Ended> ended;
    for (const char* seconds : {"5", "20"}) {
      std::vector<std::string> words = {"--headless", "--seconds", seconds};
      words.insert(words.end(), more.begin(), more.end());
      Program script = start(words);
      ended = script.wait(kRunPatience);
      if (!ended || ended->out.find("\nrun: touched ") != std::string::npos) break;
    }
    return ended;
  }
  // Waits until the script says that all nodes have been started and that something is touched.
  static bool wait_until_touching(Program& run) {
    for (int i = 0; i < 1200 && run.out().find("run: touching") == std::string::npos && run.is_running(); ++i)
      (void)run.wait(Seconds(0.05));
    return run.out().find("run: touching") != std::string::npos;
  }
  std::filesystem::path out() const { return folder_.path() / "out"; }
  bool has(const char* file) const { return std::filesystem::exists(out() / file); }

  TestFolder folder_;
};

TEST_F(RunScript, EndsWithThreeLinesOnWhatWasTouchedWhetherItHeldAndWhereTheFilesAre) {
  Program run = start({"--headless", "--seconds", "3"});
  const auto ended = run.wait(kRunPatience);
  ASSERT_TRUE(ended) << "still runs";
  EXPECT_EQ(ended->exit_code, 0) << ended->out << ended->err;
  EXPECT_THAT(ended->out, HasSubstr("\nrun: touched "));
  EXPECT_THAT(ended->out, HasSubstr("\nrun: it "));
  EXPECT_THAT(ended->out, HasSubstr("\nrun: files are in " + out().string()));
  EXPECT_THAT(ended->out, Not(HasSubstr("wake_lateness"))) << "statistics are for --verbose";
  EXPECT_LE(std::count(ended->out.begin(), ended->out.end(), '\n'), 6);
  EXPECT_TRUE(has("report.json") && has("latency.png") && has("stereo.png"));
}

TEST_F(RunScript, ChoosesTheCpusByMeasurementIfAskedTo) {
  const auto ended = run_headless({"--choose-cpus"});
  ASSERT_TRUE(ended) << "still runs";
  EXPECT_EQ(ended->exit_code, 0) << ended->out << ended->err;
  EXPECT_TRUE(ended->out.find("run: io_node and haptics_node share CPU ") != std::string::npos ||
              ended->out.find("run: io_node has CPU ") != std::string::npos ||
              ended->out.find("run: nothing was measured") != std::string::npos)
      << ended->out;
}

// Ctrl-C reaches only the script, because each node runs in a process session of its own.
TEST_F(RunScript, StoppedBySignalsBeforeItsTimeStillSumsUpAndSaysSo) {
  for (const int signal : {SIGINT, SIGTERM}) {
    Program run = start({"--headless", "--seconds", "200"});
    ASSERT_TRUE(wait_until_touching(run)) << run.out() << run.err();
    (void)run.wait(Seconds(3));
    run.send_signal(signal);
    const auto ended = run.wait(kRunPatience);
    ASSERT_TRUE(ended) << "still runs";
    EXPECT_EQ(ended->exit_code, 130) << ended->out << ended->err;
    EXPECT_THAT(ended->out, HasSubstr("\nrun: touched "));
    EXPECT_THAT(ended->err, HasSubstr("stopped before the 200 s were over"));
    EXPECT_THAT(ended->err, Not(HasSubstr("unbound")));
    EXPECT_TRUE(has("report.json") && has("latency.png"));
  }
}

// The mesh lies far from the origin, and its numbers are millimetres: unless it is fitted to the workspace, the device never reaches it.
TEST_F(RunScript, TouchesAMeshInAnyUnitAndItsRecordingReplays) {
  const std::string mesh = HAPTON_SOURCE_DIR "/meshes/wingnut.obj";
  for (const char* unit : {"m", "mm", "in"}) {
    const std::string recording = (folder_.path() / unit).string() + ".hapton";
    const auto ended = run_headless({"--scene", mesh, "--unit", unit, "--record", recording});
    ASSERT_TRUE(ended) << "still runs";
    EXPECT_EQ(ended->exit_code, 0) << ended->out << ended->err;
    EXPECT_THAT(ended->out, HasSubstr("\nrun: touched " + mesh));
    const auto replayed = run("hapton", {"session", "replay", recording}, folder_.path());
    ASSERT_TRUE(replayed);
    EXPECT_EQ(replayed->exit_code, 0) << replayed->out << replayed->err;
  }
}

// Two pins far apart: a hand that does not know their position touches nothing for a long time.
TEST_F(RunScript, TouchesASmallThingThatLiesAside) {
  const std::filesystem::path mesh = folder_.path() / "pins.obj";
  std::ofstream file(mesh);
  for (const double x : {-1.0, 1.0}) file << "v " << x << " 0.4 0\nv " << x + 0.02 << " 0.4 0\nv " << x << " 0.42 0\n";
  file << "f 1 2 3\nf 4 5 6\n";
  file.close();
  const auto ended = run_headless({"--scene", mesh.string()});
  ASSERT_TRUE(ended) << "still runs";
  EXPECT_EQ(ended->exit_code, 0) << ended->out << ended->err;
  EXPECT_THAT(ended->out, HasSubstr("\nrun: touched " + mesh.string()));
}

TEST_F(RunScript, RejectsAtOnceWhatItCouldNotWriteAtTheEnd) {
  std::ofstream(folder_.path() / "file") << "in the way";
  const auto ended = start({"--headless", "--out", (folder_.path() / "file").string()}).wait(Seconds(20));
  ASSERT_TRUE(ended) << "still runs";
  EXPECT_EQ(ended->exit_code, 1);
  EXPECT_THAT(ended->err, HasSubstr("cannot be written"));
}

TEST_F(RunScript, NamesTheOptionThatWasMeant) {
  const auto ended = start({"--sceen", "x"}).wait(Seconds(20));
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->exit_code, 2);
  EXPECT_THAT(ended->err, HasSubstr("did you mean --scene?"));
}

TEST_F(RunScript, WithoutATimeIsStoppedBySignalsAsItShouldBe) {
  const VirtualDisplay display;
  Program run = start({}, display.name());
  ASSERT_TRUE(wait_until_touching(run)) << run.out() << run.err();
  (void)run.wait(Seconds(3));
  run.send_signal(SIGINT);
  const auto ended = run.wait(kRunPatience);
  ASSERT_TRUE(ended) << "still runs";
  EXPECT_EQ(ended->exit_code, 0) << ended->out << ended->err;
  EXPECT_THAT(ended->out, HasSubstr("\nrun: touched "));
  EXPECT_TRUE(has("report.json") && has("latency.png"));
}

// The current folder of the process that has all of these words on its command line; empty if there is no such process.
std::filesystem::path find_folder_of(const std::vector<std::string>& words) {
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    std::ifstream file(entry.path() / "cmdline");
    const std::string line{std::istreambuf_iterator<char>(file), {}};
    if (!std::ranges::all_of(words, [&](const std::string& word) { return line.find(word) != std::string::npos; })) continue;
    std::error_code error;
    if (auto folder = std::filesystem::read_symlink(entry.path() / "cwd", error); !error) return folder;
  }
  return {};
}

// Screenshots, saved annotations and exports that the keys of vision_node make go to the current folder.
TEST_F(RunScript, TheWindowRunsInTheFolderWhereItWasCalled) {
  Program script("/usr/bin/env",
                 {"--chdir=" + folder_.path().string(), HAPTON_SOURCE_DIR "/deploy/run", "--bin", HAPTON_BIN_DIR, "--out", out().string(),
                  "--headless", "--seconds", "200"},
                 folder_.path());
  ASSERT_TRUE(wait_until_touching(script)) << script.out() << script.err();
  const std::vector<std::string> words = {"bin/vision_node", (out() / "stereo.png").string()};
  const auto called_from = std::filesystem::canonical(folder_.path());
  // The window is started through several programs; the last of them sets the folder.
  for (int i = 0; i < 200 && find_folder_of(words) != called_from; ++i) (void)script.wait(Seconds(0.05));
  EXPECT_EQ(find_folder_of(words), called_from);
  script.send_signal(SIGINT);
  ASSERT_TRUE(script.wait(kRunPatience)) << "still runs";
}

TEST_F(RunScript, SaysHowOtherProgramsJoin) {
  Program script = start({"--headless", "--seconds", "200", "--scene", HAPTON_SOURCE_DIR "/scenes/lift.toml"});
  ASSERT_TRUE(wait_until_touching(script)) << script.out() << script.err();
  std::smatch found;
  std::string printed;
  for (int i = 0; i < 1200 && found.empty(); ++i) {
    printed = script.out();
    if (!std::regex_search(printed, found, std::regex("run: other programs join with --hub (\\S+) --key (\\S+) .*\n")))
      (void)script.wait(Seconds(0.05));
  }
  ASSERT_FALSE(found.empty()) << printed;
  const std::string hub = found[1], key = found[2];
  // The nodes may still be starting.
  std::optional<Ended> moved;
  for (int i = 0; i < 20 && (!moved || moved->exit_code != 0); ++i)
    moved = run("hapton", {"move", "platform", "--to", "-0.05,-0.005,0", "--hub", hub, "--key", key}, folder_.path());
  ASSERT_TRUE(moved);
  EXPECT_EQ(moved->exit_code, 0) << moved->err;
  script.send_signal(SIGINT);
  ASSERT_TRUE(script.wait(kRunPatience)) << "still runs";
  EXPECT_FALSE(std::filesystem::exists(key)) << "the key of a run goes with it";
}

// The real programs, but in place of vision_node a script that runs on for 12 s after the window has closed, as if it wrote its files.
class LateWindow : public RunScript {
 protected:
  LateWindow() {
    const std::filesystem::path programs = HAPTON_BIN_DIR;
    std::filesystem::create_directory(bin());
    for (const auto& entry : std::filesystem::directory_iterator(programs)) {
      if (entry.path().filename() != "vision_node") std::filesystem::create_symlink(entry.path(), bin() / entry.path().filename());
    }
    std::ofstream(bin() / "vision_node") << "#!/bin/bash\n\"" << (programs / "vision_node").string() << "\" \"$@\" &\npid=$!\n"
                                         << "trap 'kill -TERM $pid; wait $pid; code=$?; for i in {1..120}; do sleep 0.1; done; touch \""
                                         << finished().string() << "\"; exit $code' TERM\nwait $pid\n";
    std::filesystem::permissions(bin() / "vision_node", std::filesystem::perms::owner_all);
  }
  Program start_late() {
    return Program(HAPTON_SOURCE_DIR "/deploy/run", {"--bin", bin().string(), "--headless", "--seconds", "3", "--out", out().string()},
                   folder_.path());
  }
  static bool wait_until_waiting(Program& run) {
    for (int i = 0; i < 1200 && run.err().find("run: waiting for vision_node") == std::string::npos && run.is_running(); ++i)
      (void)run.wait(Seconds(0.05));
    return run.is_running();
  }
  std::filesystem::path bin() const { return folder_.path() / "bin"; }
  std::filesystem::path finished() const { return folder_.path() / "finished"; }
};

TEST_F(LateWindow, IsWaitedForUntilItHasFinished) {
  Program run = start_late();
  ASSERT_TRUE(wait_until_waiting(run)) << run.out() << run.err();
  const auto ended = run.wait(kRunPatience);
  ASSERT_TRUE(ended) << "still runs";
  EXPECT_EQ(ended->exit_code, 0) << ended->out << ended->err;
  EXPECT_THAT(ended->err, HasSubstr("Ctrl-C ends it at once"));
  EXPECT_TRUE(std::filesystem::exists(finished()));
}

TEST_F(LateWindow, IsEndedAtOnceByASignal) {
  Program run = start_late();
  ASSERT_TRUE(wait_until_waiting(run)) << run.out() << run.err();
  run.send_signal(SIGINT);
  const auto ended = run.wait(kRunPatience);
  ASSERT_TRUE(ended) << "still runs";
  EXPECT_EQ(ended->exit_code, 1) << ended->out << ended->err;
  EXPECT_THAT(ended->err, HasSubstr("vision_node ended with exit code 137"));
  EXPECT_FALSE(std::filesystem::exists(finished()));
}

}  // namespace
}  // namespace hapton::process

#endif
