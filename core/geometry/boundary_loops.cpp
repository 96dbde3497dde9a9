#include "core/geometry/boundary_loops.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <utility>

#include "core/geometry/disjoint_sets.h"
#include "core/geometry/largest_disc.h"
#include "core/geometry/shared_edges.h"

namespace hapton {
namespace {

// A proper triangle repeats no vertex.
bool is_proper(const Triangle& t) { return t[0] != t[1] && t[1] != t[2] && t[2] != t[0]; }

// The edges of all proper triangles.
SharedEdges edges_of(const TriangleMesh& mesh) {
  std::vector<Triangle> proper;
  proper.reserve(mesh.triangles.size());
  for (const Triangle& t : mesh.triangles) {
    if (is_proper(t)) proper.push_back(t);
  }
  return SharedEdges(proper);
}

// Joins the vertices of each connected piece. Returns the area of each piece, at the vertex that represents it.
std::vector<double> measure_pieces(const TriangleMesh& mesh, DisjointSets& pieces) {
  for (const Triangle& t : mesh.triangles) {
    if (!is_proper(t)) continue;  // its area is 0
    pieces.join(t[0], t[1]);
    pieces.join(t[1], t[2]);
  }
  std::vector<double> areas(mesh.vertices.size(), 0.0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3& a = mesh.corner(t, 0);
    areas[pieces.root(mesh.triangles[t][0])] += 0.5 * (mesh.corner(t, 1) - a).cross(mesh.corner(t, 2) - a).norm();
  }
  return areas;
}

// The width of a loop: the diameter of the largest ball that gets through it, moving along the normal of the loop.
double width_of(const TriangleMesh& mesh, const std::vector<HalfEdge>& edges, const Vec3& area, double length, double negligible_width) {
  if (!(area.norm() > 0.0)) return 0.0;
  if (edges.size() == 3) return 4.0 * area.norm() / length;
  const Eigen::Matrix3d to_plane = Quat::FromTwoVectors(area, Vec3::UnitZ()).toRotationMatrix();
  const Vec3 origin = mesh.vertices[edges.front().low];
  std::vector<Segment2> projected;
  projected.reserve(edges.size());
  for (const HalfEdge& edge : edges) {
    const Vec3 from = to_plane * (mesh.vertices[edge.low] - origin);
    const Vec3 to = to_plane * (mesh.vertices[edge.high] - origin);
    projected.emplace_back(from.head<2>(), to.head<2>());
  }
  return largest_disc(std::move(projected), negligible_width);
}

BoundaryLoop measure_loop(const TriangleMesh& mesh, const std::vector<HalfEdge>& edges, double negligible_width) {
  BoundaryLoop loop;
  loop.edges = edges.size();
  // Positions relative to a vertex of the loop: far from the origin, differences of products would lose their digits.
  const Vec3 origin = mesh.vertices[edges.front().low];
  Vec3 area = Vec3::Zero();
  Vec3 sum = Vec3::Zero();
  double longest = -1.0;
  for (const HalfEdge& edge : edges) {
    const Vec3 from = mesh.vertices[edge.upward ? edge.low : edge.high] - origin;
    const Vec3 to = mesh.vertices[edge.upward ? edge.high : edge.low] - origin;
    const double length = (to - from).norm();
    loop.length += length;
    area += 0.5 * from.cross(to);
    sum += 0.5 * length * (from + to);
    if (length <= longest) continue;
    longest = length;
    loop.on_edge = origin + 0.5 * (from + to);
  }
  loop.area = area.norm();
  loop.width = width_of(mesh, edges, area, loop.length, negligible_width);
  loop.centre = loop.length > 0.0 ? Vec3(origin + sum / loop.length) : origin;
  return loop;
}

}  // namespace

std::vector<BoundaryLoop> find_boundary_loops(const TriangleMesh& mesh, double negligible_width) {
  const SharedEdges edges = edges_of(mesh);
  std::vector<HalfEdge> borders;
  for (std::size_t e = 0; e < edges.size(); ++e) {
    if (edges[e].size() == 1) borders.push_back(edges[e].front());
  }
  if (borders.empty()) return {};
  DisjointSets rims(mesh.vertices.size());
  for (const HalfEdge& edge : borders) rims.join(edge.low, edge.high);
  std::map<std::uint32_t, std::vector<HalfEdge>> by_rim;
  for (const HalfEdge& edge : borders) by_rim[rims.root(edge.low)].push_back(edge);
  DisjointSets pieces(mesh.vertices.size());
  const std::vector<double> areas = measure_pieces(mesh, pieces);
  std::vector<BoundaryLoop> loops;
  for (const auto& [vertex, rim] : by_rim) {
    loops.push_back(measure_loop(mesh, rim, negligible_width));
    loops.back().piece_area = areas[pieces.root(vertex)];
  }
  std::stable_sort(loops.begin(), loops.end(), [](const BoundaryLoop& a, const BoundaryLoop& b) { return a.width > b.width; });
  return loops;
}

std::vector<Vec3> find_inconsistent_edges(const TriangleMesh& mesh) {
  const SharedEdges edges = edges_of(mesh);
  std::vector<Vec3> middles;
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const auto sides = edges[e];
    if (sides.size() != 2 || sides[0].upward != sides[1].upward) continue;
    middles.push_back(0.5 * (mesh.vertices[sides[0].low] + mesh.vertices[sides[0].high]));
  }
  return middles;
}

}  // namespace hapton
