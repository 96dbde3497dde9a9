#include "core/geometry/mesh_measures.h"

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

namespace hapton {

EdgeCensus count_edges(const TriangleMesh& mesh) {
  struct Use {
    std::uint32_t low, high;
    bool forward;
  };
  std::vector<Use> uses;
  uses.reserve(3 * mesh.triangles.size());
  for (const Triangle& triangle : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t a = triangle[k];
      const std::uint32_t b = triangle[(k + 1) % 3];
      if (a != b) uses.push_back({std::min(a, b), std::max(a, b), a < b});
    }
  }
  std::sort(uses.begin(), uses.end(), [](const Use& p, const Use& q) { return std::pair(p.low, p.high) < std::pair(q.low, q.high); });
  EdgeCensus census;
  for (std::size_t first = 0; first < uses.size();) {
    std::size_t last = first;
    std::size_t forward = 0;
    for (; last < uses.size() && uses[last].low == uses[first].low && uses[last].high == uses[first].high; ++last)
      forward += uses[last].forward;
    const std::size_t count = last - first;
    ++census.edges;
    if (count == 1) ++census.boundary;
    if (count > 2) ++census.non_manifold;
    if (count == 2 && forward != 1) ++census.inconsistent;
    first = last;
  }
  return census;
}

double compute_volume(const TriangleMesh& mesh) {
  const Vec3 centre = compute_bounds(mesh).centre();
  long double six_times = 0.0L;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Vec3 a = mesh.corner(i, 0) - centre;
    const Vec3 b = mesh.corner(i, 1) - centre;
    const Vec3 c = mesh.corner(i, 2) - centre;
    six_times += a.dot(b.cross(c));
  }
  return static_cast<double>(six_times / 6.0L);
}

double compute_area(const TriangleMesh& mesh) {
  long double twice = 0.0L;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    twice += (mesh.corner(i, 1) - mesh.corner(i, 0)).cross(mesh.corner(i, 2) - mesh.corner(i, 0)).norm();
  }
  return static_cast<double>(twice / 2.0L);
}

MeshBounds compute_bounds(const TriangleMesh& mesh) {
  MeshBounds bounds{Vec3::Constant(std::numeric_limits<double>::infinity()), Vec3::Constant(-std::numeric_limits<double>::infinity())};
  for (const Vec3& vertex : mesh.vertices) {
    bounds.low = bounds.low.cwiseMin(vertex);
    bounds.high = bounds.high.cwiseMax(vertex);
  }
  return bounds;
}

}  // namespace hapton
