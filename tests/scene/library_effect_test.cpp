#include "scene/library_effect.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scene/scene_file.h"
#include "scene/scene_hash.h"
#include "scene/scene_report.h"
#include "tests/scene/sample_files.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Pair;
using ::testing::SizeIs;

class LibraryEffectTest : public ::testing::Test {
 protected:
  LibraryEffectTest() { folder_.write("a.obj", sample::obj(sample::tetrahedron())); }

  // `lines` begins at line 5 of the file.
  Result<Scene> load(const std::string& lines) {
    return load_scene(folder_.write("a.toml", "[[object]]\nmesh = 'a.obj'\n\n[[effect]]\n" + lines + "\n"));
  }
  std::string error_of(const std::string& lines) {
    const auto scene = load(lines);
    return scene ? "it was read" : scene.error().what;
  }

  ScratchFolder folder_;
};

TEST_F(LibraryEffectTest, IsNamedAndNotLoaded) {
  // The library does not exist, so an attempt to load it would fail.
  const auto scene =
      load("type = 'plugin'\nlibrary = 'lib/magnet.so'\nparameters = { range_m = 0.04, steps = 3, is_on = true, at = 'tip' }\n");
  ASSERT_TRUE(scene) << scene.error().what;
  ASSERT_THAT(scene->libraries, SizeIs(1));
  const LibraryEffect& library_effect = scene->libraries[0];
  EXPECT_EQ(library_effect.name, "magnet");
  EXPECT_EQ(library_effect.library, folder_.path() / "lib/magnet.so") << "beside the scene";
  EXPECT_EQ(library_effect.line, 4U);
  EXPECT_THAT(library_effect.parameters,
              ElementsAre(Pair("at", "tip"), Pair("is_on", "true"), Pair("range_m", "0.04"), Pair("steps", "3")));
  EXPECT_THAT(scene->effects, SizeIs(0));
  EXPECT_THAT(scene->notes,
              ElementsAre(AllOf(HasSubstr("line 4: effect magnet is the plug-in "), HasSubstr("only haptics_node --allow-plugins"))));
}

TEST_F(LibraryEffectTest, StandsAmongOthersAndIsInTheReport) {
  const auto scene = load(
      "type = 'spring'\nposition_m = [0, 0, 0]\n[[effect]]\ntype = 'plugin'\nname = 'one'\nlibrary = '/opt/x.so'\n[[effect]]\ntype = "
      "'viscous'\ndamping_ns_per_m = 1\n");
  ASSERT_TRUE(scene) << scene.error().what;
  EXPECT_THAT(scene->effects, SizeIs(2));
  EXPECT_EQ(scene->libraries[0].library, "/opt/x.so");
  const auto report = make_scene_report(folder_.path() / "a.toml");
  ASSERT_TRUE(report);
  EXPECT_THAT(to_text(*report), HasSubstr("effect one is the plug-in /opt/x.so"));
  EXPECT_THAT(to_json(*report), AllOf(HasSubstr("\"plugins\""), HasSubstr("\"library\": \"/opt/x.so\"")));
}

TEST_F(LibraryEffectTest, IsNeverLookedForInTheFoldersOfTheSystem) {
  ASSERT_TRUE(load("type = 'plugin'\nlibrary = 'x.so'"));
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(folder_.path());
  for (const char* path : {"a.toml", "./a.toml"}) {
    const auto scene = load_scene(path);
    ASSERT_TRUE(scene) << scene.error().what;
    EXPECT_EQ(scene->libraries[0].library, "./x.so") << path;
  }
  std::filesystem::current_path(before);
}

TEST_F(LibraryEffectTest, IsTheSameWhereverItStands) {
  const LibraryEffect one{.name = "a", .library = "x.so", .parameters = {{"n", "1"}}, .line = 3};
  LibraryEffect other = one;
  other.line = 9;
  EXPECT_TRUE(one.same_as(other));
  other.parameters[0].second = "2";
  EXPECT_FALSE(one.same_as(other));
}

TEST_F(LibraryEffectTest, SaysWhatIsWrong) {
  EXPECT_THAT(error_of("type = 'plugin'"), HasSubstr("line 4: [[effect]] 1 has no 'library': add it"));
  EXPECT_THAT(error_of("type = 'plugin'\nlibrary = ''"), HasSubstr("line 6: 'library' in [[effect]] 1 is empty"));
  EXPECT_THAT(error_of("type = 'plugin'\nlibrary = 3"), HasSubstr("must be a text in quotes"));
  EXPECT_THAT(error_of("type = 'plugin'\nlibary = 'x.so'"), HasSubstr("did you mean 'library'?"));
  EXPECT_THAT(error_of("type = 'plugin'\nlibrary = 'x.so'\nmax_force_n = 3"), HasSubstr("line 7: unknown key 'max_force_n'"));
  EXPECT_THAT(error_of("type = 'plugin'\nlibrary = 'x.so'\nparameters = 3"),
              HasSubstr("line 7: 'parameters' in [[effect]] 1 must be a table"));
  EXPECT_THAT(error_of("type = 'plugin'\nlibrary = 'x.so'\nparameters = { a = [1] }"), HasSubstr("line 7: parameter 'a'"));
  EXPECT_THAT(error_of("type = 'plugin'\nlibrary = 'x.so'\nparameters = { a = '1,2' }"), HasSubstr("has a comma"));
  EXPECT_THAT(error_of("type = 'plugin'\nlibrary = 'x.so'\nparameters = { 'a=b' = 1 }"), HasSubstr("is not a parameter name"));
  EXPECT_THAT(error_of("type = 'plugin'\nlibrary = 'x.so'\n[[effect]]\ntype = 'spring'"), HasSubstr("[[effect]] 2 has no 'position_m'"));
  EXPECT_THAT(error_of("type = 'plug-in'"), HasSubstr("wave, burst, plugin"));
}

}  // namespace
}  // namespace hapton
