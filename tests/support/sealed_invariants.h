#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "core/geometry/closest_point.h"
#include "core/geometry/mesh_measures.h"
#include "core/geometry/mesh_topology.h"
#include "core/geometry/seal_cracks.h"

// What holds for every sealed mesh, whatever mesh it was made from.
namespace hapton::made {

inline bool are_equal(const TriangleMesh& a, const TriangleMesh& b) {
  return a.vertices == b.vertices && a.triangles == b.triangles && a.authored_normals == b.authored_normals;
}

inline Vec3 normal_of(const TriangleMesh& mesh, std::size_t t) {
  return (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0));
}

inline bool has_area(const TriangleMesh& mesh, std::size_t t) {
  double longest = 0.0;
  for (int k = 0; k < 3; ++k) longest = std::max(longest, (mesh.corner(t, k) - mesh.corner(t, (k + 1) % 3)).squaredNorm());
  return normal_of(mesh, t).norm() > 1e-14 * longest;
}

// Triangles with the same three vertices as an earlier one.
inline std::size_t count_duplicate_triangles(const TriangleMesh& mesh) {
  std::set<Triangle> seen;
  std::size_t duplicates = 0;
  for (Triangle t : mesh.triangles) {
    std::sort(t.begin(), t.end());
    duplicates += seen.insert(t).second ? 0 : 1;
  }
  return duplicates;
}

// Leaves out triangles that use a vertex twice: their edges do not count.
inline TriangleMesh without_repeats(TriangleMesh mesh) {
  std::erase_if(mesh.triangles, [](const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; });
  return mesh;
}

struct Sealed {
  TriangleMesh mesh;
  SealReport report;
};

// Seals the mesh `given` and checks what seal_cracks.h promises about the result.
inline Sealed seal_checked(const TriangleMesh& given, const std::string& what, double share = kSealedShare) {
  SCOPED_TRACE(what);
  Sealed sealed;
  std::vector<std::uint32_t> source;
  sealed.mesh = seal_cracks(given, sealed.report, share, &source);
  const SealReport& report = sealed.report;
  const TriangleMesh& mesh = sealed.mesh;
  if (!report.has_sealed()) {
    EXPECT_TRUE(are_equal(mesh, given));
    return sealed;
  }
  const double tolerance = share * compute_bounds(given).extent();
  EXPECT_DOUBLE_EQ(report.tolerance, tolerance);
  EXPECT_LE(report.widest_gap, tolerance);
  EXPECT_EQ(mesh.vertices.size() + report.welded_vertices, given.vertices.size());
  EXPECT_EQ(mesh.triangles.size(), given.triangles.size() + report.split_triangles);
  EXPECT_EQ(source.size(), mesh.triangles.size());
  EXPECT_TRUE(std::is_sorted(source.begin(), source.end()));
  EXPECT_EQ(mesh.has_authored_normals(), given.has_authored_normals());

  const auto is_less = [](const Vec3& a, const Vec3& b) { return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end()); };
  const std::set<Vec3, decltype(is_less)> given_vertices(given.vertices.begin(), given.vertices.end(), is_less);
  for (const Vec3& vertex : mesh.vertices) EXPECT_TRUE(given_vertices.contains(vertex));

  std::vector<std::uint32_t> part_counts(given.triangles.size(), 0);  // into how many parts each triangle is split
  for (const std::uint32_t s : source) ++part_counts[s];
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::uint32_t s = source[t];
    for (int k = 0; k < 3; ++k) {
      if (part_counts[s] == 1) {
        EXPECT_LE((mesh.corner(t, k) - given.corner(s, k)).norm(), tolerance) << t;
      } else {
        // A triangle is split at a vertex near its edge, and the ends of this edge may have moved as well: twice the tolerance.
        EXPECT_LE(closest_point(given.corner(s, 0), given.corner(s, 1), given.corner(s, 2), mesh.corner(t, k)).distance,
                  2.0 * tolerance * (1.0 + 1e-9))
            << t;
      }
    }
    if (!has_area(given, s)) continue;
    EXPECT_TRUE(has_area(mesh, t)) << t;
    EXPECT_GT(normal_of(mesh, t).dot(normal_of(given, s)), 0.0) << t;
  }
  const EdgeCensus before = count_edges(without_repeats(given));
  const EdgeCensus after = count_edges(without_repeats(mesh));
  EXPECT_EQ(before.boundary, report.boundary_edges);
  EXPECT_EQ(after.boundary, report.boundary_edges_left);
  EXPECT_LE(after.boundary, before.boundary);
  EXPECT_LE(after.non_manifold, before.non_manifold);
  EXPECT_LE(count_duplicate_triangles(mesh), count_duplicate_triangles(given));
  EXPECT_LE(compute_mesh_topology(mesh).degenerate_triangles, compute_mesh_topology(given).degenerate_triangles);

  SealReport again;
  EXPECT_TRUE(are_equal(seal_cracks(mesh, again, share), mesh)) << "sealing again: " << again.describe();
  return sealed;
}

}  // namespace hapton::made
