// The real vision_node with the OpenXR loader and the mock runtime (xr/mock_runtime.cpp).
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <optional>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/math/turn_by_degrees.h"
#include "tests/support/one_line.h"
#include "tests/support/patience.h"
#include "tests/support/scratch_folder.h"
#include "tests/vision_node/made_views.h"
#include "tests/vision_node/xr/mock_views.h"
#include "vision_node/display.h"

// Last, because it defines X's macros.
#include "tests/vision_node/window_person.h"

namespace hapton {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr PictureSize kHeadsetPicture{800, 880};
const std::array<Vec3, 3> kSpots = {Vec3(-0.08, 0.03, 0.05), Vec3(0.01, -0.02, 0.0), Vec3(0.09, 0.05, -0.1)};

std::string read_all(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

Picture read_ppm(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string kind;
  int max_value = 0;
  Picture picture;
  in >> kind >> picture.size.width_px >> picture.size.height_px >> max_value;
  in.get();
  const std::size_t row = 3 * static_cast<std::size_t>(std::max(0, picture.size.width_px));
  picture.rgb.resize(row * static_cast<std::size_t>(std::max(0, picture.size.height_px)));
  for (int y = picture.size.height_px - 1; y >= 0; --y) {
    in.read(reinterpret_cast<char*>(&picture.rgb[row * static_cast<std::size_t>(y)]), static_cast<std::streamsize>(row));
  }
  return picture;
}

// Middle of the pixels in which this channel is much brighter than the other two.
std::optional<Vec2> middle_of(const Picture& picture, int channel) {
  Vec2 sum = Vec2::Zero();
  int count = 0;
  for (int y = 0; y < picture.size.height_px; ++y) {
    for (int x = 0; x < picture.size.width_px; ++x) {
      const std::uint8_t* pixel = picture.at(x, y);
      const int others = std::max(pixel[(channel + 1) % 3], pixel[(channel + 2) % 3]);
      if (pixel[channel] < 40 || 10 * pixel[channel] < 16 * others) continue;
      sum += Vec2(x + 0.5, y + 0.5);
      ++count;
    }
  }
  return count > 0 ? std::optional<Vec2>(sum / count) : std::nullopt;
}

// Where an eye sees a point, from the tangents of its angles alone.
Vec2 project(const EyeInFrame& eye, const Vec3& p_L) {
  const Vec3 p_E = eye.X_FE.inverse() * p_L;
  const double l = std::tan(eye.fov.left_rad), r = std::tan(eye.fov.right_rad), u = std::tan(eye.fov.up_rad),
               d = std::tan(eye.fov.down_rad);
  return {(p_E.x() / -p_E.z() - l) / (r - l) * kHeadsetPicture.width_px, (p_E.y() / -p_E.z() - d) / (u - d) * kHeadsetPicture.height_px};
}

struct XrRun {
  int code = -1;
  std::string output;
  std::string log;  // the runtime's
  int lines() const { return static_cast<int>(std::count(output.begin(), output.end(), '\n')); }
  // The output without notices, and without the line break at the end.
  std::string problem() const {
    std::string problem_lines;
    std::istringstream text(output);
    for (std::string line; std::getline(text, line);) {
      if (line.find("  info  ") == std::string::npos) problem_lines += (problem_lines.empty() ? "" : "\n") + line;
    }
    return problem_lines;
  }
};

class OpenXrProgram : public testing::Test {
 protected:
  void SetUp() override {
    std::string scene;
    for (std::size_t i = 0; i < kSpots.size(); ++i) {
      const auto marker = make_marker(kSpots[i], 0.008);
      std::string obj;
      for (const Vec3& v : marker->vertices) obj += fmt::format("v {:.9f} {:.9f} {:.9f}\n", v.x(), v.y(), v.z());
      for (const auto& t : marker->triangles) obj += fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
      scratch_.write(fmt::format("{}.obj", i), obj);
      scene += fmt::format("[[object]]\nmesh = \"{}.obj\"\ncolor = [{}, {}, {}]\n", i, i == 0 ? 1 : 0, i == 1 ? 1 : 0, i == 2 ? 1 : 0);
    }
    scratch_.write("scene.toml", scene);
    scratch_.write("runtime.json", R"({"file_format_version": "1.0.0", "runtime": {"library_path": ")" HAPTON_MOCK_XR_LIBRARY R"("}})");
    std::filesystem::create_directory(out());
  }

  std::filesystem::path out() const { return scratch_.path() / "out"; }

  std::string command(const std::string& mock, const std::string& arguments, const std::string& runtime) const {
    return fmt::format(
        "cd {} && XDG_CONFIG_HOME={} XDG_CONFIG_DIRS={} {} HAPTON_MOCK_XR=out={},width={},height={},{} " HAPTON_BIN_DIR
        "/vision_node --stereo openxr --scene scene.toml --no-depth-cues --no-keys-help --size 320x180 --hub 127.0.0.1:9 {} 2>&1",
        scratch_.path().string(), scratch_.path().string(), scratch_.path().string(), runtime, out().string(), kHeadsetPicture.width_px,
        kHeadsetPicture.height_px, mock, arguments);
  }
  std::string mock_runtime_environment() const { return "XR_RUNTIME_JSON=" + (scratch_.path() / "runtime.json").string(); }

  // mock: settings of the mock runtime, as mock_runtime.cpp reads them.
  XrRun run(const std::string& mock, const std::string& arguments = "--offscreen", const std::optional<std::string>& runtime = {}) const {
    return finish(popen(command(mock, arguments, runtime.value_or(mock_runtime_environment())).c_str(), "r"));
  }
  XrRun finish(FILE* pipe) const {
    XrRun run;
    if (pipe == nullptr) return run;
    char buffer[512];
    while (std::fgets(buffer, sizeof buffer, pipe) != nullptr) run.output += buffer;
    const int status = pclose(pipe);
    run.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128;
    run.log = read_all(out() / "log");
    return run;
  }

  // X_LW: the workspace in the space of the eyes.
  void expect_frame(int frame, const std::array<EyeInFrame, 2>& eyes, const Pose& X_LW) const {
    for (std::size_t eye = 0; eye < 2; ++eye) {
      const Picture picture = read_ppm(out() / fmt::format("frame_{:03}_{}.ppm", frame, eye));
      ASSERT_EQ(picture.size, kHeadsetPicture) << "frame " << frame;
      for (int spot = 0; spot < 3; ++spot) {
        const Vec2 theory = project(eyes[eye], X_LW * kSpots[static_cast<std::size_t>(spot)]);
        const auto found = middle_of(picture, spot);
        ASSERT_TRUE(found) << "frame " << frame << " eye " << eye << " spot " << spot << " expected at " << theory.transpose();
        EXPECT_LT((*found - theory).norm(), 0.5)
            << "frame " << frame << " eye " << eye << " spot " << spot << ": " << found->transpose() << ", expected " << theory.transpose();
      }
    }
  }

  const ScratchFolder scratch_;
};

TEST_F(OpenXrProgram, EachEyeSeesEveryPointWithinHalfAPixelOfItsProjection) {
  const XrRun run = this->run("exit_after=4", "--offscreen --workspace-m 0.03,-0.2,-0.55 --workspace-turn-deg 10,25,-5");
  EXPECT_EQ(run.code, 0) << run.output;
  const Pose X_LW = Eigen::Translation3d(0.03, -0.2, -0.55) * Pose(turn_by_degrees({10.0, 25.0, -5.0}));
  for (int frame = 0; frame < 4; ++frame) expect_frame(frame, mock_xr::eyes_at(frame), X_LW);
  // 0x8c43 is GL_SRGB8_ALPHA8.
  EXPECT_EQ(
      run.log,
      "format 0x8c43\nformat 0x8c43\nbegun\nframe 0 layers 1\nframe 1 layers 1\nframe 2 layers 1\nframe 3 layers 1\nended\ndestroyed\n");
  EXPECT_NE(run.output.find("the OpenXR runtime has ended the session"), std::string::npos) << run.output;
}

// The plates are dark, with letters on them. Each eye must see them at their depth: their shift between the eyes depends on that depth.
TEST_F(OpenXrProgram, TheTextsStandBehindTheWorkspaceForBothEyes) {
  const XrRun run = this->run("exit_after=3", "--offscreen --workspace-m 0,-0.2,-0.55");
  EXPECT_EQ(run.code, 0) << run.output;
  const Pose X_LW(Eigen::Translation3d(0.0, -0.2, -0.55));
  const auto eyes = mock_xr::eyes_at(2);
  for (std::size_t eye = 0; eye < 2; ++eye) {
    const Picture picture = read_ppm(out() / fmt::format("frame_002_{}.ppm", eye));
    ASSERT_EQ(picture.size, kHeadsetPicture);
    // The lower left corner of the facts, and a point above their upper edge, in the middle of the workspace.
    const Vec2 corner = project(eyes[eye], X_LW * Vec3(-0.19, 0.11, -0.19));
    const Vec2 far_corner = project(eyes[eye], X_LW * Vec3(0.0, 0.13, -0.19));
    int plate_pixels = 0;
    int letter_pixels = 0;
    int leftmost = kHeadsetPicture.width_px;
    for (int y = static_cast<int>(far_corner.y()); y < static_cast<int>(corner.y()) + 10; ++y) {  // from the top; the plate is tilted
      for (int x = static_cast<int>(corner.x()) - 60; x < static_cast<int>(far_corner.x()); ++x) {
        const std::uint8_t* rgb = picture.at(x, y);
        letter_pixels += std::min({rgb[0], rgb[1], rgb[2]}) > 120 ? 1 : 0;
        if (std::max({rgb[0], rgb[1], rgb[2]}) > 30) continue;  // the background is lighter
        ++plate_pixels;
        leftmost = std::min(leftmost, x);
      }
    }
    EXPECT_GT(plate_pixels, 100) << "eye " << eye;
    EXPECT_GT(letter_pixels, 8) << "eye " << eye;
    EXPECT_NEAR(leftmost, corner.x(), 3.0) << "eye " << eye;
  }
}

// Looks for the frame of the upper curve, at the right of the workspace: light lines. Without --plots there is only the background.
TEST_F(OpenXrProgram, TheCurvesStandBesideTheWorkspaceForBothEyes) {
  const Pose X_LW(Eigen::Translation3d(-0.2, -0.2, -0.75));
  const auto eyes = mock_xr::eyes_at(2);
  for (const bool has_plots : {true, false}) {
    const XrRun run = this->run("exit_after=3", std::string("--offscreen --workspace-m -0.2,-0.2,-0.75") + (has_plots ? " --plots" : ""));
    EXPECT_EQ(run.code, 0) << run.output;
    for (std::size_t eye = 0; eye < 2; ++eye) {
      const Picture picture = read_ppm(out() / fmt::format("frame_002_{}.ppm", eye));
      ASSERT_EQ(picture.size, kHeadsetPicture);
      // The lower left and the upper right corner of the upper frame.
      const Vec2 low = project(eyes[eye], X_LW * Vec3(0.1448, 0.0139, -0.19));
      const Vec2 high = project(eyes[eye], X_LW * Vec3(0.2672, 0.0607, -0.19));
      ASSERT_TRUE(low.minCoeff() > 5.0 && high.x() < kHeadsetPicture.width_px - 5 && high.y() < kHeadsetPicture.height_px - 5)
          << low << " " << high;
      int light_pixels = 0;
      for (int y = static_cast<int>(low.y()) - 4; y < static_cast<int>(high.y()) + 4; ++y) {
        for (int x = static_cast<int>(low.x()) - 4; x < static_cast<int>(high.x()) + 4; ++x) {
          const std::uint8_t* rgb = picture.at(x, y);
          light_pixels += std::min({rgb[0], rgb[1], rgb[2]}) > 90 ? 1 : 0;
        }
      }
      if (has_plots) {
        EXPECT_GT(light_pixels, 2.0 * (high.x() - low.x())) << "eye " << eye;
      } else {
        EXPECT_EQ(light_pixels, 0) << "eye " << eye;
      }
    }
  }
}

TEST_F(OpenXrProgram, OnAStageTheWorkspaceStandsAboveTheFloor) {
  const XrRun run = this->run("exit_after=2", "--offscreen --room stage");
  EXPECT_EQ(run.code, 0) << run.output;
  auto eyes = mock_xr::eyes_at(1);
  for (EyeInFrame& eye : eyes) eye.X_FE.pretranslate(mock_xr::kLocalInStage);
  expect_frame(1, eyes, Pose(Eigen::Translation3d(0.0, 1.0, -0.5)));
}

TEST_F(OpenXrProgram, ARuntimeWithoutSrgbGetsTheSameBytes) {
  const std::array<std::filesystem::path, 2> frames = {out() / "frame_000_0.ppm", out() / "frame_000_1.ppm"};
  const XrRun srgb = run("exit_after=1");
  ASSERT_EQ(srgb.code, 0) << srgb.output;
  std::array<std::string, 2> expected;
  for (std::size_t eye = 0; eye < 2; ++eye) {
    ASSERT_EQ(read_ppm(frames[eye]).size, kHeadsetPicture) << "eye " << eye;
    expected[eye] = read_all(frames[eye]);
  }
  std::filesystem::remove_all(out());  // what is there later is from the second run
  std::filesystem::create_directory(out());
  const XrRun linear = run("exit_after=1,linear");
  EXPECT_EQ(linear.code, 0) << linear.output;
  // GL_RGBA8.
  EXPECT_TRUE(linear.log.starts_with("format 0x8058\nformat 0x8058\n")) << linear.log;
  for (std::size_t eye = 0; eye < 2; ++eye) EXPECT_TRUE(read_all(frames[eye]) == expected[eye]) << "eye " << eye;
}

TEST_F(OpenXrProgram, TheEndOfTheProgramEndsTheSessionInOrder) {
  const std::string picture = (scratch_.path() / "a.png").string();
  const XrRun run = this->run("stop_after=3", "--offscreen --screenshot " + picture);
  EXPECT_EQ(run.code, 0) << run.output;
  EXPECT_EQ(run.log.find("wrong"), std::string::npos) << run.log;
  EXPECT_TRUE(std::regex_search(run.log, std::regex("layers 1\nasked to end\n(frame \\d+ layers 0\n)*ended\ndestroyed\n$"))) << run.log;
  // The width in the IHDR chunk: both eyes are beside each other.
  const std::string png = read_all(picture);
  ASSERT_GT(png.size(), 24u);
  EXPECT_EQ(static_cast<unsigned char>(png[18]) * 256 + static_cast<unsigned char>(png[19]), 2 * kHeadsetPicture.width_px);
}

TEST_F(OpenXrProgram, AfterTheLossOfTheRuntimeTheWindowGoesOnInMono) {
  const std::string picture = (scratch_.path() / "a.png").string();
  const XrRun run = this->run("lose_after=3,stop_ms=500", "--offscreen --screenshot " + picture);
  EXPECT_EQ(run.code, 0) << run.output;
  const std::string line = "the headset is lost (xrWaitFrame: XR_ERROR_INSTANCE_LOST); the window goes on in mono";
  const std::size_t at = run.output.find(line);
  ASSERT_NE(at, std::string::npos) << run.output;
  EXPECT_EQ(run.output.find("headset is lost", at + line.size()), std::string::npos) << "once";
  EXPECT_EQ(run.log.find("frame 3"), std::string::npos) << run.log;
  const std::string png = read_all(picture);
  ASSERT_GT(png.size(), 24u);
  EXPECT_EQ(static_cast<unsigned char>(png[18]) * 256 + static_cast<unsigned char>(png[19]), 320) << "the window's own width";
}

TEST_F(OpenXrProgram, WhicheverCallFailsTheProgramGoesOnAndNamesIt) {
  for (const char* call : {"xrPollEvent", "xrBeginFrame", "xrLocateViews", "xrAcquireSwapchainImage", "xrWaitSwapchainImage",
                           "xrReleaseSwapchainImage", "xrEndFrame"}) {
    const XrRun run = this->run(fmt::format("lose_after=2,stop_ms=100,lose_in={}", call));
    EXPECT_EQ(run.code, 0) << call << ": " << run.output;
    EXPECT_NE(run.output.find(fmt::format("the headset is lost ({}: XR_ERROR_INSTANCE_LOST)", call)), std::string::npos) << run.output;
  }
  const XrRun warned = run("pending_after=2,stop_ms=100");
  EXPECT_EQ(warned.code, 0) << warned.output;
  EXPECT_NE(warned.output.find("the headset is lost (the runtime is about to end)"), std::string::npos) << warned.output;
}

TEST_F(OpenXrProgram, FramesThatNobodySeesAreEmptyAndAnUnknownPoseIsTheLastKnownOne) {
  const XrRun run = this->run("exit_after=10,hide_from=2,hide_to=4,blind_from=5,blind_to=7,crooked_from=8,crooked_to=9");
  EXPECT_EQ(run.code, 0) << run.output;
  EXPECT_NE(run.output.find("the headset does not show the scene at present"), std::string::npos) << run.output;
  for (int frame = 0; frame < 10; ++frame) {
    const std::string line = fmt::format("frame {} layers {}\n", frame, frame == 2 || frame == 3 ? 0 : 1);
    EXPECT_NE(run.log.find(line), std::string::npos) << line << run.log;
  }
  EXPECT_EQ(run.log.find("wrong"), std::string::npos) << run.log;
  const Pose X_LW(Eigen::Translation3d(0.0, -0.25, -0.5));
  expect_frame(4, mock_xr::eyes_at(4), X_LW);
  expect_frame(6, mock_xr::eyes_at(4), X_LW);
  expect_frame(8, mock_xr::eyes_at(7), X_LW);
  expect_frame(9, mock_xr::eyes_at(9), X_LW);
}

TEST_F(OpenXrProgram, HomeBringsTheWorkspaceBeforeTheViewerAndArrowsMoveTheViewer) {
  constexpr int kStillFrame = 4;
  // Windows of earlier tests are gone only after this: Person finds the window by its name alone.
  XSync(static_cast<Display*>(DisplayConnection::open()->id()), False);
  const std::string arguments = fmt::format("--seconds 100 --screenshot {}", (scratch_.path() / "a.png").string());
  FILE* const pipe = popen(command(fmt::format("still={}", kStillFrame), arguments, mock_runtime_environment()).c_str(), "r");
  ASSERT_NE(pipe, nullptr);
  const auto frames = [&] {
    const std::string log = read_all(out() / "log");
    return static_cast<int>(std::count(log.begin(), log.end(), '\n')) - 3;  // without two formats and "begun"
  };
  ASSERT_TRUE(wait_until([&] { return frames() >= 2; }));
  Person person;
  ASSERT_TRUE(person.has_window());
  person.press_key(XK_Home);
  person.press_key(XK_Right);
  person.press_key(XK_Right);
  const int pressed = frames();
  ASSERT_TRUE(wait_until([&] { return frames() >= pressed + 4; }));
  person.press_key(XK_q);
  const XrRun run = finish(pipe);
  EXPECT_EQ(run.code, 0) << run.output;
  const Pose X_LO = find_viewer_origin(mock_xr::head_at(kStillFrame), RoomSpace::local);
  expect_frame(0, mock_xr::eyes_at(kStillFrame), Pose(Eigen::Translation3d(0.0, -0.25, -0.5)));
  expect_frame(pressed + 3, mock_xr::eyes_at(kStillFrame), X_LO * Eigen::Translation3d(-0.02, -0.25, -0.5));
}

TEST_F(OpenXrProgram, WhatIsMissingIsOneLineAndTheEnd) {
  const std::pair<const char*, const char*> cases[] = {
      {"no_headset", "the OpenXR runtime finds no headset; connect it"},
      {"no_opengl", "the OpenXR runtime does not support OpenGL"},
      {"opengl_9", "the OpenXR runtime needs OpenGL 9.2, and this display has"},
  };
  for (const auto& [word, line] : cases) {
    const XrRun run = this->run(word);
    EXPECT_EQ(run.code, 1) << word;
    EXPECT_THAT(run.problem(), AllOf(HasSubstr(line), IsOneLine())) << word;
    EXPECT_EQ(run.output.find("frames drawn"), std::string::npos) << run.output;
  }
  const XrRun no_floor = run("no_stage", "--offscreen --room stage");
  EXPECT_EQ(no_floor.code, 1);
  EXPECT_THAT(no_floor.problem(), AllOf(HasSubstr("does not know where the floor is"), IsOneLine()));
}

TEST_F(OpenXrProgram, WithoutARuntimeItSaysHowToGetOne) {
  const XrRun broken = run("", "--offscreen", "XR_RUNTIME_JSON=/nowhere/runtime.json");
  EXPECT_EQ(broken.code, 1);
  EXPECT_EQ(broken.lines(), 1) << broken.output;
  EXPECT_NE(broken.output.find("the OpenXR runtime of XR_RUNTIME_JSON=/nowhere/runtime.json cannot be loaded"), std::string::npos)
      << broken.output;
  const XrRun none = run("", "--offscreen", "");
  if (none.code == 0 || none.lines() != 1) GTEST_SKIP() << "this machine has a runtime";
  EXPECT_EQ(none.code, 1);
  EXPECT_NE(none.output.find("no OpenXR runtime is active on this machine"), std::string::npos) << none.output;
}

TEST_F(OpenXrProgram, WhatContradictsAHeadsetIsOneLine) {
  for (const char* flags : {"--screen-width-mm 500", "--head spacemouse", "--bench-frames 5"}) {
    const XrRun run = this->run("", fmt::format("--offscreen {}", flags));
    EXPECT_EQ(run.code, 2) << flags;
    EXPECT_EQ(run.lines(), 1) << run.output;
    EXPECT_NE(run.output.find("--stereo openxr: "), std::string::npos) << run.output;
  }
}

}  // namespace
}  // namespace hapton
