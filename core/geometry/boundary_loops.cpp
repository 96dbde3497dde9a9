#include "core/geometry/boundary_loops.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <numeric>
#include <utility>

namespace hapton {
namespace {

struct Side {
  std::uint32_t low = 0;
  std::uint32_t high = 0;
  bool upward = false;  // the triangle goes from low to high
  bool operator<(const Side& other) const { return low != other.low ? low < other.low : high < other.high; }
  bool is_same_edge(const Side& other) const { return low == other.low && high == other.high; }
  std::uint32_t from() const { return upward ? low : high; }
  std::uint32_t to() const { return upward ? high : low; }
};

// The sides of all triangles, those of one edge next to each other.
std::vector<Side> sort_sides(const TriangleMesh& mesh) {
  std::vector<Side> sides;
  sides.reserve(3 * mesh.triangles.size());
  for (const Triangle& t : mesh.triangles) {
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(t[k], t[(k + 1) % 3]);
      sides.push_back({low, high, low == t[k]});
    }
  }
  std::sort(sides.begin(), sides.end());
  return sides;
}

// Calls use(first, count) for the sides of each edge.
template <class Use>
void for_each_edge(const std::vector<Side>& sides, Use&& use) {
  for (std::size_t first = 0, last = 0; first < sides.size(); first = last) {
    while (last < sides.size() && sides[last].is_same_edge(sides[first])) ++last;
    use(first, last - first);
  }
}

class Groups {
 public:
  explicit Groups(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0U); }
  std::uint32_t root(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::uint32_t a, std::uint32_t b) { parent_[root(a)] = root(b); }

 private:
  std::vector<std::uint32_t> parent_;
};

// Of each vertex that represents a piece.
std::vector<double> measure_pieces(const TriangleMesh& mesh, Groups& pieces) {
  for (const Triangle& t : mesh.triangles) {
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

BoundaryLoop measure_loop(const TriangleMesh& mesh, const std::vector<Side>& edges) {
  BoundaryLoop loop;
  loop.edges = edges.size();
  // From a point of the loop, so that one far from the origin keeps its digits.
  const Vec3 near = mesh.vertices[edges.front().low];
  Vec3 area = Vec3::Zero();
  Vec3 sum = Vec3::Zero();
  double longest = -1.0;
  for (const Side& edge : edges) {
    const Vec3 from = mesh.vertices[edge.from()] - near;
    const Vec3 to = mesh.vertices[edge.to()] - near;
    const double length = (to - from).norm();
    loop.length += length;
    area += 0.5 * from.cross(to);
    sum += 0.5 * length * (from + to);
    if (length <= longest) continue;
    longest = length;
    loop.on_edge = near + 0.5 * (from + to);
  }
  loop.area = area.norm();
  loop.centre = loop.length > 0.0 ? Vec3(near + sum / loop.length) : near;
  return loop;
}

}  // namespace

std::vector<BoundaryLoop> find_boundary_loops(const TriangleMesh& mesh) {
  const std::vector<Side> sides = sort_sides(mesh);
  std::vector<Side> borders;
  for_each_edge(sides, [&](std::size_t first, std::size_t count) {
    if (count == 1) borders.push_back(sides[first]);
  });
  if (borders.empty()) return {};
  Groups rims(mesh.vertices.size());
  for (const Side& edge : borders) rims.join(edge.low, edge.high);
  std::map<std::uint32_t, std::vector<Side>> by_rim;
  for (const Side& edge : borders) by_rim[rims.root(edge.low)].push_back(edge);
  Groups pieces(mesh.vertices.size());
  const std::vector<double> areas = measure_pieces(mesh, pieces);
  std::vector<BoundaryLoop> loops;
  for (const auto& [vertex, edges] : by_rim) {
    loops.push_back(measure_loop(mesh, edges));
    loops.back().piece_area = areas[pieces.root(vertex)];
  }
  std::stable_sort(loops.begin(), loops.end(), [](const BoundaryLoop& a, const BoundaryLoop& b) { return a.width() > b.width(); });
  return loops;
}

std::vector<Vec3> find_inconsistent_edges(const TriangleMesh& mesh) {
  const std::vector<Side> sides = sort_sides(mesh);
  std::vector<Vec3> middles;
  for_each_edge(sides, [&](std::size_t first, std::size_t count) {
    if (count != 2 || sides[first].upward != sides[first + 1].upward) return;
    middles.push_back(0.5 * (mesh.vertices[sides[first].low] + mesh.vertices[sides[first].high]));
  });
  return middles;
}

}  // namespace hapton
