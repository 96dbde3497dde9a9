#include "core/tool/surface_features.h"

#include <gtest/gtest.h>

#include <set>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

const LocalFrame kMetres;

TEST(SurfaceFeatures, EachVertexAndEdgeHasOneOwner) {
  const ObjectGeometry sphere(make_icosphere(0.5, 2), kMetres);
  const SurfaceFeatures features(sphere);
  std::size_t vertices = 0;
  std::size_t edges = 0;
  std::set<std::uint32_t> owned_vertices;
  for (std::uint32_t t = 0; t < sphere.triangle_count(); ++t) {
    for (int k = 0; k < 3; ++k) {
      edges += features.owns_edge(t, k) ? 1 : 0;
      if (!features.owns_vertex(t, k)) continue;
      ++vertices;
      owned_vertices.insert(sphere.triangle(t)[k]);
    }
  }
  EXPECT_EQ(vertices, sphere.vertices().size());
  EXPECT_EQ(owned_vertices.size(), vertices);
  EXPECT_EQ(edges, sphere.triangle_count() * 3 / 2);
}

TEST(SurfaceFeatures, ABoundaryEdgeIsItsTrianglesOwn) {
  const ObjectGeometry sheet(make_plane_grid(1.0, 1), kMetres);
  const SurfaceFeatures features(sheet);
  int owned_edges = 0;
  for (std::uint32_t t = 0; t < 2; ++t) {
    for (int k = 0; k < 3; ++k) owned_edges += features.owns_edge(t, k) ? 1 : 0;
  }
  EXPECT_EQ(owned_edges, 5) << "four at the boundary, and the diagonal";
}

TEST(SurfaceFeatures, ARingIsTheNeighbouringVertices) {
  const ObjectGeometry sphere(make_icosphere(0.5, 1), kMetres);
  const SurfaceFeatures features(sphere);
  for (std::uint32_t v = 0; v < sphere.vertices().size(); ++v) {
    std::set<std::uint32_t> expected;
    for (std::uint32_t t = 0; t < sphere.triangle_count(); ++t) {
      const Triangle& corners = sphere.triangle(t);
      if (std::find(corners.begin(), corners.end(), v) == corners.end()) continue;
      for (const std::uint32_t u : corners) expected.insert(u);
    }
    expected.erase(v);
    const auto ring = features.ring(v);
    EXPECT_EQ(std::set<std::uint32_t>(ring.begin(), ring.end()), expected);
  }
}

TEST(SurfaceFeatures, OnlyTheHighestVertexOfABoxIsALocalMaximum) {
  const ObjectGeometry box(make_box({1.0, 1.0, 1.0}), kMetres);
  const SurfaceFeatures features(box);
  const Vec3 corner = Vec3(1.0, 1.0, 1.0).normalized();
  int maxima = 0;
  for (std::uint32_t v = 0; v < box.vertices().size(); ++v) maxima += features.is_local_maximum(v, corner) ? 1 : 0;
  EXPECT_EQ(maxima, 1);
  // `up` is tilted by 0.1: only the two corners of the far upper edge are maxima; if that slope is allowed, all four upper corners.
  const Vec3 up = Vec3(0.1, 0.0, 1.0).normalized();
  int flat_maxima = 0;
  int maxima_with_slope = 0;
  for (std::uint32_t v = 0; v < box.vertices().size(); ++v) {
    flat_maxima += features.is_local_maximum(v, up) ? 1 : 0;
    maxima_with_slope += features.is_local_maximum(v, up, 0.11) ? 1 : 0;
  }
  EXPECT_EQ(flat_maxima, 2);
  EXPECT_EQ(maxima_with_slope, 4);
}

}  // namespace
}  // namespace hapton
