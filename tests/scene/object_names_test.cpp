#include "scene/object_names.h"

#include <gtest/gtest.h>

#include "tests/scene/sample_files.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

TEST(ObjectNames, AreThoseOfTheSceneFileAndFallBackToTheMeshFile) {
  const ScratchFolder folder;
  folder.write("a.obj", sample::obj(sample::tetrahedron()));
  const auto scene = load_scene(folder.write(
      "a.toml",
      "[[object]]\nmesh = 'a.obj'\nname = 'hood'\nmaterial = 'sheet metal'\n[[object]]\nmesh = 'a.obj'\n[material.'sheet metal']\n"));
  ASSERT_TRUE(scene) << scene.error().what;
  const std::vector<ObjectName> names = object_names(*scene);
  EXPECT_EQ(describe_object(names, 0), "hood (sheet metal)");
  EXPECT_EQ(describe_object(names, 1), "a");
  EXPECT_EQ(describe_object(names, 2), "");
  EXPECT_EQ(describe_object(names, -1), "");
}

TEST(ObjectNames, OfAMeshFileIsTheFilesOwn) {
  const ScratchFolder folder;
  const auto scene = load_scene(folder.write("cup.obj", sample::obj(sample::tetrahedron())));
  ASSERT_TRUE(scene) << scene.error().what;
  EXPECT_EQ(describe_object(object_names(*scene), 0), "cup");
}

// Names are shown in a terminal, which obeys control characters.
TEST(ObjectNames, AreShownWithoutWhatATerminalWouldObey) {
  const std::vector<ObjectName> names = {{"a\x1b[2J", "b\n"}};
  const std::string shown = describe_object(names, 0);
  EXPECT_EQ(shown, "a?[2J (b?)");
  for (const char c : shown) EXPECT_GE(c, ' ');
}

}  // namespace
}  // namespace hapton
