#include "vision_node/vision_options.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/support/option_range.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

std::variant<VisionOptions, int> parse(std::vector<const char*> words) {
  words.insert(words.begin(), "vision_node");
  return parse_vision_options(static_cast<int>(words.size()), words.data());
}

TEST(VisionOptions, DefaultsAreTheDocumentedOnes) {
  const auto parsed = parse({});
  ASSERT_TRUE(std::holds_alternative<VisionOptions>(parsed));
  const auto& options = std::get<VisionOptions>(parsed);
  EXPECT_EQ(options.view.stereo, StereoMode::automatic);
  EXPECT_EQ(options.view.width_px, 1280);
  EXPECT_EQ(options.view.height_px, 720);
  EXPECT_EQ(options.view.msaa, 0);
  EXPECT_TRUE(options.view.cull);
  EXPECT_FALSE(options.culls_open);
  EXPECT_FALSE(options.has_space_knobs);
  EXPECT_FALSE(options.plots);
  EXPECT_TRUE(std::get<VisionOptions>(parse({"--plots"})).plots);
  EXPECT_EQ(options.scene, "scenes/car_front.toml");
}

TEST(VisionOptions, FlagsArrive) {
  const auto parsed = parse({"--stereo",     "dresden",   "--size",   "800x600", "--no-cull",    "--msaa",  "4",
                             "--dial-y-deg", "30",        "--ipd-mm", "60",      "--screenshot", "a.png",   "--screenshot-when",
                             "2.5",          "--seconds", "3",        "--hub",   "box:5000",     "--knobs", "spacemouse"});
  ASSERT_TRUE(std::holds_alternative<VisionOptions>(parsed));
  const auto& options = std::get<VisionOptions>(parsed);
  EXPECT_EQ(options.view.stereo, StereoMode::dresden);
  EXPECT_EQ(options.view.width_px, 800);
  EXPECT_EQ(options.view.height_px, 600);
  EXPECT_FALSE(options.view.cull);
  EXPECT_EQ(options.view.msaa, 4);
  EXPECT_EQ(options.dials_degrees.y(), 30.0);
  EXPECT_EQ(options.ipd_mm, 60.0);
  EXPECT_EQ(options.screenshot, "a.png");
  EXPECT_EQ(options.hub, "box:5000");
  EXPECT_TRUE(options.has_space_knobs);
  EXPECT_EQ(std::get<VisionOptions>(parse({"--unit", "mm"})).loading.unit, Unit::mm);
  EXPECT_TRUE(std::get<VisionOptions>(parse({"--cull-open"})).culls_open);
  EXPECT_EQ(std::get<int>(parse({"--cull-open", "--no-cull"})), 2) << "they contradict each other";
}

TEST(VisionOptions, FramesOfAVideoNeedARecording) {
  const auto parsed = parse({"--session", "a.hapton", "--frames", "b", "--frame-rate", "25"});
  ASSERT_TRUE(std::holds_alternative<VisionOptions>(parsed));
  EXPECT_EQ(std::get<VisionOptions>(parsed).frames, "b");
  EXPECT_EQ(std::get<VisionOptions>(parsed).frame_rate_hz, 25.0);
  for (const auto& words : std::vector<std::vector<const char*>>{{"--frames", "b"},
                                                                 {"--session", "a.hapton", "--frame-rate", "25"},
                                                                 {"--session", "a.hapton", "--frames", "b", "--frame-rate", "0"},
                                                                 {"--session", "a.hapton", "--frames", "b", "--screenshot", "a.png"}}) {
    EXPECT_TRUE(std::holds_alternative<int>(parse(words))) << words.back();
  }
}

// Angles that were given override the scene's camera.
TEST(VisionOptions, KnowWhichAnglesWereGiven) {
  const auto none = std::get<VisionOptions>(parse({}));
  EXPECT_FALSE(none.is_view_yaw_given || none.is_view_pitch_given);
  const auto yaw = std::get<VisionOptions>(parse({"--view-yaw-deg", "-25"}));
  EXPECT_TRUE(yaw.is_view_yaw_given && !yaw.is_view_pitch_given);
  const auto pitch = std::get<VisionOptions>(parse({"--view-pitch-deg", "20"}));
  EXPECT_TRUE(!pitch.is_view_yaw_given && pitch.is_view_pitch_given);
}

TEST(VisionOptions, ASecondHubIsThatOfAnotherHand) {
  const auto one = std::get<VisionOptions>(parse({"--hub", "a"}));
  EXPECT_EQ(one.hub, "a");
  EXPECT_EQ(one.other_hub, "");
  const auto two = std::get<VisionOptions>(parse({"--hub", "a:1", "--hub", "b:2"}));
  EXPECT_EQ(two.hub, "a:1");
  EXPECT_EQ(two.other_hub, "b:2");
}

TEST(VisionOptions, TheHeadArrivesInMetresAndItsFrames) {
  const auto options = std::get<VisionOptions>(
      parse({"--head", "vrpn:Head0@10.0.0.2:3884", "--head-sensor", "2", "--head-mm", "-80,20.5,550", "--head-turn-deg", "0,0,90",
             "--tracker-mm", "0,300,-20", "--tracker-turn-deg", "90,0,90", "--eyes-mm", "0,-80,10", "--screen-width-mm", "520"}));
  EXPECT_LT((options.head.p_RH - Vec3(-0.08, 0.0205, 0.55)).norm(), 1e-15);
  EXPECT_LT((options.head.q_RH * Vec3::UnitX() - Vec3::UnitY()).norm(), 1e-15);
  ASSERT_TRUE(options.head_source.tracker);
  EXPECT_EQ(options.head_source.tracker->device, "Head0");
  EXPECT_EQ(options.head_source.tracker->host, "10.0.0.2:3884");
  EXPECT_EQ(options.head_source.sensor, 2);
  EXPECT_LT((options.head_source.p_BH - Vec3(0.0, -0.08, 0.01)).norm(), 1e-15);
  EXPECT_LT((options.head_source.X_RT.translation() - Vec3(0.0, 0.3, -0.02)).norm(), 1e-15);
  // The turn about x comes first: it takes y to z, which the turn about z leaves as it is.
  EXPECT_LT((options.head_source.X_RT.linear() * Vec3::UnitY() - Vec3::UnitZ()).norm(), 1e-15);
  EXPECT_EQ(options.screen_width_mm, 520.0);
  EXPECT_TRUE(std::get<VisionOptions>(parse({"--head", "spacemouse"})).has_space_head);
  const auto plain = std::get<VisionOptions>(parse({}));
  EXPECT_FALSE(plain.has_space_head);
  EXPECT_FALSE(plain.head_source.tracker);
  EXPECT_EQ(plain.head.p_RH, Vec3(0.0, 0.0, 0.6));
  EXPECT_EQ(plain.screen_width_mm, 0.0);
}

TEST(VisionOptions, AHeadThatSeesNoScreenIsOneLine) {
  for (const char* at : {"0,0,0", "0,0,-600", "0,0,79", "0,200000,600"}) {
    const auto possible = check_head(std::get<VisionOptions>(parse({"--head-mm", at, "--ipd-mm", "60", "--head-turn-deg", "0,90,0"})));
    ASSERT_FALSE(possible) << at;
    EXPECT_NE(possible.error().what.find("--head-mm " + std::string(at)), std::string::npos) << possible.error().what;
    EXPECT_EQ(possible.error().what.find('\n'), std::string::npos);
  }
  EXPECT_TRUE(check_head(std::get<VisionOptions>(parse({"--head-mm", "0,0,81", "--ipd-mm", "60", "--head-turn-deg", "0,90,0"}))));
}

TEST(VisionOptions, AScreenFileSaysWhereTheScreenIs) {
  const ScratchFolder scratch;
  scratch.write("screen.toml",
                "schema = \"hapton.screen/1\"\nposition_m = [0, 0.05, -0.1]\nrotation = [1, 0, 0, 0]\nwidth_m = 0.4\nheight_m = 0.3\n");
  const std::string file = (scratch.path() / "screen.toml").string();
  auto options = std::get<VisionOptions>(parse({"--screen", file.c_str(), "--head-mm", "0,0,500"}));
  ASSERT_TRUE(find_screen(options));
  ASSERT_TRUE(options.screen);
  EXPECT_EQ(options.screen->X_WR.translation(), Vec3(0.0, 0.05, -0.1));
  EXPECT_EQ(options.screen->width_m, 0.4);
  auto plain = std::get<VisionOptions>(parse({}));
  ASSERT_TRUE(find_screen(plain));
  EXPECT_FALSE(plain.screen);
  auto missing = std::get<VisionOptions>(parse({"--screen", "/no/such.toml"}));
  const auto read = find_screen(missing);
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().what.find("--screen /no/such.toml"), 0U) << read.error().what;
}

TEST(VisionOptions, AScreenFileExcludesOtherPlacesOfTheViewer) {
  for (const auto& [option, value] :
       {std::pair{"--view-yaw-deg", "0"}, {"--view-pitch-deg", "0"}, {"--view-mm", "200"}, {"--screen-width-mm", "520"}}) {
    testing::internal::CaptureStderr();
    const auto parsed = parse({"--screen", "screen.toml", option, value});
    const std::string line = testing::internal::GetCapturedStderr();
    ASSERT_TRUE(std::holds_alternative<int>(parsed)) << option;
    EXPECT_NE(std::get<int>(parsed), 0) << option;
    EXPECT_NE(line.find(option), std::string::npos) << line;
    EXPECT_NE(line.find("--screen"), std::string::npos) << line;
    EXPECT_EQ(line.find('\n'), line.size() - 1) << line;
    std::printf("%s", line.c_str());
  }
}

TEST(VisionOptions, WrongOnesEndWithAnErrorCode) {
  for (const auto& words : std::vector<std::vector<const char*>>{{"--stereo", "3d"},
                                                                 {"--knobs", "three"},
                                                                 {"--size", "wide"},
                                                                 {"--size", "1x1"},
                                                                 {"--size", "800x600x24"},
                                                                 {"--size", "4294968320x720"},
                                                                 {"--size", "800x"},
                                                                 {"--msaa", "-1"},
                                                                 {"--ipd-mm", "nan"},
                                                                 {"--seconds", "-5"},
                                                                 {"--screenshot-when", "soon"},
                                                                 {"--frames-per-second-limit", "-2"},
                                                                 {"--hub", "a", "--hub", "b", "--hub", "c"},
                                                                 {"--head", "mouse"},
                                                                 {"--head", "vrpn:Head0"},
                                                                 {"--head-mm", "1,2"},
                                                                 {"--head-mm", "1,2,3,4"},
                                                                 {"--head-mm", "1,2,"},
                                                                 {"--head-mm", "0,0,nan"},
                                                                 {"--head-mm", "0,0,6e9"},
                                                                 {"--head-turn-deg", "up"},
                                                                 {"--head-sensor", "1"},
                                                                 {"--head", "vrpn:a@b", "--head-sensor", "-1"},
                                                                 {"--screen-width-mm", "0"},
                                                                 {"--unheard-of"}}) {
    const auto parsed = parse(words);
    ASSERT_TRUE(std::holds_alternative<int>(parsed)) << words[0];
    EXPECT_NE(std::get<int>(parsed), 0) << words[0];
  }
}

TEST(VisionOptions, TheWorkspaceStandsBeforeTheEyesOrAboveTheFloorOfTheRoom) {
  const auto local = std::get<VisionOptions>(parse({"--stereo", "openxr"}));
  EXPECT_EQ(local.view.stereo, StereoMode::openxr);
  EXPECT_EQ(local.room, RoomSpace::local);
  EXPECT_TRUE(local.X_OW.isApprox(Pose(Eigen::Translation3d(0.0, -0.25, -0.5))));
  const auto stage = std::get<VisionOptions>(parse({"--room", "stage"}));
  EXPECT_EQ(stage.room, RoomSpace::stage);
  EXPECT_TRUE(stage.X_OW.isApprox(Pose(Eigen::Translation3d(0.0, 1.0, -0.5))));
  const auto turned = std::get<VisionOptions>(parse({"--room", "stage", "--workspace-m", "1,2,-3", "--workspace-turn-deg", "0,90,0"}));
  EXPECT_LT((turned.X_OW * Vec3(0.0, 0.0, -1.0) - Vec3(0.0, 2.0, -3.0)).norm(), 1e-12) << "turned to the left";
  for (const char* wrong : {"1,2", "x", "1,2,3,4"}) EXPECT_EQ(std::get<int>(parse({"--workspace-m", wrong})) == 0, false) << wrong;
  EXPECT_NE(std::get<int>(parse({"--room", "view"})), 0);
}

TEST(VisionOptions, AHeadsetKnowsWhereTheEyesAre) {
  EXPECT_TRUE(check_headset(std::get<VisionOptions>(parse({"--stereo", "openxr", "--room", "stage"}))));
  EXPECT_TRUE(check_headset(std::get<VisionOptions>(parse({"--screen-width-mm", "500", "--bench-frames", "3"}))));
  const std::vector<std::vector<const char*>> contradictions = {
      {"--head", "spacemouse"}, {"--head", "vrpn:a@b"}, {"--screen-width-mm", "500"}, {"--bench-frames", "3"}, {"--session", "a.hapton"}};
  for (std::vector<const char*> words : contradictions) {
    words.insert(words.end(), {"--stereo", "openxr"});
    const auto fits = check_headset(std::get<VisionOptions>(parse(words)));
    ASSERT_FALSE(fits) << words[0];
    EXPECT_TRUE(fits.error().what.starts_with("--stereo openxr: ")) << fits.error().what;
  }
}

TEST(VisionOptions, NumbersHaveTheRangesThatHelpNames) {
  const OptionRange<VisionOptions> ranges[] = {
      {"--ipd-mm", "0", "200", "-0.1", "200.1", [](const VisionOptions& o) { return static_cast<double>(o.ipd_mm); }},
      {"--screen-width-mm", "10", "100000", "9", "100001", [](const VisionOptions& o) { return o.screen_width_mm; }},
      {"--view-yaw-deg", "-180", "180", "-180.1", "180.1", [](const VisionOptions& o) { return static_cast<double>(o.view_yaw_deg); }},
      {"--view-pitch-deg", "-89", "89", "-89.1", "89.1", [](const VisionOptions& o) { return static_cast<double>(o.view_pitch_deg); }},
      {"--stylus-lean-deg", "0", "90", "-0.1", "90.1", [](const VisionOptions& o) { return static_cast<double>(o.stylus_lean_deg); }},
      {"--dial-x-deg", "-360", "360", "-361", "361", [](const VisionOptions& o) { return static_cast<double>(o.dials_degrees.x()); }},
      {"--dial-y-deg", "-360", "360", "-361", "361", [](const VisionOptions& o) { return static_cast<double>(o.dials_degrees.y()); }},
      {"--dial-z-deg", "-360", "360", "-361", "361", [](const VisionOptions& o) { return static_cast<double>(o.dials_degrees.z()); }},
      {"--probe-radius", "0", "1", "-0.1", "1.1", [](const VisionOptions& o) { return o.probe_radius_m; }},
      {"--frames-per-second-limit", "0", "10000", "-1", "10001", [](const VisionOptions& o) { return o.rate_limit_hz; }},
      {"--msaa", "0", "16", "-1", "17", [](const VisionOptions& o) { return static_cast<double>(o.view.msaa); }},
      {"--seconds", "0", "1e9", "-0.1", "1.1e9", [](const VisionOptions& o) { return static_cast<double>(o.seconds); }},
      {"--draw-button", "0", "32", "-1", "33", [](const VisionOptions& o) { return static_cast<double>(o.annotations.draw_button); }},
      {"--measure-button", "0", "32", "-1", "33", [](const VisionOptions& o) { return static_cast<double>(o.annotations.measure_button); }},
      {"--menu-button", "0", "32", "-1", "33", [](const VisionOptions& o) { return static_cast<double>(o.annotations.menu_button); }},
      {"--bench-frames", "0", "1000000", "-1", "1000001", [](const VisionOptions& o) { return static_cast<double>(o.bench_frames); }},
  };
  for (const auto& range : ranges) expect_range(range, parse);
}

TEST(VisionOptions, ARecordingExcludesWhatIsOfALiveSession) {
  const std::vector<std::vector<const char*>> live = {
      {"--hub", "a"},         {"--bind", "127.0.0.1:0"}, {"--key", "a.key"}, {"--knobs", "spacemouse"},
      {"--strokes", "a.obj"}, {"--bench-frames", "3"},   {"--watch-scene"}};
  for (std::vector<const char*> words : live) {
    words.insert(words.end(), {"--session", "a.hapton"});
    EXPECT_TRUE(std::holds_alternative<int>(parse(words))) << words[0];
  }
  const auto parsed = parse({"--session", "a.hapton", "--at", "2.5", "--speed", "4", "--annotations", "a.toml"});
  ASSERT_TRUE(std::holds_alternative<VisionOptions>(parsed));
  const auto& options = std::get<VisionOptions>(parsed);
  EXPECT_EQ(options.session, "a.hapton");
  EXPECT_EQ(options.at_s, 2.5);
  EXPECT_EQ(options.speed, 4.0);
}

// The flags of scene and tool decide whether the picture shows what is felt.
TEST(VisionOptions, FlagsOfSceneToolAndOverlayArrive) {
  const auto parsed = parse({"--no-fit", "--tool", "peg.obj", "--tool-unit", "mm", "--tool-grip", "centre", "--watch-scene",
                             "--no-keys-help", "--no-depth-cues", "--teach", "tree:3"});
  ASSERT_TRUE(std::holds_alternative<VisionOptions>(parsed));
  const auto& options = std::get<VisionOptions>(parsed);
  EXPECT_EQ(options.loading.fit, MeshFit::off);
  EXPECT_TRUE(options.is_loading_given);
  EXPECT_EQ(options.tool.file, "peg.obj");
  EXPECT_EQ(options.tool.unit, Unit::mm);
  EXPECT_EQ(options.tool.grip, ToolGrip::center);
  EXPECT_TRUE(options.watch_scene);
  EXPECT_FALSE(options.help);
  EXPECT_FALSE(options.view.depth_cues);
  EXPECT_EQ(options.teach, (TeachChoice{TeachView::tree, 3}));
  const auto plain = std::get<VisionOptions>(parse({}));
  EXPECT_EQ(plain.loading.fit, MeshFit::workspace);
  EXPECT_FALSE(plain.is_loading_given);
  EXPECT_FALSE(plain.watch_scene);
  EXPECT_TRUE(plain.help);
  EXPECT_TRUE(plain.view.depth_cues);
  EXPECT_TRUE(std::get<VisionOptions>(parse({"--unit", "mm"})).is_loading_given);
}

}  // namespace
}  // namespace hapton
