#include "core/collision/beyond_plane.h"

#include <gtest/gtest.h>

#include <bit>
#include <random>

#include "core/collision/surface_adjacency.h"

namespace hapton {
namespace {

constexpr double kPlaneMargin = 1e-3;

// Random triangles, some of which share a corner with the first or nearly touch its plane.
TEST(BeyondPlane, FindsOnlyTrianglesThatAreApart) {
  std::mt19937_64 random(2402);
  std::uniform_real_distribution<double> place(-0.5, 0.5);
  int found = 0;
  int not_found = 0;
  for (int round = 0; round < 400; ++round) {
    TriangleMesh mesh;
    std::array<std::uint32_t, WideBvh::kWidth> items{};
    for (std::uint32_t i = 0; i < 9; ++i) {
      for (std::uint32_t k = 0; k < 3; ++k) mesh.vertices.emplace_back(place(random), place(random), (round % 4) * place(random));
      mesh.triangles.push_back({3 * i, 3 * i + 1, i % 5 == 1 ? 1 : 3 * i + 2});
      if (i < 8) items[i] = i + 1;
    }
    BeyondPlane beyond(mesh.vertices, mesh.triangles);
    const unsigned lanes = round % 3 == 0 ? 0x3BU : 0xFFU;
    beyond.start(items, lanes);
    const unsigned found_lanes = beyond.find(0, kPlaneMargin) & lanes;
    for (std::uint32_t i = 0; i < 8; ++i) {
      if ((found_lanes >> i & 1U) == 0) continue;
      const Triangle& a = mesh.triangles[0];
      const Triangle& b = mesh.triangles[i + 1];
      EXPECT_TRUE(are_apart({mesh.vertices[a[0]], mesh.vertices[a[1]], mesh.vertices[a[2]]},
                            {mesh.vertices[b[0]], mesh.vertices[b[1]], mesh.vertices[b[2]]}, kPlaneMargin))
          << "round " << round << ", seed 2402";
    }
    found += std::popcount(found_lanes);
    not_found += std::popcount(lanes & ~found_lanes);
  }
  EXPECT_GT(found, 400);
  EXPECT_GT(not_found, 400);
}

// The plane z = 0 against triangles a little more and a little less than the margin above and below it.
TEST(BeyondPlane, TheMarginDecides) {
  TriangleMesh mesh{.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, .triangles = {{0, 1, 2}}};
  std::array<std::uint32_t, WideBvh::kWidth> items{};
  for (std::uint32_t i = 0; i < 8; ++i) {
    const double height = (i % 2 == 0 ? 1.0 : -1.0) * (i < 4 ? 1.001 : 0.999) * kPlaneMargin;
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (const Vec3& p : {Vec3(0.2, 0.1, height), Vec3(0.6, 0.2, 2.0 * height), Vec3(0.3, 0.9, 3.0 * height)}) mesh.vertices.push_back(p);
    mesh.triangles.push_back({first, first + 1, first + 2});
    items[i] = i + 1;
  }
  BeyondPlane beyond(mesh.vertices, mesh.triangles);
  beyond.start(items, 0xFFU);
  EXPECT_EQ(beyond.find(0, kPlaneMargin), 0x0FU);
}

}  // namespace
}  // namespace hapton
