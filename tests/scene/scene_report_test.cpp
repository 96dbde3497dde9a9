#include "scene/scene_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace hapton {
namespace {

using ::testing::HasSubstr;

TEST(SceneReport, DescribesEveryObject) {
  const auto report = make_scene_report(HAPTON_SOURCE_DIR "/scenes/nist_assembly.toml");
  ASSERT_TRUE(report) << report.error().what;
  const std::string text = to_text(*report);
  const auto json = nlohmann::json::parse(to_json(*report));
  ASSERT_EQ(json["objects"].size(), 6U);
  EXPECT_THAT(text, HasSubstr(", 6 objects\n"));
  std::size_t triangles = 0;
  for (const auto& object : json["objects"]) {
    EXPECT_THAT(text, HasSubstr(object["name"].get<std::string>()));
    triangles += object["triangles"].get<std::size_t>();
  }
  EXPECT_EQ(triangles, 7216U);
  EXPECT_THAT(text, HasSubstr(", 6 objects\n"));
  EXPECT_THAT(text, HasSubstr(to_text(report->flaws[2])));
  EXPECT_EQ(json["objects"][2]["needle_triangles"], report->flaws[2].topology.needle_triangles);
  EXPECT_EQ(json["objects"][2]["name"], "pipe_1");
  EXPECT_EQ(json["objects"][2]["stiffness_n_per_m"], 800.0);
}

TEST(SceneReport, SaysWhatIsMovable) {
  const auto report = make_scene_report(HAPTON_SOURCE_DIR "/scenes/workbench.toml");
  ASSERT_TRUE(report) << report.error().what;
  EXPECT_THAT(to_text(*report), HasSubstr("friction 0 / 0, movable\n"));
  const auto json = nlohmann::json::parse(to_json(*report));
  EXPECT_EQ(json["objects"][0]["movable"], false);
  EXPECT_EQ(json["objects"][3]["movable"], true);
}

TEST(SceneReport, SaysWhatMovesByItself) {
  const auto report = make_scene_report(HAPTON_SOURCE_DIR "/scenes/machine.toml");
  ASSERT_TRUE(report) << report.error().what;
  EXPECT_NE(to_text(*report).find("moves by 5 keyframes for 4.8 s, again and again"), std::string::npos) << to_text(*report);
  EXPECT_NE(to_json(*report).find("\"motion_s\": 4.8"), std::string::npos);
}

TEST(SceneReport, SaysWhatCanBeCarved) {
  const auto report = make_scene_report(HAPTON_SOURCE_DIR "/scenes/clay.toml");
  ASSERT_TRUE(report) << report.error().what;
  EXPECT_THAT(to_text(*report), HasSubstr("can be carved by button 1: ball of 4 mm radius, voxels of 0.8 mm"));
  const auto json = nlohmann::json::parse(to_json(*report));
  EXPECT_TRUE(json["objects"][0]["carve_button"].is_null());
  EXPECT_EQ(json["objects"][1]["carve_button"], 1);
}

TEST(SceneReport, CountsOneObjectAsOne) {
  const auto report = make_scene_report(HAPTON_SOURCE_DIR "/scenes/car_front.toml");
  ASSERT_TRUE(report) << report.error().what;
  EXPECT_THAT(to_text(*report), HasSubstr(", 1 object\n"));
}

TEST(SceneReport, SaysWhatIsWrongWithAMesh) {
  const auto report = make_scene_report(HAPTON_SOURCE_DIR "/scenes/car_front.toml");
  ASSERT_TRUE(report) << report.error().what;
  EXPECT_THAT(to_text(*report), HasSubstr(", 1 object\n"));
  EXPECT_THAT(to_text(*report), HasSubstr("not closed: "));
  EXPECT_THAT(to_text(*report), HasSubstr("needles 68"));
}

TEST(SceneReport, PassesErrorsOn) {
  const auto report = make_scene_report(HAPTON_SOURCE_DIR "/scenes/none.toml");
  ASSERT_FALSE(report);
  EXPECT_THAT(report.error().what, HasSubstr("no such file"));
}

}  // namespace
}  // namespace hapton
