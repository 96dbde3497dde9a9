#include "core/geometry/cracked_shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/geometry/closest_point.h"
#include "core/geometry/mesh_measures.h"
#include "core/geometry/mesh_shapes.h"
#include "core/geometry/seam_mesh.h"

namespace hapton {
namespace {

// The largest distance of a boundary vertex to the nearest boundary edge whose triangle does not contain the vertex. With two equal
// corners, closest_point finds the closest point of a segment.
double widest_gap(const TriangleMesh& mesh) {
  TriangleMesh copy = mesh;
  const SeamMesh seam(copy, find_boundary_vertices(mesh), 1.0);
  const std::vector<SeamMesh::Edge> edges = seam.boundary_edges();
  double widest = 0.0;
  for (const std::uint32_t v : seam.boundary_vertices()) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const SeamMesh::Edge& e : edges) {
      if (e.from == v || e.to == v || e.apex == v) continue;
      const Vec3& b = mesh.vertices[e.to];
      nearest = std::min(nearest, closest_point(mesh.vertices[e.from], b, b, mesh.vertices[v]).distance);
    }
    widest = std::max(widest, nearest);
  }
  return widest;
}

TEST(CrackedShapes, HaveGapsOfTheWidthRequested) {
  for (const double width : {1e-5, 0.9e-4}) {
    for (const TriangleMesh& mesh : {make_torn(make_icosphere(0.5, 2), width), make_shaken(make_icosphere(0.5, 2), width, 1),
                                     make_patched_box(Vec3(1.0, 0.8, 0.6), width, 1), make_patched_sphere(0.5, 0.0, width, 1),
                                     make_patched_sphere(0.45, 0.1, width, 1)}) {
      EXPECT_LE(widest_gap(mesh), width);
      EXPECT_GT(widest_gap(mesh), 0.3 * width);
      EXPECT_GT(compute_volume(mesh), 0.0);
      EXPECT_GT(count_edges(mesh).boundary, 10U);
    }
  }
}

TEST(CrackedShapes, DependOnTheirSeedAlone) {
  EXPECT_EQ(make_patched_sphere(0.5, 0.1, 1e-4, 7).vertices, make_patched_sphere(0.5, 0.1, 1e-4, 7).vertices);
  EXPECT_NE(make_patched_sphere(0.5, 0.1, 1e-4, 7).vertices, make_patched_sphere(0.5, 0.1, 1e-4, 8).vertices);
  EXPECT_NE(make_shaken(make_icosphere(0.5, 1), 1e-4, 7).vertices, make_shaken(make_icosphere(0.5, 1), 1e-4, 8).vertices);
}

}  // namespace
}  // namespace hapton
