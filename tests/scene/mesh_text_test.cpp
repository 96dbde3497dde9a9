#include "scene/mesh_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/geometry/mesh_shapes.h"
#include "scene/mesh_file.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

// The readers of mesh files can read what write_mesh() has written.
TEST(MeshText, IsReadAgain) {
  const TriangleMesh ball = make_icosphere(0.03, 3);
  const ScratchFolder folder;
  for (const char* name : {"ball.stl", "ball.OBJ", "ball.ply"}) {
    const auto format = find_mesh_format(name);
    ASSERT_TRUE(format) << format.error().what;
    const auto file = folder.write(name, write_mesh(ball, *format));
    const auto read = load_mesh_file(file);
    ASSERT_TRUE(read) << read.error().what;
    ASSERT_EQ(read->mesh.triangles.size(), ball.triangles.size()) << name;
    const double bound = *format == MeshTextFormat::stl ? 3e-9 : 0.0;
    for (std::size_t t = 0; t < ball.triangles.size(); ++t) {
      for (int k = 0; k < 3; ++k) ASSERT_LE((read->mesh.corner(t, k) - ball.corner(t, k)).cwiseAbs().maxCoeff(), bound) << name;
    }
  }
}

TEST(MeshText, AnotherEndingIsRejected) {
  for (const char* name : {"ball.vtp", "ball", "stl"}) {
    const auto format = find_mesh_format(name);
    ASSERT_FALSE(format) << name;
    EXPECT_THAT(format.error().what, testing::HasSubstr(".stl, .obj or .ply"));
  }
}

}  // namespace
}  // namespace hapton
