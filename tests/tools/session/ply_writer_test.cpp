#include "tools/session/ply_writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "core/geometry/mesh_shapes.h"
#include "scene/mesh_file.h"
#include "tests/support/one_line.h"

namespace hapton {
namespace {

TEST(PlyWriter, IsReadBackToTheBit) {
  const TriangleMesh mesh = make_bumpy_sphere(0.0451234567890123, 0.2, 100, 3);
  const auto path = std::filesystem::path(::testing::TempDir()) / "hapton_ply_writer_test.ply";
  ASSERT_TRUE(write_ply(path, mesh).has_value());
  const auto read = load_mesh_file(path);
  ASSERT_TRUE(read.has_value()) << read.error().what;
  ASSERT_EQ(read->mesh.triangles.size(), mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (int k = 0; k < 3; ++k) ASSERT_EQ(read->mesh.corner(i, k), mesh.corner(i, k));
  }
  std::filesystem::remove(path);
}

TEST(PlyWriter, SaysWhereItCannotWrite) {
  const auto written = write_ply("/proc/no/such/place.ply", make_box(Vec3::Ones()));
  ASSERT_FALSE(written);
  EXPECT_THAT(written.error().what, testing::StartsWith("cannot write /proc/no/such/place.ply: "));
  EXPECT_THAT(written.error().what, IsOneLine());
}

}  // namespace
}  // namespace hapton
