#include <gtest/gtest.h>

#include <string>

#include "scene/mesh_file.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

// The texture coordinates of the first corner of the only triangle. corner: its reference to one of the file's four vt lines.
Eigen::Vector2f first_texcoord_with(const std::string& corner) {
  const ScratchFolder folder;
  folder.write("all.mtl", "newmtl wood\nKd 0 1 0\n");
  const auto path = folder.write(
      "a.obj", "mtllib all.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 0.25\nusemtl wood\nf 1" + corner + " 2/2 3/3\n");
  const auto file = load_mesh_file(path, Unit::m, AppearanceReading::on);
  if (!file) {
    ADD_FAILURE() << file.error().what;
    return {};
  }
  return file->appearance.triangles.at(0).corners[0].texcoord;
}

// References to vt lines count from 1, or from -1 back from the newest line. Any other gives default coordinates.
TEST(ObjTexturePlaces, CountFromBothEnds) {
  const Eigen::Vector2f first(0, 1), second(1, 1), third(1, 0), last(0, 0.75F), none(0, 0);
  EXPECT_EQ(first_texcoord_with("/1"), first);
  EXPECT_EQ(first_texcoord_with("/2"), second);
  EXPECT_EQ(first_texcoord_with("/4"), last);
  EXPECT_EQ(first_texcoord_with("/-1"), last);
  EXPECT_EQ(first_texcoord_with("/-2"), third);
  EXPECT_EQ(first_texcoord_with("/-4"), first);
  EXPECT_EQ(first_texcoord_with("/2/7"), second) << "a normal behind it";
  for (const char* const corner : {"", "/", "//1", "/0", "/5", "/-5", "/x", "/1x"}) EXPECT_EQ(first_texcoord_with(corner), none) << corner;
}

}  // namespace
}  // namespace hapton
