#include "scene/weld.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>
#include <tuple>

namespace hapton {
namespace {

using ::testing::ElementsAre;
using ::testing::SizeIs;

TEST(Weld, JoinsEqualVerticesAndDropsUnusedOnes) {
  TriangleMesh mesh{.vertices = {{9, 9, 9}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-0.0, 0, -0.0}, {1, 0, 0}, {1, 1, 0}},
                    .triangles = {{3, 1, 2}, {4, 5, 6}}};
  weld_vertices(mesh);
  EXPECT_THAT(mesh.vertices, ElementsAre(Vec3(0, 1, 0), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 1, 0)));
  EXPECT_THAT(mesh.triangles, ElementsAre(Triangle{0, 1, 2}, Triangle{1, 2, 3}));
  EXPECT_FALSE(std::signbit(mesh.vertices[1].x()));
}

TEST(Weld, KeepsVerticesApartThatDifferInOneBit) {
  TriangleMesh mesh{.vertices = {{1, 0, 0}, {std::nextafter(1.0, 2.0), 0, 0}, {0, 1, 0}}, .triangles = {{0, 1, 2}}};
  weld_vertices(mesh);
  EXPECT_THAT(mesh.vertices, SizeIs(3));
}

TEST(Weld, AgreesWithAMap) {
  const unsigned seed = 11;
  RecordProperty("seed", static_cast<int>(seed));
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> grid_number(0, 8);
  TriangleMesh mesh;
  for (int i = 0; i < 3000; ++i)
    mesh.vertices.emplace_back(0.1 * grid_number(random), 1e-9 * grid_number(random), 1e9 * grid_number(random));
  for (std::uint32_t i = 0; i + 2 < 3000; ++i) mesh.triangles.push_back({i, i + 1, i + 2});
  std::map<std::tuple<double, double, double>, int> distinct;
  for (const Vec3& v : mesh.vertices) ++distinct[{v.x(), v.y(), v.z()}];
  const TriangleMesh before = mesh;
  weld_vertices(mesh);
  EXPECT_EQ(mesh.vertices.size(), distinct.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) EXPECT_EQ(mesh.corner(t, k), before.corner(t, k));
  }
}

TEST(Weld, DroppingAloneJoinsNothing) {
  TriangleMesh mesh{.vertices = {{5, 5, 5}, {0, 0, 0}, {0, 0, 0}, {1, 0, 0}}, .triangles = {{1, 2, 3}}};
  drop_unused_vertices(mesh);
  EXPECT_THAT(mesh.vertices, SizeIs(3));
  EXPECT_THAT(mesh.triangles, ElementsAre(Triangle{0, 1, 2}));
}

}  // namespace
}  // namespace hapton
