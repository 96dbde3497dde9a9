#include "core/geometry/mesh_curvature.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

namespace hapton {
namespace {

// Sums over the triangles around a vertex.
struct Ring {
  Vec3 laplacian = Vec3::Zero();  // sum of (cot a + cot b) (x - x_j)
  Vec3 normal = Vec3::Zero();     // area-weighted
  double area = 0.0;              // mixed: of Voronoi cells, or of parts of obtuse triangles
};

void add_triangle(const TriangleMesh& mesh, const Triangle& triangle, std::vector<Ring>& rings) {
  const Vec3& a = mesh.vertices[triangle[0]];
  const Vec3 normal = (mesh.vertices[triangle[1]] - a).cross(mesh.vertices[triangle[2]] - a);  // its length is twice the area
  const double twice_area = normal.norm();
  if (!(twice_area > 0.0)) return;
  double cot[3];
  double side_squared[3];  // of the side opposite corner k
  int obtuse_corner = -1;
  for (int k = 0; k < 3; ++k) {
    const Vec3& x = mesh.corner(static_cast<std::size_t>(&triangle - mesh.triangles.data()), k);
    const Vec3 to_next = mesh.vertices[triangle[(k + 1) % 3]] - x;
    const Vec3 to_previous = mesh.vertices[triangle[(k + 2) % 3]] - x;
    const double cosine = to_next.dot(to_previous);
    cot[k] = cosine / twice_area;
    side_squared[k] = (to_next - to_previous).squaredNorm();
    if (cosine < 0.0) obtuse_corner = k;
  }
  for (int k = 0; k < 3; ++k) {
    Ring& ring = rings[triangle[k]];
    const int next = (k + 1) % 3;
    const int previous = (k + 2) % 3;
    const Vec3& x = mesh.vertices[triangle[k]];
    ring.laplacian += cot[previous] * (x - mesh.vertices[triangle[next]]) + cot[next] * (x - mesh.vertices[triangle[previous]]);
    ring.normal += normal;
    // The Voronoi area, or a part of the triangle if its circumcentre is outside.
    ring.area += obtuse_corner < 0    ? 0.125 * (side_squared[next] * cot[next] + side_squared[previous] * cot[previous])
                 : obtuse_corner == k ? 0.25 * twice_area
                                      : 0.125 * twice_area;
  }
}

// For each vertex, whether it is on an edge that is not shared by exactly two triangles, in opposite directions.
std::vector<bool> find_open_vertices(const TriangleMesh& mesh) {
  std::vector<std::pair<std::uint64_t, bool>> edges;  // the two ends, lower first; whether it runs from the lower one
  edges.reserve(3 * mesh.triangles.size());
  for (const Triangle& triangle : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint64_t from = triangle[k];
      const std::uint64_t to = triangle[(k + 1) % 3];
      if (from != to) edges.emplace_back(std::min(from, to) << 32U | std::max(from, to), from < to);
    }
  }
  std::sort(edges.begin(), edges.end());
  std::vector<bool> is_open(mesh.vertices.size());
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i;
    while (end < edges.size() && edges[end].first == edges[i].first) ++end;
    if (end - i != 2 || edges[i].second == edges[i + 1].second) {
      is_open[edges[i].first >> 32U] = true;
      is_open[edges[i].first & 0xFFFFFFFFU] = true;
    }
    i = end;
  }
  return is_open;
}

}  // namespace

std::vector<double> compute_mean_curvature(const TriangleMesh& mesh) {
  std::vector<Ring> rings(mesh.vertices.size());
  for (const Triangle& triangle : mesh.triangles) add_triangle(mesh, triangle, rings);
  const std::vector<bool> is_open = find_open_vertices(mesh);
  std::vector<double> curvature(rings.size(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < rings.size(); ++i) {
    const Ring& ring = rings[i];
    if (is_open[i] || !(ring.area > 0.0)) continue;
    // K(x) = laplacian / (2 area) is 2 H n.
    const Vec3 K = ring.laplacian / (2.0 * ring.area);
    curvature[i] = 0.5 * std::copysign(K.norm(), K.dot(ring.normal));
  }
  return curvature;
}

}  // namespace hapton
