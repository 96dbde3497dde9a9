// Whole sessions, recorded, inspected and replayed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "tests/process/system.h"
#include "tests/support/scratch_folder.h"

namespace hapton::process {
namespace {

using ::testing::HasSubstr;

// The recording is kept apart from the folder that the nodes share.
struct Sessions : testing::Test {
  ScratchFolder scratch;
  std::filesystem::path file = scratch.path() / "session.hapton";
  System system{{"--record", file.string()}};

  Ended session(const std::vector<std::string>& words) {
    std::vector<std::string> arguments = {"session"};
    arguments.insert(arguments.end(), words.begin(), words.end());
    return run("hapton", arguments, scratch.path()).value_or(Ended{});
  }

  // Records a session: a contact, a kill of the haptics node during the contact, and a contact after its restart.
  void record() {
    system.start("io_node");
    system.start("haptics_node");
    SessionObserver observer(system);
    ProbeState state;
    ASSERT_TRUE(observer.wait_for_force(state)) << "no contact";
    system["haptics_node"].kill();
    ASSERT_TRUE(observer.wait_for_no_force(state));
    system.start("haptics_node");
    ASSERT_TRUE(observer.wait_for_force(state)) << "no contact after the restart";
    system.end_all();
  }
};

TEST_F(Sessions, EveryForceOfARecordedSessionIsReplayedToTheLastBit) {
  record();
  const Ended replayed = session({"replay", file.string()});
  EXPECT_EQ(replayed.exit_code, 0) << replayed.out << replayed.err;
  EXPECT_THAT(replayed.out, HasSubstr(" 0 different"));

  const Ended text = session({"info", file.string()});
  EXPECT_EQ(text.exit_code, 0) << text.err;
  for (const char* word : {"ForceCommand", "cube.toml", "name=proxy", "late by p50"}) EXPECT_THAT(text.out, HasSubstr(word));

  const Ended exported = session({"export", file.string(), "--out", (scratch.path() / "tables").string()});
  EXPECT_EQ(exported.exit_code, 0) << exported.err;
  EXPECT_THAT(read_text(scratch.path() / "tables/trajectory.csv"), HasSubstr("t_s,x_m,y_m,z_m,qw,qx,qy,qz,sample\n"));
  for (const char* table : {"forces.csv", "cycles.csv"}) EXPECT_GT(read_text(scratch.path() / "tables" / table).size(), 1000U);
  EXPECT_THAT(read_text(scratch.path() / "tables/forces.csv"), HasSubstr(",0,cube,"));
}

TEST_F(Sessions, ABadNetworkAndChangesOfMethodAreReplayedToo) {
  system.start("io_node");
  system.start_relay({"--loss", "0.1", "--jitter-ms", "3", "--reorder", "0.1", "--duplicate", "0.05"});
  system.start("haptics_node");
  SessionObserver observer(system);
  ProbeState state;
  ASSERT_TRUE(observer.wait_for_force(state)) << "no contact";
  for (const char* method : {"smooth", "proxy"}) {
    const auto requested = run("hapton", {"set", "--hub", system.hub(), "--method", method}, system.folder());
    ASSERT_TRUE(requested);
    ASSERT_EQ(requested->exit_code, 0) << requested->err;
    const std::int64_t end_ns = observer.now_ns() + kNanosecondsPerSecond;
    while (observer.now_ns() < end_ns) ASSERT_TRUE(observer.receive_state(state));
  }
  system.end("haptics_node");
  system.end("io_node");
  const Ended replayed = session({"replay", file.string()});
  EXPECT_EQ(replayed.exit_code, 0) << replayed.out << replayed.err;
  EXPECT_THAT(replayed.out, HasSubstr(" 0 different"));
  EXPECT_THAT(replayed.out, HasSubstr("replies were lost: replayed but not compared"));
  EXPECT_THAT(session({"info", file.string()}).out, HasSubstr("name=smooth"));
}

TEST_F(Sessions, MaterialsThatChangeInContactAreReplayedToo) {
  system.start("io_node");
  const auto set = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"set", "--hub", system.hub()});
    return run("hapton", words, system.folder()).value_or(Ended{});
  };
  system.start("haptics_node");
  SessionObserver observer(system);
  ProbeState state;
  ASSERT_TRUE(observer.wait_for_force(state)) << "no contact";
  const auto feel_for_a_second = [&] {
    const std::int64_t end_ns = observer.now_ns() + kNanosecondsPerSecond;
    while (observer.now_ns() < end_ns) ASSERT_TRUE(observer.receive_state(state));
  };
  const Ended all = set({"--stiffness", "400", "--damping", "0.5"});
  EXPECT_EQ(all.exit_code, 0) << all.err;
  EXPECT_THAT(all.out, HasSubstr("material of all objects in use"));
  feel_for_a_second();
  const Ended one = set({"--object", "cube", "--stiffness", "900", "--friction", "0.4"});
  EXPECT_EQ(one.exit_code, 0) << one.err;
  EXPECT_THAT(one.out, HasSubstr("material of 'cube' in use"));
  feel_for_a_second();
  EXPECT_EQ(set({"--method", "reference"}).exit_code, 0);
  feel_for_a_second();
  EXPECT_EQ(set({"--friction-dynamic", "0.1"}).exit_code, 0);
  feel_for_a_second();

  for (const auto& [words, why] : std::vector<std::pair<std::vector<std::string>, std::string>>{
           {{"--object", "cub", "--stiffness", "900"}, "did you mean 'cube'?"},
           {{"--object", "cube", "--friction-dynamic", "0.5"}, "more than 'friction_static' 0.4"}}) {
    const Ended rejected = set(words);
    EXPECT_EQ(rejected.exit_code, 1) << rejected.out;
    EXPECT_THAT(rejected.err, HasSubstr(why));
    EXPECT_EQ(std::count(rejected.err.begin(), rejected.err.end(), '\n'), 1) << rejected.err;
  }
  EXPECT_EQ(set({"--object", "cube"}).exit_code, 2);
  EXPECT_EQ(set({"--stiffness", "2e6"}).exit_code, 2);
  EXPECT_EQ(set({"--friction", "0.3", "--friction-static", "0.3"}).exit_code, 2);
  system.end_all();

  const Ended replayed = session({"replay", file.string()});
  EXPECT_EQ(replayed.exit_code, 0) << replayed.out << replayed.err;
  EXPECT_THAT(replayed.out, HasSubstr(" 0 different"));
  EXPECT_THAT(session({"info", file.string()}).out, HasSubstr("materials changed while running: 3\n"));
}

TEST_F(Sessions, ACutFileGivesWhatIsBeforeTheCut) {
  record();
  const std::string whole = read_text(file);
  const auto cut = scratch.write("cut.hapton", std::string_view(whole).substr(0, whole.size() * 2 / 3));
  const Ended exported = session({"export", cut.string(), "--out", (scratch.path() / "tables").string()});
  EXPECT_EQ(exported.exit_code, 1);
  EXPECT_THAT(exported.err, HasSubstr("is cut short"));
  EXPECT_EQ(std::count(exported.err.begin(), exported.err.end(), '\n'), 1) << exported.err;
  EXPECT_GT(read_text(scratch.path() / "tables/forces.csv").size(), 1000U);
}

TEST_F(Sessions, ARecordingOfANodeThatWasKilledHasNoEndAndIsReadToItsLastEntry) {
  system.start("io_node");
  system.start("haptics_node");
  SessionObserver observer(system);
  ProbeState state;
  ASSERT_TRUE(observer.wait_for_force(state)) << "no contact";
  const std::int64_t end_ns = observer.now_ns() + kNanosecondsPerSecond;
  while (observer.now_ns() < end_ns) ASSERT_TRUE(observer.receive_state(state));
  system["io_node"].kill();
  const Ended replayed = session({"replay", file.string()});
  EXPECT_EQ(replayed.exit_code, 1) << replayed.out;
  EXPECT_THAT(replayed.out, HasSubstr(" 0 different"));
  EXPECT_THAT(replayed.err, HasSubstr("has no end"));
  EXPECT_EQ(std::count(replayed.err.begin(), replayed.err.end(), '\n'), 1) << replayed.err;
}

TEST_F(Sessions, AnotherSceneThanTheRecordedOneIsRejected) {
  record();
  const Ended rejected = session({"replay", file.string(), "--scene", HAPTON_SOURCE_DIR "/meshes/wingnut.obj"});
  EXPECT_EQ(rejected.exit_code, 1);
  EXPECT_THAT(rejected.err, HasSubstr("is not the scene that was recorded"));
}

TEST_F(Sessions, AHapticsNodeKilledInContactLeavesItsLastTwoSeconds) {
  system.start("io_node");
  SessionObserver observer(system);
  ProbeState state;
  const std::filesystem::path flights = system.folder() / "out/flight";
  std::filesystem::path record;
  const auto has_flight_record = [&] {
    std::error_code not_there_yet;
    for (const auto& entry : std::filesystem::directory_iterator(flights, not_there_yet)) {
      if (entry.path().filename().string().ends_with("-command-timeout.hapton")) record = entry.path();
    }
    return !record.empty();
  };
  // No flight record is written for ten seconds after another one, such as that of a machine that stood still: then the test tries again.
  for (int attempt = 0; attempt < 3 && record.empty(); ++attempt) {
    system.start("haptics_node");
    ASSERT_TRUE(observer.wait_for_force(state)) << "no contact";
    system["haptics_node"].kill();
    System::wait_until(has_flight_record);
  }
  ASSERT_FALSE(record.empty());
  const Ended text = session({"info", record.string()});
  EXPECT_EQ(text.exit_code, 0) << text.err;
  EXPECT_THAT(text.out, HasSubstr("flight record: command-timeout"));
  system.end("io_node");
}

// A limit on the size of files takes the place of a full disk; io_node inherits the limit.
TEST(SessionsOnAFullDisk, SayHowMuchIsInTheRecording) {
  const ScratchFolder scratch;
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit lower{64 * 1024, before.rlim_max};
  const auto on_signal = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &lower), 0);
  const auto ended =
      run("io_node", {"--bind", "127.0.0.1:0", "--rt", "off", "--flight", "off", "--seconds", "1.5", "--record", "full.hapton"},
          scratch.path());
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, on_signal);
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->exit_code, 1) << ended->err;
  EXPECT_THAT(ended->err, HasSubstr("recording stopped"));
  EXPECT_THAT(ended->out, ::testing::ContainsRegex("recorded [0-9]+ of [0-9]+ entries"));
}

}  // namespace
}  // namespace hapton::process
