// Whatever people type, a program prints one line on stderr that names the problem, and its exit code is neither zero nor that of a crash.
#include <sys/resource.h>
#include <sys/stat.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "tests/process/program.h"

namespace hapton::process {
namespace {

struct BadCall {
  std::string name;  // of the test
  std::string program;
  std::vector<std::string> arguments;  // FOLDER and TAKEN_PORT are replaced
  std::string mentions;                // must be in the line
  int exit_code = 0;                   // 0: any code except 0
};

void PrintTo(const BadCall& call, std::ostream* out) { *out << call.program << " " << call.name; }

std::string replace_all(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) text.replace(at, from.size(), to);
  return text;
}

// The errors on stderr, without notices.
std::vector<std::string> error_lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    if (!line.empty() && line.find("  info  ") == std::string::npos) lines.push_back(line);
  }
  return lines;
}

void write(const std::filesystem::path& path, const std::string& text) { std::ofstream(path) << text; }

// Files that a call may name.
void make_bad_files(const std::filesystem::path& folder) {
  write(folder / "broken.toml", "[[object]\nmesh = ");
  write(folder / "no_mesh.toml", "[[object]]\nmesh = \"gone.obj\"\n");
  write(folder / "empty.obj", "");
  write(folder / "nan.obj", "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n");
  write(folder / "range.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n");
  write(folder / "good.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  write(folder / "both.toml",
        "[[object]]\nmesh = 'good.obj'\n[[object.morph]]\npush_m = [0, 0, 0.1]\ncenter_m = [0, 0, 0]\nradius_m = 1\nkeys = [[0, 0], [10, "
        "1]]\n[[object]]\nmesh = 'good.obj'\nmovable = true\n");
  write(folder / "short.key", "short");
  write(folder / "open.key", std::string(32, 'k'));
  std::filesystem::permissions(folder / "short.key", std::filesystem::perms(0600));
  std::filesystem::permissions(folder / "open.key", std::filesystem::perms(0644));
  write(folder / "empty.csv", "");
  write(folder / "text.csv", "t_s,x_m,y_m,z_m\n0,a,0,0\n");
  write(folder / "far.csv", "t_s,x_m,y_m,z_m\n0,0.2,0.2,0.01\n0.001,1e308,0.2,-0.001\n");
  ::mkfifo((folder / "pipe").c_str(), 0600);
  std::filesystem::create_directories(folder / "pipes");
  ::mkfifo((folder / "pipes" / "latency.csv").c_str(), 0600);
  write(folder / "good.csv", "t_s,x_m,y_m,z_m\n0,0.2,0.2,0.01\n0.001,0.2,0.2,-0.001\n");
}

class BadInput : public ::testing::TestWithParam<BadCall> {};

TEST_P(BadInput, GivesOneLineAndFails) {
  const BadCall& call = GetParam();
  const TestFolder folder;
  make_bad_files(folder.path());
  const TakenPort taken;
  const auto fill_in = [&](const std::string& text) {
    return replace_all(replace_all(text, "FOLDER", folder.path().string()), "TAKEN_PORT", taken.port());
  };
  std::vector<std::string> arguments = call.arguments;
  std::ranges::transform(arguments, arguments.begin(), fill_in);

  const auto ended = run(call.program, arguments, folder.path());
  ASSERT_TRUE(ended) << "still runs";
  EXPECT_NE(ended->exit_code, 0);
  if (call.exit_code != 0) {
    EXPECT_EQ(ended->exit_code, call.exit_code);
  }
  EXPECT_LT(ended->exit_code, 126) << "ended by a signal or not started";
  const std::vector<std::string> error_lines = error_lines_of(ended->err);
  ASSERT_EQ(error_lines.size(), 1U) << ended->err;
  EXPECT_THAT(error_lines.front(), ::testing::HasSubstr(fill_in(call.mentions)));
}

// Only io_node is started. Port 0 is any free port, so an io_node that continued would hold no port that another test needs.
const std::vector<BadCall> kIoNode = {
    {"UnknownFlag", "io_node", {"--frobnicate"}, "frobnicate"},
    {"ConfigIsAPipe", "io_node", {"--config", "FOLDER/pipe"}, "not a regular file"},
    {"DevicesIsAPipe", "io_node", {"--devices", "FOLDER/pipe"}, "not a regular file"},
    {"DeviceFileIsAPipe", "io_node", {"--device", "wooden-haptics", "--device-file", "FOLDER/pipe"}, "not a regular file"},
    {"TrajectoryIsAPipe", "io_node", {"--device", "replay", "--trajectory", "FOLDER/pipe"}, "not a regular file"},
    {"RecordIsAPipe", "io_node", {"--bind", "127.0.0.1:0", "--record", "FOLDER/pipe"}, "pipe"},
    {"KeyIsAPipe", "io_node", {"--bind", "0.0.0.0:0", "--key", "FOLDER/pipe"}, "pipe"},
    {"PortIsText", "io_node", {"--bind", "127.0.0.1:port"}, "port"},
    {"PortTooLarge", "io_node", {"--bind", "127.0.0.1:70000"}, "70000"},
    {"AddressIsText", "io_node", {"--bind", "not an address:1"}, "not an address"},
    {"PortInUse", "io_node", {"--bind", "127.0.0.1:TAKEN_PORT"}, "TAKEN_PORT"},
    {"UnknownDevice", "io_node", {"--bind", "127.0.0.1:0", "--device", "spoon"}, "spoon"},
    {"RateTooLow", "io_node", {"--bind", "127.0.0.1:0", "--rate", "10"}, "10"},
    {"RateTooHigh", "io_node", {"--bind", "127.0.0.1:0", "--rate", "1000000"}, "1000000"},
    {"SeedBelowZero", "io_node", {"--bind", "127.0.0.1:0", "--seed=-1"}, "--seed: -1 is out of range; give a whole number from 0"},
    {"RateIsText", "io_node", {"--bind", "127.0.0.1:0", "--rate", "fast"}, "--rate: fast is not a number; give 250 to 10000"},
    {"RateIsNan", "io_node", {"--bind", "127.0.0.1:0", "--rate", "nan"}, "rate"},
    {"SecondsNegative", "io_node", {"--bind", "127.0.0.1:0", "--seconds", "-1"}, "seconds"},
    {"ReplayWithoutTrajectory", "io_node", {"--bind", "127.0.0.1:0", "--device", "replay"}, "trajectory"},
    {"TrajectoryMissing", "io_node", {"--bind", "127.0.0.1:0", "--device", "replay", "--trajectory", "FOLDER/gone.csv"}, "gone.csv"},
    {"TrajectoryFarOut",
     "io_node",
     {"--bind", "127.0.0.1:0", "--device", "replay", "--trajectory", "FOLDER/far.csv"},
     "far.csv:3: x_m is '1e308'"},
    {"TrajectoryEmpty", "io_node", {"--bind", "127.0.0.1:0", "--device", "replay", "--trajectory", "FOLDER/empty.csv"}, "empty.csv"},
    {"TrajectoryIsText", "io_node", {"--bind", "127.0.0.1:0", "--device", "replay", "--trajectory", "FOLDER/text.csv"}, "text.csv"},
    {"MetricsElsewhere", "io_node", {"--bind", "127.0.0.1:0", "--metrics", "0.0.0.0:0"}, "this machine only"},
    {"MetricsPortIsText", "io_node", {"--bind", "127.0.0.1:0", "--metrics", "127.0.0.1:port"}, "port"},
    {"EchoTooLong", "io_node", {"--bind", "127.0.0.1:0", "--echo-size", "100000"}, "100000"},
    {"ConfigMissing", "io_node", {"--config", "FOLDER/gone.toml"}, "gone.toml"},
    {"ConfigBroken", "io_node", {"--config", "FOLDER/broken.toml"}, "broken.toml"},
    {"BeyondLoopbackWithoutKey", "io_node", {"--bind", "0.0.0.0:0"}, "--key FILE"},
    {"KeyMissing", "io_node", {"--bind", "127.0.0.1:0", "--key", "FOLDER/gone.key"}, "gone.key"},
    {"KeyTooShort", "io_node", {"--bind", "127.0.0.1:0", "--key", "FOLDER/short.key"}, "short.key: has 5 bytes"},
    {"KeyOpenToAll", "io_node", {"--bind", "0.0.0.0:0", "--key", "FOLDER/open.key"}, "chmod 600 FOLDER/open.key"},
};

const std::vector<BadCall> kHapticsNode = {
    {"UnknownFlag", "haptics_node", {"--frobnicate"}, "frobnicate"},
    {"SceneMissing", "haptics_node", {"--scene", "FOLDER/gone.toml"}, "gone.toml"},
    {"SceneBroken", "haptics_node", {"--scene", "FOLDER/broken.toml"}, "broken.toml"},
    {"MeshMissing", "haptics_node", {"--scene", "FOLDER/no_mesh.toml"}, "gone.obj"},
    {"SceneIsAFolder", "haptics_node", {"--scene", "FOLDER"}, "FOLDER"},
    {"ToolThatIsNotThere",
     "haptics_node",
     {"--scene", HAPTON_SOURCE_DIR "/scenes/car_front.toml", "--tool", "nowhere.stl"},
     "nowhere.stl: no such file"},
    {"DeformsAndHasATool",
     "haptics_node",
     {"--scene", HAPTON_SOURCE_DIR "/scenes/deforming.toml", "--tool", HAPTON_SOURCE_DIR "/meshes/peg.obj", "--tool-unit", "mm"},
     "object 'block' deforms, which a rigid tool does not support"},
    {"DeformsAndMovable",
     "haptics_node",
     {"--scene", "FOLDER/both.toml"},
     "both.toml: line 2: object 'good' deforms and 'good' (line 9) is movable"},
    {"MovesAndIsSmooth", "haptics_node", {"--scene", HAPTON_SOURCE_DIR "/scenes/machine.toml", "--method", "smooth"}, "choose proxy"},
    {"AnnotationsBroken",
     "haptics_node",
     {"--scene", HAPTON_SOURCE_DIR "/scenes/workbench.toml", "--annotations", "FOLDER/broken.toml"},
     "broken.toml: line"},
    {"GraspButton", "haptics_node", {"--grasp-button", "0"}, "--grasp-button"},
    {"ToolAndProbeRadius", "haptics_node", {"--scene", HAPTON_SOURCE_DIR "/scenes/pegs.toml", "--probe-radius", "0.01"}, "rigid tool"},
    {"ToolGripThatIsNone", "haptics_node", {"--tool", "peg.obj", "--tool-grip", "handle"}, "'handle' is not a grip point"},
    {"UnknownMethod", "haptics_node", {"--scene", HAPTON_SOURCE_DIR "/scenes/car_front.toml", "--method", "magic"}, "magic"},
    {"HubPortTooLarge", "haptics_node", {"--scene", HAPTON_SOURCE_DIR "/scenes/car_front.toml", "--hub", "127.0.0.1:99999"}, "99999"},
    {"HubHasNoPort", "haptics_node", {"--scene", HAPTON_SOURCE_DIR "/scenes/car_front.toml", "--hub", "127.0.0.1:"}, "127.0.0.1:"},
    {"SecondsIsText", "haptics_node", {"--seconds", "soon"}, "soon"},
    {"OffsetIsZero", "haptics_node", {"--offset-in", "0"}, "--offset-in: 0 is not above zero; give inches above zero"},
    {"ProbeRadiusBelowZero", "haptics_node", {"--probe-radius", "-1"}, "--probe-radius: -1 is below zero; give metres, zero or more"},
    {"NoHubInAllItsSeconds",
     "haptics_node",
     {"--scene", HAPTON_SOURCE_DIR "/scenes/car_front.toml", "--hub", "127.0.0.1:TAKEN_PORT", "--seconds", "0.2", "--rt", "off"},
     "no hub at 127.0.0.1:TAKEN_PORT accepted it within 0.2 s; start io_node there"},
    {"ConfigMissing", "haptics_node", {"--config", "FOLDER/gone.toml"}, "gone.toml"},
    {"ConfigIsAPipe", "haptics_node", {"--config", "FOLDER/pipe"}, "not a regular file"},
    {"SceneIsAPipe", "haptics_node", {"--scene", "FOLDER/pipe"}, "not a regular file"},
    {"HubBeyondLoopbackWithoutKey", "haptics_node", {"--hub", "192.0.2.1"}, "--key FILE"},
    {"KeyMissing", "haptics_node", {"--hub", "192.0.2.1", "--key", "FOLDER/gone.key"}, "gone.key"},
};

const std::vector<BadCall> kTools = {
    {"UnknownCommand", "hapton", {"fly"}, "fly"},
    {"InfoMissing", "hapton", {"info", "FOLDER/gone.obj"}, "gone.obj"},
    {"InfoEmpty", "hapton", {"info", "FOLDER/empty.obj"}, "empty.obj"},
    {"InfoNan", "hapton", {"info", "FOLDER/nan.obj"}, "nan.obj"},
    {"InfoIndexOutOfRange", "hapton", {"info", "FOLDER/range.obj"}, "range.obj"},
    {"InfoUnknownUnit", "hapton", {"info", "FOLDER/good.obj", "--unit", "furlong"}, "furlong"},
    {"CheckMissing", "hapton", {"check", "FOLDER/gone.toml"}, "gone.toml"},
    {"CheckBrokenScene", "hapton", {"check", "FOLDER/broken.toml"}, "broken.toml"},
    {"CheckUnknownDevice", "hapton", {"check", "FOLDER/good.obj", "--device", "phantom-9"}, "phantom-9"},
    {"ReplayMeshMissing",
     "hapton",
     {"replay", "--mesh", "FOLDER/gone.obj", "--trajectory", "FOLDER/good.csv", "--out", "FOLDER/r.csv"},
     "gone.obj"},
    {"ReplayTrajectoryMissing",
     "hapton",
     {"replay", "--mesh", "FOLDER/good.obj", "--trajectory", "FOLDER/gone.csv", "--out", "FOLDER/r.csv"},
     "gone.csv"},
    {"ReplayUnknownMethod",
     "hapton",
     {"replay", "--mesh", "FOLDER/good.obj", "--trajectory", "FOLDER/good.csv", "--out", "FOLDER/r.csv", "--method", "magic"},
     "magic"},
    {"ReplayOutNotWritable",
     "hapton",
     {"replay", "--mesh", "FOLDER/good.obj", "--trajectory", "FOLDER/good.csv", "--out", "FOLDER/no/such/folder/r.csv"},
     "r.csv"},
    {"ReplayToolMissing",
     "hapton",
     {"replay", "--mesh", "FOLDER/good.obj", "--tool", "FOLDER/gone.stl", "--trajectory", "FOLDER/good.csv", "--out", "FOLDER/r.csv"},
     "gone.stl"},
    {"ReplayVoxelsWithoutATool",
     "hapton",
     {"replay", "--mesh", "FOLDER/good.obj", "--tool-voxels", "0.001", "--trajectory", "FOLDER/good.csv", "--out", "FOLDER/r.csv"},
     "--tool-voxels goes with --tool"},
    {"ReplayVoxelsTooSmall",
     "hapton",
     {"replay", "--mesh", "FOLDER/good.obj", "--tool", "FOLDER/good.obj", "--tool-voxels", "1e-9", "--trajectory", "FOLDER/good.csv",
      "--out", "FOLDER/r.csv"},
     "fits"},
    {"ReplayToolWithFriction",
     "hapton",
     {"replay", "--mesh", "FOLDER/good.obj", "--tool", "FOLDER/good.obj", "--friction-dynamic", "0.3", "--trajectory", "FOLDER/good.csv",
      "--out", "FOLDER/r.csv"},
     "is above static friction"},
    {"ReplayStiffnessIsZero",
     "hapton",
     {"replay", "--mesh", "FOLDER/good.obj", "--trajectory", "FOLDER/good.csv", "--out", "FOLDER/r.csv", "--stiffness", "0"},
     "--stiffness: 0 is not above zero; give a number above zero"},
    {"ReplayStiffnessIsAbsurd",
     "hapton",
     {"replay", "--mesh", "FOLDER/good.obj", "--trajectory", "FOLDER/good.csv", "--out", "FOLDER/r.csv", "--stiffness", "1e308"},
     "--stiffness"},
    {"EvaluateProbeIsAbsurd",
     "hapton",
     {"evaluate", "--shape", "sphere", "--rows", "10", "--probe-radius", "1e30"},
     "probe radius of 1e+30 m; give 0 to"},
    {"EvaluateFrictionIsAbsurd",
     "hapton",
     {"evaluate", "--shape", "sphere", "--rows", "10", "--friction-static", "1e30"},
     "--friction-static"},
    {"PressOfAWallThatIsNone", "hapton", {"loop", "press", "--device", "touch", "--stiffness", "1e-300"}, "give less force"},
    {"PressAmplifierIsAbsurd", "hapton", {"loop", "press", "--device", "touch", "--amplifier", "1e30"}, "--amplifier"},
    {"StressBodyIsNotKnown", "hapton", {"stress", "--body", "groove"}, "--body: 'groove' is not known"},
    {"StressFarOut", "hapton", {"stress", "--body", "box", "--steps", "100", "--offset", "1e30"}, "--offset"},
    {"ReplayTrajectoryFarOut",
     "hapton",
     {"replay", "--mesh", "FOLDER/good.obj", "--trajectory", "FOLDER/far.csv", "--out", "FOLDER/r.csv"},
     "far.csv:3: x_m is '1e308'"},
    {"SessionInfoOfAPipe", "hapton", {"session", "info", "FOLDER/pipe"}, "not a regular file"},
    {"SessionReplayOfAPipe", "hapton", {"session", "replay", "FOLDER/pipe"}, "not a regular file"},
    {"SessionExportOfAPipe", "hapton", {"session", "export", "FOLDER/pipe", "--out", "FOLDER/out"}, "not a regular file"},
    {"ReplayTrajectoryIsAPipe",
     "hapton",
     {"replay", "--mesh", "FOLDER/good.obj", "--trajectory", "FOLDER/pipe", "--out", "FOLDER/r.csv"},
     "not a regular file"},
    {"ReplayMeshIsAPipe",
     "hapton",
     {"replay", "--mesh", "FOLDER/pipe", "--trajectory", "FOLDER/good.csv", "--out", "FOLDER/r.csv"},
     "not a regular file"},
    {"ReplayOutIsAPipe",
     "hapton",
     {"replay", "--mesh", "FOLDER/good.obj", "--trajectory", "FOLDER/good.csv", "--out", "FOLDER/pipe"},
     "pipe: cannot be written"},
    {"RelayScriptIsAPipe", "hapton", {"relay", "--script", "FOLDER/pipe"}, "not a regular file"},
    {"CompareAPipe", "hapton", {"latency", "compare", "FOLDER/pipe", "FOLDER/pipe"}, "not a regular file"},
    {"PlotAPipe", "hapton", {"plot", "FOLDER/pipes"}, "not a regular file"},
    {"InfoOfAPipe", "hapton", {"info", "FOLDER/pipe"}, "not a regular file"},
    {"KeyIsAPipe", "hapton", {"top", "--once", "--hub", "192.0.2.1", "--key", "FOLDER/pipe"}, "pipe"},
    {"PlotMissing", "hapton", {"plot", "FOLDER/gone"}, "gone"},
    {"CompareMissing", "hapton", {"latency", "compare", "FOLDER/gone", "FOLDER/gone"}, "gone"},
    {"CompareNoReport", "hapton", {"latency", "compare", "FOLDER/good.csv", "FOLDER/good.csv"}, "good.csv"},
    {"LatencySceneMissing", "hapton", {"latency", "run", "--out", "FOLDER/out", "--scene", "FOLDER/gone.toml"}, "gone.toml"},
    {"RelayScriptMissing", "hapton", {"relay", "--script", "FOLDER/gone.toml"}, "gone.toml"},
    {"RelayScriptBroken", "hapton", {"relay", "--script", "FOLDER/broken.toml"}, "broken.toml"},
    {"RelayPortInUse", "hapton", {"relay", "--listen", "127.0.0.1:TAKEN_PORT"}, "TAKEN_PORT"},
    {"RelayHubIsText", "hapton", {"relay", "--hub", "not an address:1"}, "not an address"},
    {"RelayBurstsTooDense", "hapton", {"relay", "--burst-share", "0.99"}, "burst share"},
    {"RelayDelayIsNan", "hapton", {"relay", "--delay-ms", "nan"}, "delay-ms"},
    {"LatencySecondsAreInfinite", "hapton", {"latency", "--seconds", "inf"}, "seconds"},
    {"TopHubIsText", "hapton", {"top", "--once", "--hub", "127.0.0.1:port"}, "port"},
    {"MarkWithoutText", "hapton", {"mark", ""}, "needs a text", 2},
    {"MarkOfTwoLines", "hapton", {"mark", "a\nb"}, "line ends"},
    {"MarkLineWithoutInput", "hapton", {"mark", "--line", "/dev/ttyS0"}, "DEVICE:PIN"},
    {"MarkLineGone", "hapton", {"mark", "--line", "FOLDER/gone:CTS"}, "cannot be opened"},
    {"MarkLineIsAFile", "hapton", {"mark", "--line", "FOLDER/good.obj:CTS"}, "not a serial port"},
    {"MarkEdgesWithoutLine", "hapton", {"mark", "a", "--edges", "both"}, "--line"},
    {"MarkBeyondLoopbackWithoutKey", "hapton", {"mark", "a", "--hub", "192.0.2.1"}, "--key FILE"},
    {"KeygenOverAFile", "hapton", {"keygen", "FOLDER/good.obj"}, "good.obj"},
    {"KeygenNowhere", "hapton", {"keygen", "FOLDER/no/such/key"}, "no/such/key"},
    {"MoveWithoutTarget", "hapton", {"move", "lid"}, "give --to, --rotate, or both", 2},
    {"MoveToTwoNumbers", "hapton", {"move", "lid", "--to", "1,2"}, "three numbers in metres", 2},
    {"MoveToNaN", "hapton", {"move", "lid", "--to", "nan,0,0"}, "three numbers in metres"},
    {"MoveToWords", "hapton", {"move", "lid", "--to", "up,0,0"}, "three numbers in metres"},
    {"MoveByNoRotation", "hapton", {"move", "lid", "--rotate", "1,1,0,0"}, "of length 1"},
    {"MoveInNoTime", "hapton", {"move", "lid", "--to", "0,0,0", "--over", "0"}, "--over"},
    {"MoveInMoreThanADay", "hapton", {"move", "lid", "--to", "0,0,0", "--over", "1e6"}, "86400"},
    {"MoveANumberThatIsNone", "hapton", {"move", "#x", "--to", "0,0,0"}, "'#x' is not the number of an object"},
    {"DynamicsWithoutBodies",
     "hapton",
     {"dynamics", "--scene", HAPTON_SOURCE_DIR "/scenes/lift.toml"},
     "no object of the scene has a mass"},
    {"DynamicsWithoutScene", "hapton", {"dynamics", "--scene", "none.toml"}, "none.toml"},
    {"DynamicsWithoutHub",
     "hapton",
     {"dynamics", "--scene", HAPTON_SOURCE_DIR "/scenes/push.toml", "--hub", "127.0.0.1:1"},
     "start io_node"},
    {"MoveWithoutHub", "hapton", {"move", "lid", "--to", "0,0,0", "--hub", "127.0.0.1:1"}, "start io_node", 1},
    {"ProgramsMoveAndIsSmooth",
     "haptics_node",
     {"--scene", HAPTON_SOURCE_DIR "/scenes/lift.toml", "--method", "smooth"},
     "choose proxy or reference"},
    {"SetNothing", "hapton", {"set"}, "nothing to set", 2},
    {"SetBeyondLoopbackWithoutKey", "hapton", {"set", "--hub", "192.0.2.1", "--rate", "1000"}, "--key FILE"},
};

std::string name_of(const ::testing::TestParamInfo<BadCall>& info) { return info.param.name; }

INSTANTIATE_TEST_SUITE_P(IoNode, BadInput, ::testing::ValuesIn(kIoNode), name_of);
INSTANTIATE_TEST_SUITE_P(HapticsNode, BadInput, ::testing::ValuesIn(kHapticsNode), name_of);
INSTANTIATE_TEST_SUITE_P(Tools, BadInput, ::testing::ValuesIn(kTools), name_of);

#ifdef HAPTON_WITH_VISION
const std::vector<BadCall> kVisionNode = {
    {"UnknownFlag", "vision_node", {"--frobnicate"}, "frobnicate"},
    {"UnknownStereo", "vision_node", {"--stereo", "cubist"}, "cubist"},
    {"SceneMissing", "vision_node", {"--scene", "FOLDER/gone.toml"}, "gone.toml"},
    {"SceneBroken", "vision_node", {"--scene", "FOLDER/broken.toml"}, "broken.toml"},
    {"HubBeyondLoopbackWithoutKey", "vision_node", {"--hub", "192.0.2.1"}, "--key FILE"},
    {"SizeIsText", "vision_node", {"--size", "large"}, "large", 2},
    {"StrokesAsStl", "vision_node", {"--strokes", "FOLDER/lines.stl"}, "ends in .obj or .vtp", 2},
    {"AnnotationsAsVtp", "vision_node", {"--annotations", "FOLDER/notes.vtp"}, "ends in .toml", 2},
    {"OneButtonForTwo", "vision_node", {"--draw-button", "3"}, "--draw-button and --measure-button are both 3", 2},
    {"HeadInTheScreen", "vision_node", {"--head-mm", "0,0,10"}, "--head-mm 0,0,10", 2},
    {"DisplayUnreachable", "vision_node", {"--scene", HAPTON_SOURCE_DIR "/scenes/car_front.toml"}, "isplay"},
};
INSTANTIATE_TEST_SUITE_P(VisionNode, BadInput, ::testing::ValuesIn(kVisionNode), name_of);
#endif

class Help : public ::testing::TestWithParam<std::string> {};
class FewDescriptors : public ::testing::TestWithParam<std::string> {};
class Version : public ::testing::TestWithParam<std::string> {};

TEST_P(Help, IsThereAndSucceeds) {
  const TestFolder folder;
  const auto ended = run(GetParam(), {"--help"}, folder.path());
  ASSERT_TRUE(ended) << "still runs";
  EXPECT_EQ(ended->exit_code, 0);
  EXPECT_THAT(ended->out, ::testing::HasSubstr("--help"));
  EXPECT_EQ(ended->err, "");
}

TEST_P(Version, IsOneLineOfNameAndNumber) {
  const TestFolder folder;
  const auto ended = run(GetParam(), {"--version"}, folder.path());
  ASSERT_TRUE(ended) << "still runs";
  EXPECT_EQ(ended->exit_code, 0);
  EXPECT_THAT(ended->out, ::testing::MatchesRegex(GetParam() + " [0-9]+\\.[0-9]+\\.[0-9]+\n"));
  EXPECT_EQ(ended->err, "");
}

// Sets the soft limit of descriptors of this process, which child processes inherit, as long as this object lives.
class DescriptorLimit {
 public:
  explicit DescriptorLimit(rlim_t allowed) {
    ::getrlimit(RLIMIT_NOFILE, &before_);
    const rlimit limit = {.rlim_cur = allowed, .rlim_max = before_.rlim_max};
    ::setrlimit(RLIMIT_NOFILE, &limit);
  }
  ~DescriptorLimit() { ::setrlimit(RLIMIT_NOFILE, &before_); }
  DescriptorLimit(const DescriptorLimit&) = delete;
  DescriptorLimit& operator=(const DescriptorLimit&) = delete;

 private:
  rlimit before_ = {};
};

TEST_P(FewDescriptors, EndWithOneLine) {
  for (const rlim_t allowed : {8, 16, 24}) {
    const TestFolder folder;
    std::optional<Program> program;
    {
      const DescriptorLimit limit(allowed);
      program.emplace(GetParam(), std::vector<std::string>{}, folder.path());
    }
    const auto ended = program->wait(kPatience);
    ASSERT_TRUE(ended) << "still runs";
    EXPECT_EQ(ended->exit_code, 1) << allowed;
    const std::vector<std::string> error_lines = error_lines_of(ended->err);
    ASSERT_EQ(error_lines.size(), 1U) << ended->err;
    EXPECT_THAT(error_lines.front(), ::testing::HasSubstr("file descriptors"));
    EXPECT_THAT(error_lines.front(), ::testing::HasSubstr("ulimit -n"));
  }
}

#ifdef HAPTON_FEW_THREADS
// A system limit on the threads of a program, which child processes inherit, as long as this object lives.
class ThreadLimit {
 public:
  ThreadLimit(const std::string& program, int allowed) {
    ::setenv("LD_PRELOAD", HAPTON_FEW_THREADS, 1);
    ::setenv("HAPTON_STANDIN_THREADS", (program + ":" + std::to_string(allowed)).c_str(), 1);
  }
  ~ThreadLimit() {
    ::unsetenv("LD_PRELOAD");
    ::unsetenv("HAPTON_STANDIN_THREADS");
  }
  ThreadLimit(const ThreadLimit&) = delete;
  ThreadLimit& operator=(const ThreadLimit&) = delete;
};

class FewThreads : public ::testing::TestWithParam<BadCall> {};

// Each round allows one thread more, until the program has all that it needs.
TEST_P(FewThreads, EndWithOneLine) {
  const BadCall& call = GetParam();
  int allowed = 0;
  for (bool has_enough = false; !has_enough; ++allowed) {
    ASSERT_LT(allowed, 20) << "it never has enough";
    const TestFolder folder;
    std::vector<std::string> arguments = call.arguments;
    std::ranges::transform(arguments, arguments.begin(),
                           [&](const std::string& text) { return replace_all(text, "FOLDER", folder.path().string()); });
    const ThreadLimit limit(call.program, allowed);
    const auto ended = run(call.program, arguments, folder.path());
    ASSERT_TRUE(ended) << "still runs";
    has_enough = ended->err.find(call.mentions) == std::string::npos;
    if (has_enough) continue;
    EXPECT_EQ(ended->exit_code, 1) << allowed;
    const std::vector<std::string> error_lines = error_lines_of(ended->err);
    EXPECT_EQ(std::ranges::count_if(error_lines, [&](const std::string& line) { return line.find(call.mentions) != line.npos; }), 1);
    EXPECT_THAT(error_lines.back(), ::testing::HasSubstr(call.mentions)) << "nothing comes after it";
  }
  EXPECT_GT(allowed, 1) << "it was never short of threads";
}

const std::vector<BadCall> kThreaded = {
    {"IoNode",
     "io_node",
     {"--bind", "127.0.0.1:0", "--seconds", "0.2", "--rt", "off", "--watchdog", "off", "--metrics", "127.0.0.1:0", "--vrpn", "127.0.0.1:0",
      "--record", "FOLDER/record"},
     "cannot start another thread"},
    {"HapticsNode",
     "haptics_node",
     {"--scene", HAPTON_SOURCE_DIR "/scenes/car_front.toml", "--hub", "127.0.0.1:9", "--seconds", "0.2", "--rt", "off"},
     "cannot start another thread"},
    {"HaptonGovernor", "hapton", {"governor", "--threads", "3", "--steps", "1000"}, "cannot start another thread"},
    {"HaptonStress", "hapton", {"stress", "--threads", "3", "--steps", "100", "--body", "box"}, "cannot start another thread"},
};
INSTANTIATE_TEST_SUITE_P(Programs, FewThreads, ::testing::ValuesIn(kThreaded),
                         [](const ::testing::TestParamInfo<BadCall>& call) { return call.param.name; });

// The watchdog process reports this and ends; io_node continues without it, as requested.
TEST(FewThreadsAlone, TheWatchdogSaysSo) {
  const TestFolder folder;
  const ThreadLimit limit("hapton_watchdog", 0);
  const auto ended = run("io_node", {"--bind", "127.0.0.1:0", "--seconds", "3", "--rt", "off"}, folder.path());
  ASSERT_TRUE(ended) << "still runs";
  EXPECT_EQ(ended->exit_code, 0) << ended->err;
  EXPECT_THAT(ended->err, ::testing::HasSubstr("hapton_watchdog: cannot start another thread"));
  EXPECT_THAT(ended->err, ::testing::HasSubstr("the watchdog process had ended"));
}
#endif

TEST(HaptonAlone, ListsItsCommandsAndFails) {
  const TestFolder folder;
  const auto ended = run("hapton", {}, folder.path());
  ASSERT_TRUE(ended) << "still runs";
  EXPECT_NE(ended->exit_code, 0);
  EXPECT_LT(ended->exit_code, 126);
  EXPECT_THAT(ended->out + ended->err, ::testing::HasSubstr("replay"));
}

const std::vector<std::string> kPrograms = {
    "io_node",
    "haptics_node",
    "hapton",
#ifdef HAPTON_WITH_VISION
    "vision_node",
#endif
};

std::string program_name(const ::testing::TestParamInfo<std::string>& program) { return program.param; }

INSTANTIATE_TEST_SUITE_P(Programs, Help, ::testing::ValuesIn(kPrograms), program_name);
INSTANTIATE_TEST_SUITE_P(Programs, FewDescriptors, ::testing::ValuesIn(kPrograms), program_name);
INSTANTIATE_TEST_SUITE_P(Programs, Version, ::testing::ValuesIn(kPrograms), program_name);

}  // namespace
}  // namespace hapton::process
