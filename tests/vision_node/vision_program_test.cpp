#include <sys/wait.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <sstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scene/scene_file.h"
#include "scene/scene_loading.h"
#include "tests/recording/made_recording.h"
#include "tests/support/one_line.h"
#include "tests/support/scratch_folder.h"

namespace {

using hapton::IsOneLine;
using hapton::load_scene;
using hapton::MadeRecording;
using hapton::MeshFit;
using hapton::SceneLoading;
using hapton::ScratchFolder;
using hapton::to_code;
using hapton::Unit;
using testing::AllOf;
using testing::HasSubstr;

struct VisionRun {
  int code = -1;
  std::string output;
};

// Runs the program vision_node. output: what it wrote to stdout and stderr.
VisionRun run_vision(const std::string& arguments, const std::string& environment = "") {
  const std::string command = "cd " HAPTON_SOURCE_DIR " && " + environment + " " HAPTON_BIN_DIR "/vision_node " + arguments + " 2>&1";
  VisionRun run;
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return run;
  char buffer[512];
  while (std::fgets(buffer, sizeof buffer, pipe) != nullptr) run.output += buffer;
  const int status = pclose(pipe);
  run.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128;
  return run;
}

// What it wrote without notices, and without the line break at the end.
std::string problem_of(const VisionRun& run) {
  std::string problem;
  std::istringstream text(run.output);
  for (std::string line; std::getline(text, line);) {
    if (line.find("  info  ") == std::string::npos) problem += (problem.empty() ? "" : "\n") + line;
  }
  return problem;
}

TEST(VisionProgram, WithoutADisplayItSaysSoInOneLineAndEnds) {
  const VisionRun run = run_vision("--scene meshes/car_front_3300.obj", "DISPLAY=");
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(problem_of(run), AllOf(HasSubstr("no display"), HasSubstr("xvfb-run"), IsOneLine()));
}

TEST(VisionProgram, CrystalEyesWithoutQuadBufferSaysSoAndEnds) {
  const VisionRun run = run_vision("--scene meshes/car_front_3300.obj --stereo crystal_eyes --seconds 0.5 --offscreen");
  if (run.code == 0) GTEST_SKIP() << "this display has quad-buffered stereo";
  EXPECT_EQ(run.code, 1);
  EXPECT_NE(run.output.find("quad-buffered"), std::string::npos) << run.output;
}

// Such a picture would take a renderer on the processor longer than a person waits: it is not even begun.
TEST(VisionProgram, APictureThatIsTooLargeIsOneLine) {
  const VisionRun run = run_vision("--scene meshes/car_front_3300.obj --offscreen --size 16384x16384 --seconds 0.1");
  if (run.code == 0) GTEST_SKIP() << "this renderer draws it";
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(problem_of(run), AllOf(HasSubstr("--size 16384x16384: "), IsOneLine()));
  EXPECT_EQ(run.output.find("frames drawn"), std::string::npos) << run.output;
}

TEST(VisionProgram, MissingSceneIsOneLine) {
  const VisionRun run = run_vision("--scene nowhere.toml");
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(problem_of(run), AllOf(HasSubstr("nowhere.toml"), IsOneLine()));
}

// The screen is 4:3; the windows are 16:9 and 4:3.
TEST(VisionProgram, AWindowOfAnotherShapeThanTheScreenIsReported) {
  const ScratchFolder scratch;
  scratch.write("screen.toml",
                "schema = \"hapton.screen/1\"\nposition_m = [0, 0, -0.1]\nrotation = [1, 0, 0, 0]\nwidth_m = 0.32\nheight_m = 0.24\n");
  const std::string file = (scratch.path() / "screen.toml").string();
  const std::string picture = (scratch.path() / "a.png").string();
  const std::string arguments = "--scene meshes/car_front_3300.obj --offscreen --seconds 0.3 --hub 127.0.0.1:9 --screenshot " + picture +
                                " --screen " + file + " --size ";
  const VisionRun wide = run_vision(arguments + "320x180");
  EXPECT_EQ(wide.code, 0) << wide.output;
  EXPECT_NE(wide.output.find("the picture has 320x180 pixels, and the screen of --screen 320 x 240 mm"), std::string::npos) << wide.output;
  const VisionRun fits = run_vision(arguments + "320x240");
  EXPECT_EQ(fits.code, 0) << fits.output;
  EXPECT_EQ(fits.output.find("the picture has"), std::string::npos) << fits.output;
  EXPECT_TRUE(std::filesystem::exists(picture));
}

TEST(VisionProgram, SaysThatAScenesCameraDoesNotApply) {
  const ScratchFolder scratch;
  const std::string object = "[[object]]\nmesh = '" HAPTON_SOURCE_DIR "/meshes/car_front_3300.obj'\n";
  const std::string scene =
      scratch.write("a.toml", object + "[camera]\nposition_m = [0, 1, 2]\n[[light]]\ndirection = [0, -1, -1]\n").string();
  const std::string arguments = "--offscreen --size 320x180 --seconds 0.3 --hub 127.0.0.1:9 --screenshot " +
                                (scratch.path() / "a.png").string() + " --scene " + scene;
  const std::string line = "the scene's [camera] does not apply, because --screen-width-mm says from where it is seen";
  const VisionRun without = run_vision(arguments);
  EXPECT_EQ(without.code, 0) << without.output;
  EXPECT_EQ(without.output.find("[camera]"), std::string::npos) << without.output;
  const VisionRun with = run_vision(arguments + " --screen-width-mm 520");
  EXPECT_EQ(with.code, 0) << with.output;
  EXPECT_NE(with.output.find(line), std::string::npos) << with.output;
}

TEST(VisionProgram, AScreenFileThatIsWrongIsOneLine) {
  const ScratchFolder scratch;
  scratch.write("screen.toml",
                "schema = \"hapton.screen/1\"\nposition_m = [0, 0, 0]\nrotation = [1, 0, 0, 0]\nwidth_m = 520\nheight_m = 0.3\n");
  const std::string file = (scratch.path() / "screen.toml").string();
  const VisionRun run = run_vision("--scene meshes/car_front_3300.obj --offscreen --screen " + file);
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(problem_of(run),
              AllOf(HasSubstr("--screen " + file + ": line 4: 'width_m' in the file is 520: it must be at least 0.02 and at most 100"),
                    IsOneLine()));
}

TEST(VisionProgram, BadHubIsOneLine) {
  const VisionRun run = run_vision("--scene meshes/car_front_3300.obj --offscreen --hub 127.0.0.1:99999");
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(problem_of(run), AllOf(HasSubstr("99999"), IsOneLine()));
}

TEST(VisionProgram, WritesAScreenshotWithoutAPerson) {
  const auto file = std::filesystem::temp_directory_path() / ("hapton_program_" + std::to_string(getpid()) + ".png");
  const VisionRun run = run_vision("--scene meshes/car_front_3300.obj --size 320x180 --seconds 0.5 --screenshot " + file.string());
  EXPECT_NE(run.output.find("shows no contact: no hub replied before the end"), std::string::npos) << run.output;
  EXPECT_EQ(run.code, 0) << run.output;
  EXPECT_TRUE(std::filesystem::exists(file));
  EXPECT_NE(run.output.find("frames drawn"), std::string::npos);
  std::filesystem::remove(file);
}

TEST(VisionProgram, ScreenshotThatCannotBeWrittenFails) {
  const VisionRun run =
      run_vision("--scene meshes/car_front_3300.obj --offscreen --size 320x180 --seconds 0.3 --screenshot /nowhere/a.png");
  EXPECT_EQ(run.code, 1);
  EXPECT_NE(run.output.find("/nowhere/a.png"), std::string::npos) << run.output;
}

TEST(VisionProgram, AScreenshotIsCheckedBeforeAnythingIsShown) {
  const std::string picture = (std::filesystem::temp_directory_path() / ("hapton_program_" + std::to_string(getpid()) + ".jpg")).string();
  for (const std::string& name : {std::string("/nowhere/a.png"), picture}) {
    const VisionRun run = run_vision("--scene meshes/car_front_3300.obj --offscreen --size 320x180 --seconds 60 --screenshot " + name);
    EXPECT_EQ(run.code, 1);
    EXPECT_NE(run.output.find(name), std::string::npos) << run.output;
    EXPECT_FALSE(std::filesystem::exists(name));
  }
}

// Without this error, the scene would be shown for a minute, and then the picture would be lost.
TEST(VisionProgram, AFolderAsScreenshotIsRejected) {
  const auto folder = std::filesystem::temp_directory_path() / ("hapton_program_" + std::to_string(getpid()) + "_folder.png");
  std::filesystem::create_directory(folder);
  const VisionRun run =
      run_vision("--scene meshes/car_front_3300.obj --offscreen --size 320x180 --seconds 60 --screenshot " + folder.string());
  EXPECT_EQ(run.code, 1);
  EXPECT_NE(run.output.find("it is a folder; give the name of a file"), std::string::npos) << run.output;
  std::filesystem::remove(folder);
}

TEST(VisionProgram, WithoutAHubItSaysSoAndFails) {
  const VisionRun run = run_vision("--scene meshes/car_front_3300.obj --offscreen --size 320x180 --seconds 5 --hub 127.0.0.1:9");
  EXPECT_EQ(run.code, 1);
  EXPECT_NE(run.output.find("no hub replies"), std::string::npos) << run.output;
  EXPECT_NE(run.output.find("no hub at "), std::string::npos) << run.output;
}

TEST(VisionProgram, BenchSaysItsRate) {
  const auto begin = std::chrono::steady_clock::now();
  const VisionRun run = run_vision("--scene meshes/car_front_3300.obj --offscreen --size 320x180 --bench-frames 5");
  const double elapsed_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
  EXPECT_EQ(run.code, 0) << run.output;
  const std::size_t at = run.output.find("bench: ");
  ASSERT_NE(at, std::string::npos) << run.output;
  int frames = 0;
  double rate_hz = 0.0;
  ASSERT_EQ(std::sscanf(run.output.c_str() + at, "bench: %d %*[a-z], %lf Hz", &frames, &rate_hz), 2) << run.output;
  EXPECT_EQ(frames, 5);
  const std::size_t drawing = run.output.find("drawing p50 ", at);
  ASSERT_NE(drawing, std::string::npos) << run.output;
  double p50_ms = 0.0;
  double p99_ms = 0.0;
  ASSERT_EQ(std::sscanf(run.output.c_str() + drawing, "drawing p50 %lf ms p99 %lf ms", &p50_ms, &p99_ms), 2) << run.output;
  EXPECT_GT(p50_ms, 0.0);
  EXPECT_GE(p99_ms, p50_ms);
  const std::size_t motion = run.output.find("first frame ", at);
  ASSERT_NE(motion, std::string::npos) << run.output;
  double first_ms = 0.0;
  double motion_p50_ms = 0.0;
  double motion_p50_frames = 0.0;
  ASSERT_EQ(std::sscanf(run.output.c_str() + motion, "first frame %lf ms, motion to photon p50 %lf ms p99 %*f ms (%lf, %*f frames)",
                        &first_ms, &motion_p50_ms, &motion_p50_frames),
            3)
      << run.output;
  EXPECT_GT(first_ms, 0.0);
  EXPECT_GT(motion_p50_ms, 0.0);
  EXPECT_LT(motion_p50_frames, 1.5) << run.output;
  // Frames are drawn one after the other, so the mean interval between them is at most the time of the whole run, and not much less than
  // the time that drawing one frame takes.
  EXPECT_GT(rate_hz, 0.0);
  EXPECT_LE(1000.0 / rate_hz, elapsed_ms);
  EXPECT_GE(1000.0 / rate_hz, 0.5 * p50_ms);
}

// Runs the program vision_node on a recording that names its scene.
struct RecordedProgram : testing::Test {
  ScratchFolder scratch;
  MadeRecording recording;
  std::filesystem::path picture = scratch.path() / "a.png";

  RecordedProgram() {
    recording.scene = HAPTON_SOURCE_DIR "/meshes/car_front_3300.obj";
    recording.scene_loading = to_code({.fit = MeshFit::workspace});
  }
  VisionRun show(const std::string& arguments, const std::string& environment = "") {
    return run_vision("--offscreen --size 320x180 --session " + recording.write(scratch).string() + " " + arguments, environment);
  }
};

TEST_F(RecordedProgram, AMomentIsShownWithoutAHub) {
  const VisionRun run = show("--at 2.5 --screenshot " + picture.string());
  EXPECT_EQ(run.code, 0) << run.output;
  EXPECT_TRUE(std::filesystem::exists(picture));
  EXPECT_NE(run.output.find("shown until 2.500 s of the recording"), std::string::npos) << run.output;
  EXPECT_NE(run.output.find("the recording has another scene than the one shown"), std::string::npos) << run.output;
}

TEST_F(RecordedProgram, ItNeedsNoLinkKeyAndMakesNone) {
  const std::string arguments = "--at 2.5 --screenshot " + picture.string();
  const VisionRun without_home = show(arguments, "env -u HOME -u XDG_RUNTIME_DIR");
  EXPECT_EQ(without_home.code, 0) << without_home.output;
  const VisionRun run = show(arguments, "XDG_RUNTIME_DIR=" + scratch.path().string());
  EXPECT_EQ(run.code, 0) << run.output;
  EXPECT_FALSE(std::filesystem::exists(scratch.path() / "hapton"));
}

TEST_F(RecordedProgram, BadInputIsOneLine) {
  const VisionRun outside = show("--at 99");
  EXPECT_EQ(outside.code, 1);
  EXPECT_THAT(problem_of(outside), AllOf(HasSubstr("--at 99: "), HasSubstr("has samples from 0.001 s to 4.000 s"), IsOneLine()));
  recording.scene = "/nowhere/made.toml";
  const VisionRun no_scene = show("--at 1");
  EXPECT_EQ(no_scene.code, 1);
  EXPECT_THAT(problem_of(no_scene), AllOf(HasSubstr("give its present place with --scene FILE"), IsOneLine()));
  EXPECT_EQ(show("--at 2 --scene meshes/car_front_3300.obj --screenshot " + picture.string()).code, 0);
  for (const auto& [arguments, what] : {std::pair{"--session /nowhere.hapton", "/nowhere.hapton: cannot be read"},
                                        {"--session meshes/car_front_3300.obj", "is not a recorded session"},
                                        {"--session a --hub 127.0.0.1", "--hub excludes --session"},
                                        {"--at 2", "--at requires --session"}}) {
    const VisionRun run = run_vision(arguments);
    EXPECT_NE(run.code, 0) << arguments;
    EXPECT_THAT(problem_of(run), AllOf(HasSubstr(what), IsOneLine())) << arguments;
  }
}

// Otherwise the scene in the picture would have another size or place than the scene that was felt.
TEST_F(RecordedProgram, ItsSceneHasTheUnitAndTheFitOfTheHapticsNode) {
  const SceneLoading felt = {.unit = Unit::mm, .fit = MeshFit::off};
  const auto scene = load_scene(recording.scene, felt);
  ASSERT_TRUE(scene) << scene.error().what;
  recording.scene_loading = to_code(felt);
  recording.given_hash = scene->given_hash;
  const VisionRun run = show("--at 2.5 --screenshot " + picture.string());
  EXPECT_EQ(run.code, 0) << run.output;
  EXPECT_EQ(run.output.find("another scene"), std::string::npos) << run.output;
  const VisionRun other = show("--at 2.5 --unit m --screenshot " + picture.string());
  EXPECT_EQ(other.code, 0) << other.output;
  EXPECT_NE(other.output.find("another scene"), std::string::npos) << "the command line counts more: " << other.output;
}

TEST_F(RecordedProgram, WhatIsBeforeADamageIsShownAndTheExitCodeSaysSo) {
  const std::filesystem::path file = recording.write(scratch);
  std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
  const VisionRun run = run_vision("--offscreen --size 320x180 --session " + file.string() + " --at 1 --screenshot " + picture.string());
  EXPECT_EQ(run.code, 1) << run.output;
  EXPECT_NE(run.output.find("is cut short"), std::string::npos) << run.output;
  EXPECT_TRUE(std::filesystem::exists(picture));
}

}  // namespace
