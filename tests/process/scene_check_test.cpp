// Two nodes with different scenes, and a scene that the device cannot reach, are reported; the report names the touched scene.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "tests/process/system.h"

namespace hapton::process {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

std::string note(const Json& report, const char* name) { return report["notes"].value(name, std::string()); }

TEST(SceneCheck, TheReportSaysWhatIsTouched) {
  System system;
  // The hand is over the body from the start: haptics_node would hold a hand that it first finds inside, and the status would say so.
  std::ofstream(system.folder() / "taps.csv") << "t_s,x_m,y_m,z_m\n0,0.01,0.02,0.06\n600,0.01,0.02,0.06\n";
  system.start("io_node");
  system.start("haptics_node");
  const Json report =
      system.wait_for_report([](const Json& now) { return !note(now, "scene").empty() && note(now, "status_now") == "ok"; });
  EXPECT_THAT(note(report, "scene"), EndsWith("cube.toml"));
  EXPECT_THAT(note(report, "method"), StartsWith("name=proxy"));
  EXPECT_EQ(note(report, "scene_hash").size(), 16U);
  EXPECT_EQ(note(report, "status_now"), "ok");
  system.end("haptics_node");
  const Json without = system.wait_for_report([](const Json& now) { return note(now, "status_now") != "ok"; });
  EXPECT_THAT(note(without, "status_now"), HasSubstr("no haptics node"));
  system.end("io_node");
}

TEST(SceneCheck, ASceneOutOfReachIsReported) {
  System system;
  system.start("io_node");
  std::ofstream(system.folder() / "far.obj") << "v 9 9 9\nv 9.1 9 9\nv 9 9.1 9\nf 1 2 3\n";
  Program haptics("haptics_node", {"--hub", system.hub(), "--scene", (system.folder() / "far.obj").string(), "--no-fit"}, system.folder());
  const Json report = system.wait_for_report([](const Json& now) { return !note(now, "reach").empty(); });
  EXPECT_THAT(note(report, "reach"), HasSubstr("out of the device's reach"));
  EXPECT_TRUE(System::wait_until([&] { return system["io_node"].err().find("out of the device's reach") != std::string::npos; }));
}

TEST(SceneCheck, ASavedSceneFileIsFeltAndOneWithAnErrorIsNot) {
  System system;
  system.start("io_node");
  const std::filesystem::path file = system.folder() / "live.toml";
  const auto save = [&](const std::string& lines) {
    std::ofstream(file) << "[[object]]\nmesh = '" HAPTON_SOURCE_DIR "/meshes/wingnut.obj'\nunit = 'mm'\nmaterial = 'm'\n[material.m]\n"
                        << lines;
  };
  save("stiffness_n_per_m = 500\n");
  Program haptics("haptics_node", {"--hub", system.hub(), "--scene", file.string(), "--watch-scene"}, system.folder());
  const Json first = system.wait_for_report([](const Json& now) { return !note(now, "scene_hash").empty(); });
  const auto says = [&](const char* what) { return System::wait_until([&] { return haptics.err().find(what) != std::string::npos; }); };
  save("stifness_n_per_m = 700\n");
  EXPECT_TRUE(says("line 6: unknown key 'stifness_n_per_m'")) << haptics.err();
  EXPECT_TRUE(says("the present scene stays in use"));
  save("stiffness_n_per_m = 700\n");
  EXPECT_TRUE(says("its materials fade in")) << haptics.err();
  save("stiffness_n_per_m = 700\nviscosity_ns_per_m = 1\n");
  EXPECT_TRUE(says("its effects fade in")) << haptics.err();
  const auto is_changed = [&](const Json& now) { return note(now, "scene_hash") != note(first, "scene_hash"); };
  EXPECT_TRUE(is_changed(system.wait_for_report(is_changed)));
}

#ifdef HAPTON_WITH_VISION

TEST(SceneCheck, TwoNodesWithDifferentScenesSaySo) {
  System system;
  system.start("io_node");
  system.start("haptics_node");
  const std::filesystem::path other = system.folder() / "other.toml";
  std::ofstream(other) << "[[object]]\nmesh = '" HAPTON_SOURCE_DIR "/meshes/wingnut.obj'\n";
  const VirtualDisplay display;
  Program vision("vision_node", {"--hub", system.hub(), "--scene", other.string(), "--size", "320x240"}, system.folder(), display.name());
  EXPECT_TRUE(System::wait_until([&] { return vision.err().find("another scene") != std::string::npos; })) << vision.err();
  EXPECT_TRUE(System::wait_until([&] { return system["haptics_node"].err().find("another scene") != std::string::npos; }));
}

TEST(SceneCheck, TwoNodesWithDifferentToolsSaySo) {
  const std::string tool = HAPTON_SOURCE_DIR "/meshes/peg.obj";
  System system;
  system.start("io_node");
  system.add_arguments("haptics_node", {"--tool", tool, "--tool-unit", "mm"});
  system.start("haptics_node");
  const VirtualDisplay display;
  std::vector<std::string> arguments = {"--hub", system.hub(), "--size", "320x240"};
  {
    const Program vision("vision_node", arguments, system.folder(), display.name());
    EXPECT_TRUE(System::wait_until([&] { return vision.err().find("holds a rigid tool, but a probe is drawn") != std::string::npos; }))
        << vision.err();
    EXPECT_TRUE(System::wait_until(
        [&] { return system["haptics_node"].err().find("draws a probe, but the stylus holds a rigid tool") != std::string::npos; }));
  }
  arguments.insert(arguments.end(), {"--tool", tool, "--tool-unit", "mm"});
  const Program vision("vision_node", arguments, system.folder(), display.name());
  EXPECT_TRUE(System::wait_until([&] { return system["haptics_node"].err().find("draws the same tool again") != std::string::npos; }));
  EXPECT_EQ(vision.err().find("tool"), std::string::npos) << vision.err();
}

TEST(SceneCheck, TwoNodesWithTheSameSceneSayNothing) {
  System system;
  for (const std::string& node : kNodes) system.start(node);
  ASSERT_TRUE(is_complete(system.wait_for_report(is_complete)));
  const auto is_seen_and_felt = [](const Json& now) { return is_drawn(now) && has_contact(now); };
  ASSERT_TRUE(is_seen_and_felt(system.wait_for_report(is_seen_and_felt)));
  for (const char* node : {"haptics_node", "vision_node"}) EXPECT_THAT(system[node].err(), Not(HasSubstr("another scene"))) << node;
}

#endif

}  // namespace
}  // namespace hapton::process
