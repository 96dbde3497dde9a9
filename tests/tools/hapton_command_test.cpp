#include "tools/hapton_command.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <fmt/core.h>

#include "link/link_key.h"
#include "tests/tools/command_run.h"
#include "tools/commands.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class HaptonCommandTest : public ::testing::Test {
 protected:
  HaptonCommandTest() : folder_(std::filesystem::temp_directory_path() / ("hapton_command_" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(folder_);
    // A tetrahedron, and a probe that goes to its bottom face and presses.
    std::ofstream(folder_ / "t.obj") << "v 0 0 0\nv 10 0 0\nv 0 10 0\nv 0 0 10\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
    std::ofstream(folder_ / "t.csv")
        << "# press\nt_s,x_m,y_m,z_m\n0,0.002,0.002,-0.001\n0.001,0.002,0.002,0.0005\n0.002,0.002,0.002,0.001\n";
  }
  ~HaptonCommandTest() override { std::filesystem::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  std::vector<std::string> replay_arguments(const std::vector<std::string>& more_arguments) const {
    std::vector<std::string> arguments = {"replay", "--trajectory", path("t.csv"), "--out", path("r.csv"), "--method", "sweep"};
    arguments.insert(arguments.end(), more_arguments.begin(), more_arguments.end());
    return arguments;
  }

  std::filesystem::path folder_;
};

// The last force along z of a cube that is pressed on the tetrahedron's bottom face, from below, at 0.1 m/s.
double last_tool_force_n(const std::string& out) {
  std::ifstream file(out);
  std::string line;
  std::string last;
  std::string header;
  for (; std::getline(file, line);) {
    if (line.rfind("t_s,", 0) == 0) header = line;
    if (!line.empty() && line.front() != '#') last = line;
  }
  std::istringstream names(header);
  std::istringstream values(last);
  std::string value;
  for (std::string name; std::getline(names, name, ',') && std::getline(values, value, ',');) {
    if (name == "fz_n") return std::stod(value);
  }
  return NAN;
}

TEST_F(HaptonCommandTest, ReplayOfAToolHasTheDampingOfTheScene) {
  std::ofstream(folder_ / "cube.obj")
      << "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n"
         "f 1 3 2\nf 1 4 3\nf 5 6 7\nf 5 7 8\nf 1 2 6\nf 1 6 5\nf 2 3 7\nf 2 7 6\nf 3 4 8\nf 3 8 7\nf 4 1 5\nf 4 5 8\n";
  std::ofstream trajectory(folder_ / "tool.csv");
  trajectory << "t_s,x_m,y_m,z_m\n";
  for (int n = 0; n < 270; ++n) trajectory << fmt::format("{},0.003,0.003,{}\n", 1e-3 * n, -0.02 + 1e-4 * n);
  trajectory.close();
  std::vector<double> forces_n;
  for (const char* damping : {"0", "2"}) {
    std::ofstream(folder_ / "tool.toml") << "[[object]]\nname = \"block\"\nmesh = \"t.obj\"\nunit = \"mm\"\nmaterial = \"oil\"\n"
                                            "[material.oil]\nstiffness_n_per_m = 500\ndamping_ns_per_m = "
                                         << damping << "\n[tool]\nmesh = \"cube.obj\"\nunit = \"mm\"\n";
    const CommandRun run = run_hapton({"replay", "--scene", path("tool.toml"), "--trajectory", path("tool.csv"), "--out", path("r.csv")});
    ASSERT_EQ(run.code, 0) << run.err;
    forces_n.push_back(last_tool_force_n(path("r.csv")));
  }
  EXPECT_LT(forces_n[0], -0.1) << "it is pressed";
  EXPECT_NEAR(forces_n[1] - forces_n[0], -2.0 * 0.1, 1e-3);
}

TEST_F(HaptonCommandTest, HelpAndVersion) {
  const CommandRun help = run_hapton({"--help"});
  EXPECT_EQ(help.code, 0);
  for (const char* command : {"replay", "echo", "keygen", "latency", "plot", "set", "info"}) {
    EXPECT_THAT(help.out, HasSubstr(command));
    EXPECT_EQ(run_hapton({command, "--help"}).code, 0) << command;
  }
  const CommandRun version = run_hapton({"--version"});
  EXPECT_EQ(version.code, 0);
  EXPECT_THAT(version.out, HasSubstr("hapton 0."));
}

// Reads each line that lists a command, and the heading above it.
TEST_F(HaptonCommandTest, HelpListsEachCommandInALineUnderWhatPeopleWantToDo) {
  std::map<std::string, std::string> group_of;
  std::istringstream help(run_hapton({"--help"}).out);
  std::string group;
  for (std::string line; std::getline(help, line);) {
    EXPECT_LE(line.size(), 100U) << line;
    if (line.ends_with(':') && !line.starts_with(' ')) group = line;
    if (line.starts_with("  ") && std::isalpha(static_cast<unsigned char>(line[2])) != 0) {
      const std::string name = line.substr(2, line.find(' ', 2) - 2);
      EXPECT_TRUE(group_of.emplace(name, group).second) << name << " is listed twice";
      EXPECT_GT(line.size(), name.size() + 10) << name << " says nothing in its line";
    }
  }
  EXPECT_EQ(group_of["demo"], "Touch and watch:");
  EXPECT_EQ(group_of["doctor"], "Set up:");
  EXPECT_EQ(group_of["replay"], "Record and replay:");
  EXPECT_EQ(group_of["latency"], "Measure:");
  EXPECT_EQ(group_of["bench"], "Compare:");
  EXPECT_EQ(group_of["stress"], "Check:");
  EXPECT_EQ(group_of["figures"], "Develop:");
  EXPECT_EQ(group_of.size(), std::size(kCommands));
  EXPECT_FALSE(group_of.contains("judge")) << "an old name";
  EXPECT_THAT(run_hapton({"bench", "--help"}).out, HasSubstr("\nSubcommands:\n  effects")) << "only commands are grouped, not subcommands";
}

TEST_F(HaptonCommandTest, KeygenMakesAKeyOnceAndSaysHowToUseIt) {
  const CommandRun made = run_hapton({"keygen", path("key")});
  EXPECT_EQ(made.code, 0) << made.err;
  EXPECT_THAT(made.out, HasSubstr("--key " + path("key")));
  EXPECT_EQ(std::filesystem::file_size(path("key")), kKeyFileBytes);
  EXPECT_EQ(std::filesystem::status(path("key")).permissions(), std::filesystem::perms(0600));
  const CommandRun again = run_hapton({"keygen", path("key")});
  EXPECT_EQ(again.code, 1);
  EXPECT_THAT(again.err, HasSubstr("already exists"));
  EXPECT_EQ(run_hapton({"keygen"}).code, 2);
}

TEST_F(HaptonCommandTest, KeygenMakesTheKeysOfRolesFromAMasterKey) {
  ASSERT_EQ(run_hapton({"keygen", path("master")}).code, 0);
  for (const std::string role : {"haptics", "vision", "tool", "operator"}) {
    const CommandRun made = run_hapton({"keygen", "--role", role, "--master", path("master"), path(role)});
    EXPECT_EQ(made.code, 0) << made.err;
    EXPECT_THAT(made.out, HasSubstr("the key of role " + role));
    const auto key = read_role_key_file(path(role), *find_node_key_role(role));
    ASSERT_TRUE(key) << key.error().what;
    EXPECT_EQ(key->bytes(), RoleKey(*read_key_file(path("master")), *find_node_key_role(role)).bytes());
  }
  EXPECT_THAT(run_hapton({"keygen", "--role", "io", "--master", path("master"), path("io")}).err, HasSubstr("choose one of"));
  EXPECT_EQ(run_hapton({"keygen", "--role", "io", "--master", path("master"), path("io")}).code, 2);
  EXPECT_EQ(run_hapton({"keygen", "--master", path("master"), path("x")}).code, 2);
  EXPECT_THAT(run_hapton({"keygen", "--role", "tool", "--master", path("vision"), path("x")}).err, HasSubstr("is the key of role vision"));
  EXPECT_THAT(run_hapton({"keygen", "--master", path("master"), path("x")}).err, HasSubstr("--role"));
  EXPECT_FALSE(std::filesystem::exists(path("x")));
}

TEST_F(HaptonCommandTest, AWrongOptionIsReportedInOneLine) {
  const CommandRun run = run_hapton({"relay", "--loss", "2"});
  EXPECT_EQ(run.code, 2);
  EXPECT_THAT(run.err, HasSubstr("hapton relay: --loss"));
  EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1);
  EXPECT_EQ(run_hapton({"relay", "--delay-ms", "nan"}).code, 2);
  EXPECT_THAT(run_hapton({"latency", "run", "--hosts", "x", "--rate", "1000"}).err, HasSubstr("see hapton latency run --help"));
}

TEST_F(HaptonCommandTest, UnknownCommandsAreHinted) {
  const CommandRun run = run_hapton({"replya"});
  EXPECT_EQ(run.code, 2);
  EXPECT_EQ(run.err, "hapton: unknown command 'replya'; did you mean 'replay'?\n");
  EXPECT_EQ(run_hapton({"bench", "numbres"}).err, "hapton bench: unknown command 'numbres'; did you mean 'numbers'?\n");
  EXPECT_THAT(run_hapton({"session", "xyzzy", "file"}).err, HasSubstr("unknown command 'xyzzy'; known are info, export, replay"));
  EXPECT_EQ(run_hapton({"session", "xyzzy"}).code, 2);
  EXPECT_EQ(run_hapton({}).code, 2);
  EXPECT_EQ(run_hapton({"--no-such-flag"}).code, 2);
}

TEST_F(HaptonCommandTest, AMissingCommandIsNamedAndSoIsAFlagInItsPlace) {
  EXPECT_EQ(run_hapton({"--no-such-flag"}).err,
            "hapton: '--no-such-flag' is not a flag of hapton; give a command first; see hapton --help\n");
  EXPECT_EQ(run_hapton({"session"}).err, "hapton session: give a command; see hapton session --help\n");
}

TEST_F(HaptonCommandTest, UnknownFlagsAreHinted) {
  const CommandRun run = run_hapton({"replay", "--trajectroy", path("t.csv"), "--out", path("r.csv"), "--mesh", path("t.obj")});
  EXPECT_EQ(run.code, 2);
  EXPECT_THAT(run.err, HasSubstr("did you mean '--trajectory'?"));
  const CommandRun grouped = run_hapton(replay_arguments({"--mehs", path("t.obj")}));
  EXPECT_EQ(grouped.code, 2);
  EXPECT_THAT(grouped.err, HasSubstr("did you mean '--mesh'?"));
}

TEST_F(HaptonCommandTest, AnOutputThatCannotBeWrittenIsRejectedBeforeTheWork) {
  const CommandRun run = run_hapton({"replay", "--trajectory", path("none.csv"), "--out", path("t.obj/r.csv"), "--mesh", path("none.obj")});
  EXPECT_EQ(run.code, 2);
  EXPECT_THAT(run.err, HasSubstr("cannot be a folder"));
}

TEST_F(HaptonCommandTest, ReplayWritesTheForces) {
  const CommandRun run =
      run_hapton(replay_arguments({"--mesh", path("t.obj"), "--unit", "mm", "--stiffness", "2000", "--repeat", "2", "--grid", "4x3x2"}));
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("4 x 3 x 2 cells"));
  EXPECT_THAT(run.out, HasSubstr("3 steps, 2 in contact, force max 2 N"));
  std::ifstream file(path("r.csv"));
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) {
    lines.push_back(line);
  }
  ASSERT_EQ(lines.size(), 4U);
  EXPECT_THAT(lines[3], HasSubstr(",-2,1,"));
}

TEST_F(HaptonCommandTest, ReplaySaysWhatItCannotDo) {
  const auto replaced = [&](const std::string& flag, const std::string& value) {
    std::vector<std::string> arguments = replay_arguments({"--mesh", path("t.obj")});
    *(std::find(arguments.begin(), arguments.end(), flag) + 1) = value;
    return arguments;
  };
  EXPECT_THAT(run_hapton(replaced("--method", "swep")).err, HasSubstr("swep"));
  EXPECT_THAT(run_hapton(replaced("--trajectory", path("gone.csv"))).err, HasSubstr("gone.csv"));
  EXPECT_THAT(run_hapton(replaced("--out", path("gone/r.csv"))).err, HasSubstr("gone/r.csv"));
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {{"--mesh", path("gone.obj")}, "gone.obj"},
      {{"--mesh", path("t.obj"), "--unit", "furlong"}, "furlong"},
      {{"--mesh", path("t.obj"), "--grid", "0"}, "'0'"},
      {{"--mesh", path("t.obj"), "--friction-dynamic", "0.5"}, "--friction-static"},
      {{"--mesh", path("t.obj"), "--probe-radius", "0.001"}, "radius"},
      {{"--mesh", path("t.obj"), "--crease", "181"}, "--crease"},
      {{"--mesh", path("t.obj"), "--simplify", "2 furlong"}, "--simplify: '2 furlong' is not a length"},
  };
  for (const auto& [more_arguments, word] : cases) {
    const CommandRun run = run_hapton(replay_arguments(more_arguments));
    EXPECT_NE(run.code, 0) << word;
    EXPECT_THAT(run.err, HasSubstr(word));
  }
  EXPECT_EQ(run_hapton(replay_arguments({})).code, 2);  // neither mesh nor scene
  EXPECT_EQ(run_hapton(replay_arguments({"--mesh", path("t.obj"), "--scene", path("t.toml")})).code, 2);
  EXPECT_EQ(run_hapton(replay_arguments({"--mesh", path("t.obj"), "--stiffness", "-1"})).code, 2);
  EXPECT_EQ(run_hapton(replay_arguments({"--mesh", path("t.obj"), "--repeat", "0"})).code, 2);
}

TEST_F(HaptonCommandTest, SmoothSaysHowItSimplifiedAndWhatCountedAsSharp) {
  std::vector<std::string> arguments = replay_arguments({"--mesh", path("t.obj"), "--unit", "mm", "--simplify", "0.5mm", "--crease", "70"});
  *(std::find(arguments.begin(), arguments.end(), "sweep")) = "smooth";
  const CommandRun run = run_hapton(arguments);
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("simplify: 4 triangles, none merged within 0.0005 m"));
  EXPECT_THAT(run.out, HasSubstr("faces turn by more than 70 degrees"));
}

TEST_F(HaptonCommandTest, EvaluateIsStillFoundUnderItsOldName) {
  const CommandRun run = run_hapton({"judge", "--shape", "torus", "--rows", "50", "--threads", "1"});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("hapton judge is now hapton evaluate"));
  EXPECT_THAT(run.out, HasSubstr("force error"));
  EXPECT_THAT(run_hapton({"--help"}).out, Not(HasSubstr("judge")));
}

TEST_F(HaptonCommandTest, EvaluateLabelsAShadedForce) {
  const CommandRun run = run_hapton({"evaluate", "--shape", "torus", "--rows", "100", "--shading", "1", "--threads", "1"});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("force shading 1: the shaded force against the unshaded reference"));
}

TEST_F(HaptonCommandTest, GovernorHoldsAndSaysHowNearItCame) {
  const CommandRun run = run_hapton({"governor", "--steps", "2e5", "--seed", "5", "--threads", "2"});
  EXPECT_EQ(run.code, 0) << run.out;
  EXPECT_THAT(run.out, HasSubstr("seed 5"));
  EXPECT_THAT(run.out, HasSubstr("worst, 1 is the limit: force "));
  EXPECT_THAT(run.out, HasSubstr("governor: 0 breaches in 2"));
  EXPECT_EQ(run_hapton({"governor", "--steps", "0"}).code, 2);
  EXPECT_EQ(run_hapton({"governor", "--program", "7"}).code, 0);
}

// On a machine of 64 CPUs a run of an hour would take days otherwise.
TEST_F(HaptonCommandTest, LongRunsUseEveryCpuUnlessToldOtherwise) {
  const unsigned cpu_count = std::max(1U, std::thread::hardware_concurrency());
  for (const char* command : {"stress", "governor", "evaluate"}) {
    EXPECT_THAT(run_hapton({command, "--help"}).out, HasSubstr("--threads UINT:[1, 1024]=" + std::to_string(cpu_count) + " ")) << command;
  }
}

TEST_F(HaptonCommandTest, SetRejectsBeforeItContactsTheHub) {
  EXPECT_THAT(run_hapton({"set"}).err, HasSubstr("nothing to set"));
  EXPECT_EQ(run_hapton({"set"}).code, 2);
  EXPECT_THAT(run_hapton({"set", "--method", "nope"}).err, HasSubstr("'nope'"));
  EXPECT_EQ(run_hapton({"set", "--method", "nope"}).code, 2);
  EXPECT_EQ(run_hapton({"set", "--rate", "100"}).code, 2);
  EXPECT_THAT(run_hapton({"set", "--object", "hull"}).err, HasSubstr("nothing to set for object 'hull'"));
  EXPECT_THAT(run_hapton({"set", "--object", std::string(300, 'x'), "--damping", "1"}).err, HasSubstr("bytes, not 300"));
  for (const char* value : {"0", "-1", "2e6", "soft"}) EXPECT_EQ(run_hapton({"set", "--stiffness", value}).code, 2) << value;
  EXPECT_THAT(run_hapton({"set", "--friction", "11"}).err, HasSubstr("10"));
  EXPECT_EQ(run_hapton({"set", "--friction", "0.3", "--friction-dynamic", "0.2"}).code, 2);
  EXPECT_THAT(run_hapton({"set", "--help"}).out, HasSubstr("layers"));
  EXPECT_THAT(run_hapton({"set", "--hub", "no port:x", "--report"}).err, HasSubstr("no port"));
}

// `hapton bench` alone does the same as `bench numbers`, the only one that has --windows.
TEST_F(HaptonCommandTest, BenchAloneMeasuresTheNumbersToBeat) {
  const CommandRun run = run_hapton({"bench", "--quick", "--windows", "1", "--mesh", path("gone.obj"), "--out", path("numbers")});
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.err, testing::StartsWith("hapton bench numbers: " + path("gone.obj")));
}

TEST_F(HaptonCommandTest, BenchAloneChecksItsFolderBeforeItMeasures) {
  std::ofstream(folder_ / "a file");
  const CommandRun run = run_hapton({"bench", "--quick", "--compared-steps", "20", "--out", path("a file/numbers")});
  EXPECT_EQ(run.code, 2);
  EXPECT_THAT(run.err, HasSubstr("a file is not a folder"));
}

TEST_F(HaptonCommandTest, BenchTakesTheOldNameOfComparedStepsAndSaysSo) {
  std::ofstream(folder_ / "a file");
  for (const std::string kind : {"numbers", "pareto"}) {
    const CommandRun run = run_hapton({"bench", kind, "--quick", "--judged-steps", "20", "--out", path("a file/numbers")});
    EXPECT_EQ(run.code, 2) << kind;
    EXPECT_THAT(run.err, HasSubstr("--judged-steps is now --compared-steps")) << kind;
    EXPECT_THAT(run_hapton({"bench", kind, "--judged-steps", "1", "--out", path("numbers")}).err, HasSubstr("--compared-steps")) << kind;
    EXPECT_THAT(run_hapton({"bench", kind, "--help"}).out, AllOf(Not(HasSubstr("judged")), Not(HasSubstr("Excludes: \n")))) << kind;
    const CommandRun both = run_hapton({"bench", kind, "--judged-steps", "20", "--compared-steps", "20", "--out", path("a file/numbers")});
    EXPECT_EQ(both.code, 2) << kind;
    EXPECT_THAT(both.err, HasSubstr("--judged-steps excludes --compared-steps")) << kind;
  }
}

TEST_F(HaptonCommandTest, StressTakesTheOldNameOfMinimumEveryAndSaysSo) {
  const CommandRun run = run_hapton({"stress", "--body", "box", "--rest-every", "16", "--friction-dynamic", "0.3"});
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.err, HasSubstr("--rest-every is now --minimum-every"));
  EXPECT_THAT(run_hapton({"stress", "--help"}).out, Not(HasSubstr("rest-every")));
}

TEST_F(HaptonCommandTest, StressRejectsADynamicFrictionAboveTheStaticOne) {
  const CommandRun run = run_hapton({"stress", "--body", "box", "--friction-dynamic", "0.3"});
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.err, HasSubstr("dynamic friction 0.3 is above static friction 0"));
}

TEST_F(HaptonCommandTest, EchoEndsWhenItsTimeIsOver) {
  const CommandRun run = run_hapton({"echo", "--bind", "127.0.0.1:0", "--seconds", "0.05"});
  EXPECT_EQ(run.code, 0);
  EXPECT_THAT(run.out, HasSubstr("echo at 127.0.0.1:"));
  EXPECT_EQ(run_hapton({"echo", "--bind", "somewhere else"}).code, 1);
}

}  // namespace
}  // namespace hapton
