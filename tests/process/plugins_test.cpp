// Plug-ins in the real programs: what a person types, what is recorded, and what happens to the force when one misbehaves.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "tests/process/system.h"
#include "tests/standins/paths.h"
#include "tests/support/scratch_folder.h"

namespace hapton::process {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

// A budget so large that no plug-in is cut off because the machine stops now and then.
const std::string kAmpleBudgetUs = "10000";

std::string plugin(const std::string& name) { return standin::library("plugins/" + name + ".so"); }

std::string note_of(const Json& report, const char* name) { return report.at("notes").value(name, ""); }

// Expects that the program prints one line on stderr and does not start.
void expect_one_line(const std::string& program, const std::vector<std::string>& arguments, const std::string& says) {
  const ScratchFolder scratch;
  const auto ended = run(program, arguments, scratch.path());
  ASSERT_TRUE(ended);
  EXPECT_NE(ended->exit_code, 0);
  EXPECT_THAT(ended->err, HasSubstr(says));
  EXPECT_EQ(std::count(ended->err.begin(), ended->err.end(), '\n'), 1) << ended->err;
}

TEST(Plugins, AnInvalidFileIsOneLineAndNoStart) {
  const ScratchFolder scratch;
  const std::string text = scratch.write("text.so", "force = 2 N\n").string();
  expect_one_line("haptics_node", {"--effect", scratch.path() / "gone.so"}, "No such file");
  expect_one_line("haptics_node", {"--effect", text}, "is not a shared library");
  expect_one_line("haptics_node", {"--effect", plugin("nothing")}, "exports no hapton_effect");
  expect_one_line("haptics_node", {"--effect", plugin("old_effect")}, "version 0 of the plug-in interface");
  expect_one_line("haptics_node", {"--effect", plugin("odd_effect") + ":does=reject,n=3"}, "n must be less than 3");
  expect_one_line("haptics_node", {"--effect", plugin("odd_effect") + ":strong"}, "'strong' has no value");
  expect_one_line("haptics_node", {"--effect", plugin("odd_device")}, "io_node --device plugin:FILE");
  expect_one_line("io_node", {"--device", "plugin:" + text}, "is not a shared library");
  expect_one_line("io_node", {"--device", "plugin:" + plugin("odd_device") + ":does=reject"}, "nothing is plugged in");
}

TEST(Plugins, ASceneThatNamesOneIsOneLineAndNoStartUnlessItIsAllowed) {
  const ScratchFolder scratch;
  scratch.write("a.obj", "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nf 1 2 3\n");
  const auto scene = [&](const std::string& name, const std::string& library) {
    return scratch.write(name, "[[object]]\nmesh = 'a.obj'\n[[effect]]\ntype = 'plugin'\nlibrary = '" + library + "'\n").string();
  };
  // One library does not exist, and the other one exports no effect: without the flag neither is looked at.
  expect_one_line("haptics_node", {"--scene", scene("gone.toml", "gone.so")}, "give --allow-plugins if you trust it");
  expect_one_line("haptics_node", {"--scene", scene("none.toml", plugin("nothing"))}, "line 3: effect nothing would run the code of");
  expect_one_line("haptics_node", {"--allow-plugins", "--scene", scene("gone.toml", "gone.so")}, "No such file");
  expect_one_line("haptics_node", {"--allow-plugins", "--scene", scene("none.toml", plugin("nothing"))}, "exports no hapton_effect");
}

// The rows of session.csv: time of the sample, x of the force that haptics wanted (NaN: none came), whether a force was written.
struct Row {
  double t_s;
  double wanted_n;
  bool has_written_force;
};
std::vector<Row> read_rows(const std::filesystem::path& csv) {
  std::istringstream text(read_text(csv));
  std::string line;
  std::getline(text, line);
  std::vector<std::string> names;
  std::istringstream header(line);
  for (std::string name; std::getline(header, name, ',');) names.push_back(name);
  std::vector<Row> rows;
  while (std::getline(text, line)) {
    Row row = {.t_s = 0.0, .wanted_n = std::nan(""), .has_written_force = false};
    std::istringstream cells(line);
    std::string cell;
    for (std::size_t n = 0; n < names.size() && std::getline(cells, cell, ','); ++n) {
      const double value = cell.empty() ? std::nan("") : std::atof(cell.c_str());
      if (names[n] == "t_s") row.t_s = value;
      if (names[n] == "wanted_x_n") row.wanted_n = value;
      if (names[n].starts_with("written_") && names[n].ends_with("_n") && value != 0.0) row.has_written_force = true;
    }
    rows.push_back(row);
  }
  return rows;
}

// The force ends by the rule of the hub: 20 ms after the last sample that got a reply. Each cycle is judged by its own time, so a machine
// that stops changes nothing. Two more cycles may have a force: the one that notices the timeout, and the one that writes zero.
void expect_force_ends(const std::string& does) {
  const ScratchFolder scratch;
  const std::string file = (scratch.path() / "session.hapton").string();
  System system({"--vision-rate", "1000", "--record", file});
  system.add_arguments("haptics_node", {"--effect", plugin("odd_effect") + ":n=1,after=500,does=" + does});
  system.start("io_node");
  system.start("haptics_node");
  SessionObserver observer(system);
  ProbeState state;
  ASSERT_TRUE(observer.wait_for_force(state)) << "no force";
  ASSERT_TRUE(
      System::wait_until([&] { return !system["haptics_node"].is_running() || count(system.request_report(), "command_timeouts") > 0; }));
  ASSERT_TRUE(observer.wait_for_no_force(state)) << "the force goes on";
  const std::uint64_t first = state.sample;
  while (state.sample < first + 200) ASSERT_TRUE(observer.receive_state(state));
  system["haptics_node"].kill();
  system.end("io_node");
  const Ended exported =
      run("hapton", {"session", "export", file, "--format", "csv", "--out", scratch.path() / "table"}, scratch.path()).value_or(Ended{});
  ASSERT_EQ(exported.exit_code, 0) << exported.err;
  const std::vector<Row> rows = read_rows(scratch.path() / "table" / "session.csv");
  const auto last = std::find_if(rows.rbegin(), rows.rend(), [](const Row& row) { return !std::isnan(row.wanted_n); });
  ASSERT_NE(last, rows.rend());
  std::size_t cycles_after_timeout = 0;
  for (const Row& row : rows) {
    if (row.t_s <= last->t_s + 0.02 || ++cycles_after_timeout <= 2) continue;
    EXPECT_FALSE(row.has_written_force) << 1e3 * (row.t_s - last->t_s) << " ms after the last sample that got a reply";
  }
  EXPECT_GT(cycles_after_timeout, 10U);
}

TEST(Plugins, OneThatNeverReturnsLeavesNoForceOnTheMotors) { expect_force_ends("forever"); }
TEST(Plugins, OneThatAbortsLeavesNoForceOnTheMotors) { expect_force_ends("abort"); }

struct RecordedPlugins : testing::Test {
  ScratchFolder scratch;
  const std::string file = (scratch.path() / "session.hapton").string();
  System system{{"--record", file}};

  // Runs until the reported method contains this text and more than 300 samples were felt.
  Json run_until(const std::string& method_has) {
    return system.wait_for_report([&](const Json& now) {
      return note_of(now, "method").find(method_has) != std::string::npos && count(now, "contact_samples") > 300;
    });
  }
  Ended replay(std::vector<std::string> words) {
    words.insert(words.begin(), {"session", "replay", file});
    return run("hapton", words, scratch.path()).value_or(Ended{});
  }
  Ended set(std::vector<std::string> words) {
    words.insert(words.begin(), {"set", "--hub", system.hub()});
    return run("hapton", words, system.folder()).value_or(Ended{});
  }
};

TEST_F(RecordedPlugins, ASessionWithAnEffectIsReplayedWithTheSameFileOnly) {
  const std::string effect = plugin("odd_effect") + ":does=copy";
  system.add_arguments("haptics_node", {"--effect", effect, "--plugin-budget", kAmpleBudgetUs});
  system.start("io_node");
  system.start("haptics_node");
  EXPECT_THAT(note_of(run_until(" effects="), "method"), HasSubstr("effects=odd_one@"));
  system.end_all();
  const Ended same = replay({"--effect", effect});
  EXPECT_EQ(same.exit_code, 0) << same.out << same.err;
  EXPECT_THAT(same.out, HasSubstr(" 0 different"));
  const Ended without = replay({});
  EXPECT_EQ(without.exit_code, 1);
  EXPECT_THAT(without.err, HasSubstr("name the same files with the same parameters"));
  EXPECT_EQ(replay({"--effect", effect + ",n=3"}).exit_code, 1);
}

TEST_F(RecordedPlugins, ASceneWithOneIsFeltAndReplayedAsIfTheCommandLineHadNamedIt) {
  std::ofstream(system.folder() / "cube.toml", std::ios::app)
      << "[[effect]]\ntype = \"plugin\"\nlibrary = \"" << plugin("odd_effect") << "\"\nparameters = { does = \"copy\", n = 0.5 }\n";
  system.add_arguments("haptics_node", {"--allow-plugins", "--plugin-budget", kAmpleBudgetUs});
  system.start("io_node");
  system.start("haptics_node");
  EXPECT_THAT(note_of(run_until(" effects="), "method"), HasSubstr("effects=odd_one@"));
  system.end_all();
  const Ended same = replay({"--effect", plugin("odd_effect") + ":does=copy,n=0.5"});
  EXPECT_EQ(same.exit_code, 0) << same.out << same.err;
  EXPECT_THAT(same.out, HasSubstr(" 0 different"));
}

TEST_F(RecordedPlugins, AMethodFromAFileIsSwitchedTunedAndReplayed) {
  // The path goes beside the cube, through the floor that the method has.
  std::ofstream(system.folder() / "taps.csv") << "t_s,x_m,y_m,z_m\n0,0.01,0.01,0.06\n0.5,0.01,-0.002,0.06\n1,0.01,0.01,0.06\n";
  const std::string method = plugin("odd_method");
  system.add_arguments("haptics_node", {"--method", method, "--plugin-budget", kAmpleBudgetUs});
  system.start("io_node");
  system.start("haptics_node");
  const Json report = run_until("name=plugin:floor@");
  ASSERT_THAT(note_of(report, "method"), HasSubstr("name=plugin:floor@"));
  EXPECT_GT(count(report, "contact_samples"), 300);
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"--stiffness", "400"}, {"--method", "proxy"}, {"--method", "plugin"}, {"--method", "sweep"}}) {
    const Ended done = set(words);
    EXPECT_EQ(done.exit_code, 0) << words.back() << done.err;
  }
  system.end_all();
  const Ended same = replay({"--method", method});
  EXPECT_EQ(same.exit_code, 0) << same.out << same.err;
  EXPECT_THAT(replay({}).err, HasSubstr("the session has a method from a file"));
  EXPECT_THAT(replay({"--method", method + ":after=1"}).err, HasSubstr("another method than the one of the session"));
}

// Two effects at once, one of them bad. Material and method change, and the scene is read again.
TEST_F(RecordedPlugins, ABadOneIsNamedInLogReportAndRecordingAndTheOthersGoOn) {
  const std::string bad = plugin("odd_effect") + ":does=exception,after=300";
  system.add_arguments("haptics_node",
                       {"--effect", plugin("odd_effect") + ":n=0.5", "--effect", bad, "--watch-scene", "--plugin-budget", kAmpleBudgetUs});
  system.start("io_node");
  system.start("haptics_node");
  ASSERT_THAT(note_of(run_until("!cut"), "method"), HasSubstr("!cut"));
  EXPECT_EQ(set({"--stiffness", "500"}).exit_code, 0);
  EXPECT_EQ(set({"--method", "sweep"}).exit_code, 0);
  std::ofstream(system.folder() / "cube.toml", std::ios::app) << "material = \"soft\"\n[material.soft]\nstiffness_n_per_m = 300\n";
  ASSERT_TRUE(System::wait_until([&] { return system["haptics_node"].err().find("cube.toml") != std::string::npos; }));
  system["haptics_node"].send_signal(SIGTERM);
  const auto ended = system["haptics_node"].wait(kPatience);
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->exit_code, 0) << ended->err;
  EXPECT_THAT(ended->err, AllOf(HasSubstr("odd_one"), HasSubstr("is cut off: it threw a C++ exception")));
  EXPECT_EQ(ended->err.find("is cut off"), ended->err.rfind("is cut off")) << "once";
  EXPECT_THAT(ended->out, AllOf(HasSubstr("CUT OFF"), HasSubstr("maximum 0.500 N")));
  system.end("io_node");
  const Ended again = replay({"--effect", plugin("odd_effect") + ":n=0.5", "--effect", bad});
  EXPECT_EQ(again.exit_code, 1);
  EXPECT_THAT(again.err, HasSubstr("was cut off in this session"));
}

TEST(Plugins, AnEffectActsBesideARigidTool) {
  const ScratchFolder scratch;
  const std::string hub = "127.0.0.1:" + find_free_port();
  Program io("io_node", {"--bind", hub, "--device", "simulated-6dof", "--out", (scratch.path() / "out").string()}, scratch.path());
  Program haptics("haptics_node",
                  {"--hub", hub, "--scene", HAPTON_SOURCE_DIR "/scenes/pegs.toml", "--effect", plugin("odd_effect") + ":n=0.3"},
                  scratch.path());
  ASSERT_TRUE(System::wait_until([&] { return io.out().find("hub on ") != std::string::npos || !io.is_running(); }));
  EXPECT_TRUE(System::wait_until([&] {
    io.send_signal(SIGUSR1);
    const Json report = Json::parse(read_text(scratch.path() / "out" / "report.json"), nullptr, false);
    return report.is_object() && note_of(report, "method").find("name=tool") == 0 && count(report, "contact_samples") > 100;
  })) << haptics.err();
  for (Program* program : {&haptics, &io}) {
    program->send_signal(SIGTERM);
    const auto ended = program->wait(kPatience);
    ASSERT_TRUE(ended);
    EXPECT_EQ(ended->exit_code, 0) << ended->err;
    EXPECT_THAT(ended->out, Not(HasSubstr("CUT OFF")));
  }
}

// The device reports the force last written as its y: an effect of 0.1 mN is written to it, and read back.
TEST(Plugins, ADeviceFromAFileIsDriven) {
  constexpr double kForceN = 1e-4;
  System system({"--device", "plugin:" + plugin("odd_device") + ":rests=1"});
  std::ofstream(system.folder() / "cube.toml") << "[[object]]\nmesh = \"cube.obj\"\nunit = \"m\"\nposition_m = [0, 0, 0.5]\n"
                                                  "[[effect]]\ntype = \"constant\"\nforce_n = [0, 0.0001, 0]\n";
  system.start("io_node");
  ASSERT_TRUE(System::wait_until([&] { return system["io_node"].out().starts_with("hub on ") || !system["io_node"].is_running(); }));
  EXPECT_THAT(system["io_node"].out(), HasSubstr("device plugin line"));
  system.start("haptics_node");
  SessionObserver observer(system);
  ProbeState state;
  ASSERT_TRUE(observer.wait_for_force(state)) << "no force";
  bool is_driven = false;
  for (int n = 0; n < 10'000 && !is_driven; ++n) {
    ASSERT_TRUE(observer.receive_state(state));
    is_driven = std::abs(state.p_WD.y() - kForceN) < 1e-6 * kForceN;
  }
  EXPECT_TRUE(is_driven) << "y is " << state.p_WD.y() << " m, the force " << state.force_n.transpose() << " N";
  system.end_all();
}

// Its poses are invalid for 100 reads only: the fault holds on although the cause is gone, until a person resets it.
TEST(Plugins, TheFaultOfADeviceFromAFileIsLatched) {
  System system({"--device", "plugin:" + plugin("odd_device") + ":rests=1,does=nan,after=500,until=600"});
  system.start("io_node");
  const auto is_past_cause = [](const Json& now) { return count(now, "samples") > 1500; };
  const Json latched = system.wait_for_report(is_past_cause);
  ASSERT_TRUE(latched.is_object() && is_past_cause(latched)) << system["io_node"].err();
  EXPECT_EQ(note_of(latched, "safety_fault"), "position") << system["io_node"].err();
  EXPECT_EQ(note_of(latched, "governor"), "latched");
  const Ended reset = run("hapton", {"set", "--hub", system.hub(), "--reset-faults"}, system.folder()).value_or(Ended{});
  EXPECT_EQ(reset.exit_code, 0) << reset.err;
  const Json after_reset = system.wait_for_report([](const Json& now) { return note_of(now, "safety_fault") == "none"; });
  ASSERT_TRUE(after_reset.is_object());
  EXPECT_EQ(note_of(after_reset, "safety_fault"), "none") << system["io_node"].err();
  system.end_all();
}

// The systemd unit does not start io_node again after this code (RestartPreventExitStatus).
TEST(Plugins, ADeviceThatFailsForGoodEndsWithACodeOfItsOwn) {
  const ScratchFolder scratch;
  const std::string device = "plugin:" + plugin("odd_device") + ":does=fault,after=500";
  Program io("io_node", {"--bind", "127.0.0.1:" + find_free_port(), "--device", device}, scratch.path());
  const auto ended = io.wait(kPatience);
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->exit_code, 3);
  EXPECT_THAT(ended->err, HasSubstr("stopped replying"));
}

}  // namespace
}  // namespace hapton::process
