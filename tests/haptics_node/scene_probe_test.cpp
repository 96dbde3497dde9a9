#include "haptics_node/scene_probe.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

class SceneProbe : public ::testing::Test {
 protected:
  // Parses this command line, and takes the probe of the scene.
  HapticsOptions parse_with_probe(std::vector<std::string> words, const std::string& scene = "two.toml") {
    HapticsOptions options = parse(std::move(words), scene);
    const auto result = take_scene_probe(options);
    EXPECT_TRUE(result) << (result ? "" : result.error().what);
    return options;
  }
  HapticsOptions parse(std::vector<std::string> words, const std::string& scene) {
    words.insert(words.begin(), {"haptics_node", "--scene", (folder_.path() / scene).string()});
    std::vector<const char*> given;
    for (const std::string& word : words) given.push_back(word.c_str());
    return std::get<HapticsOptions>(parse_haptics_options(static_cast<int>(given.size()), given.data()));
  }
  void SetUp() override {
    folder_.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    folder_.write("none.toml", "[[object]]\nmesh = 'a.obj'\n");
    folder_.write("two.toml",
                  "[[object]]\nmesh = 'a.obj'\n[[probe]]\nname = 'left'\nradius_m = 0.002\n"
                  "[[probe]]\nname = 'right'\nmethod = 'smooth'\nshading = 0.25\n");
  }
  ScratchFolder folder_;
};

TEST_F(SceneProbe, IsTheFirstOrTheOneThatIsNamed) {
  EXPECT_EQ(parse_with_probe({}).method.probe_radius_m, 0.002);
  EXPECT_EQ(parse_with_probe({}).method.name, "proxy");
  const HapticsOptions right = parse_with_probe({"--probe", "right"});
  EXPECT_EQ(right.method.name, "smooth");
  EXPECT_EQ(right.method.shading, 0.25);
  EXPECT_EQ(right.method.probe_radius_m, 0.0);
}

TEST_F(SceneProbe, FlagsOverrideTheScene) {
  EXPECT_EQ(parse_with_probe({"--probe-radius", "0"}).method.probe_radius_m, 0.0) << "also with the value that is the default";
  const HapticsOptions right = parse_with_probe({"--probe", "right", "--method", "proxy", "--shading", "0"});
  EXPECT_EQ(right.method.name, "proxy");
  EXPECT_EQ(right.method.shading, 0.0);
}

TEST_F(SceneProbe, ASceneWithoutOneChangesNothing) {
  EXPECT_EQ(parse_with_probe({}, "none.toml").method.probe_radius_m, 0.0);
  EXPECT_EQ(parse_with_probe({}, "a.obj").method.name, "proxy");
  EXPECT_EQ(parse_with_probe({}, "gone.toml").method.name, "proxy") << "load_scene reports the missing file";
}

TEST_F(SceneProbe, AnUnknownNameIsRejectedInOneLine) {
  for (const auto& [scene, what] :
       {std::pair{"two.toml", "did you mean 'right'?"}, {"none.toml", "add it"}, {"a.obj", "is not a scene file"}}) {
    HapticsOptions options = parse({"--probe", "rigt"}, scene);
    const auto result = take_scene_probe(options);
    ASSERT_FALSE(result) << scene;
    EXPECT_THAT(result.error().what, HasSubstr(what));
    EXPECT_THAT(result.error().what, HasSubstr(scene));
  }
}

}  // namespace
}  // namespace hapton
