#include "scene/view_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scene/scene_file.h"
#include "tests/scene/sample_files.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using ::testing::StartsWith;

Result<SceneView> view_of(const std::string& text) {
  const auto table = parse_toml(text);
  EXPECT_TRUE(table) << text;
  return read_view(*table);
}

std::string view_error(const std::string& text) {
  const auto read = view_of(text);
  return read ? "it was read" : read.error().what;
}

TEST(ViewReader, ReadsEveryKey) {
  const auto view = view_of(R"(
[camera]
position_m = [0.1, 0.5, 0.6]
look_at_m = [0, 0.1, 0]
up = [0, 0, -2]
view_angle_deg = 40
[[light]]
direction = [0, -2, 0]
color = [1, 0.5, 0]
intensity = 2
[[light]]
position_m = [0, 1, 0.5]
)");
  ASSERT_TRUE(view) << view.error().what;
  ASSERT_TRUE(view->camera);
  EXPECT_EQ(view->camera->p_WE, Vec3(0.1, 0.5, 0.6));
  EXPECT_EQ(view->camera->p_WC, Vec3(0, 0.1, 0));
  EXPECT_EQ(view->camera->up, Vec3(0, 0, -1));
  EXPECT_EQ(view->camera->view_angle_deg, 40.0);
  ASSERT_THAT(view->lights, SizeIs(2));
  EXPECT_FALSE(view->lights[0].has_position);
  EXPECT_EQ(view->lights[0].towards_or_p_W, Vec3(0, 1, 0));
  EXPECT_EQ(view->lights[0].colour, Vec3(2, 1, 0));
  EXPECT_TRUE(view->lights[1].has_position);
  EXPECT_EQ(view->lights[1].towards_or_p_W, Vec3(0, 1, 0.5));
  EXPECT_EQ(view->lights[1].colour, Vec3(1, 1, 1));
}

TEST(ViewReader, WithoutTablesThereIsNothing) {
  const auto view = view_of("fit_m = 1\n");
  ASSERT_TRUE(view);
  EXPECT_FALSE(view->camera);
  EXPECT_THAT(view->lights, IsEmpty());
}

TEST(ViewReader, ACameraHasDefaults) {
  const auto view = view_of("[camera]\nposition_m = [0, 0, 1]\n");
  ASSERT_TRUE(view) << view.error().what;
  EXPECT_EQ(view->camera->p_WC, Vec3(0, 0, 0));
  EXPECT_EQ(view->camera->up, Vec3(0, 1, 0));
  EXPECT_EQ(view->camera->view_angle_deg, 30.0);
}

TEST(ViewReader, NamesLineKeyAndWhatIsAllowed) {
  const std::string camera = "[camera]\nposition_m = [0, 0, 1]\n";
  EXPECT_THAT(view_error("camera = 1\n"), StartsWith("line 1: 'camera' must be one table [camera]"));
  EXPECT_THAT(view_error("[[camera]]\nposition_m = [0, 0, 1]\n"), HasSubstr("'camera' must be one table [camera]"));
  EXPECT_THAT(view_error("[camera]\nup = [0, 1, 0]\n"), StartsWith("line 1: [camera] has no 'position_m': add it"));
  EXPECT_THAT(view_error(camera + "lookat_m = [0, 0, 0]\n"),
              HasSubstr("line 3: unknown key 'lookat_m' in [camera]; did you mean 'look_at_m'?"));
  EXPECT_THAT(view_error(camera + "look_at_m = [0, 0, 1]\n"),
              StartsWith("line 2: 'position_m' in [camera] is the point that it looks at: move one of them"));
  EXPECT_THAT(view_error(camera + "up = [0, 0, 3]\n"), StartsWith("line 3: [camera] looks along 'up'"));
  EXPECT_THAT(view_error("[camera]\nposition_m = [0, 1, 0]\n"), StartsWith("line 1: [camera] looks along 'up' ([0, 1, 0] by default)"));
  EXPECT_THAT(view_error(camera + "up = [0, 0, 0]\n"), StartsWith("line 3: 'up' in [camera] has length 0: give a direction"));
  EXPECT_THAT(view_error(camera + "view_angle_deg = 0.5\n"),
              HasSubstr("'view_angle_deg' in [camera] is 0.5: it must be at least 1 and at most 120"));
  EXPECT_THAT(view_error(camera + "view_angle_deg = '30'\n"), HasSubstr("must be a number"));
  EXPECT_THAT(view_error("[camera]\nposition_m = [0, 0, 2e6]\n"), HasSubstr("at most 1000000"));
  EXPECT_THAT(view_error("light = 1\n"), StartsWith("line 1: 'light' must be tables that begin with [[light]]"));
  EXPECT_THAT(view_error("[light]\ndirection = [0, -1, 0]\n"), HasSubstr("'light' must be tables that begin with [[light]]"));
  EXPECT_THAT(view_error("[[light]]\ncolor = [1, 1, 1]\n"),
              StartsWith("line 1: [[light]] 1 needs either 'direction', in which it shines, or"));
  EXPECT_THAT(view_error("[[light]]\ndirection = [0, -1, 0]\nposition_m = [0, 1, 0]\n"), StartsWith("line 3: [[light]] 1 needs either"));
  const std::string light = "[[light]]\ndirection = [0, -1, 0]\n";
  EXPECT_THAT(view_error(light + "intensity = -1\n"),
              StartsWith("line 3: 'intensity' in [[light]] 1 is -1: it must be at least 0 and at most 10"));
  EXPECT_THAT(view_error(light + "color = [0, 0, 255]\n"), HasSubstr("number 3 of 'color' in [[light]] 1 is 255"));
  EXPECT_THAT(view_error("[[light]]\ndirection = [0, 0, 0]\n"), StartsWith("line 2: 'direction' in [[light]] 1 has length 0"));
  EXPECT_EQ(view_error(light + light + light + light), "it was read");
  EXPECT_THAT(view_error(light + light + light + light + light), StartsWith("line 9: there are more than 4 [[light]] tables"));
}

// Camera and lights do not change what is felt.
TEST(ViewReader, ASceneFileHasItsView) {
  const ScratchFolder folder;
  folder.write("a.obj", sample::obj(sample::tetrahedron()));
  const std::string object = "[[object]]\nmesh = 'a.obj'\n";
  const auto without_view = load_scene(folder.write("a.toml", object));
  const auto with_view =
      load_scene(folder.write("b.toml", object + "[camera]\nposition_m = [0, 0, 1]\n[[light]]\ndirection = [0, -1, 0]\n"));
  ASSERT_TRUE(without_view && with_view);
  EXPECT_EQ(without_view->given_hash, with_view->given_hash);
  EXPECT_FALSE(without_view->view.camera);
  EXPECT_TRUE(with_view->view.camera);
  EXPECT_THAT(with_view->view.lights, SizeIs(1));
  const auto wrong = load_scene(folder.write("c.toml", object + "[camera]\nposition_m = 1\n"));
  ASSERT_FALSE(wrong);
  EXPECT_THAT(wrong.error().what, HasSubstr("c.toml: line 4: 'position_m' in [camera] must be a list of 3 numbers"));
}

}  // namespace
}  // namespace hapton
