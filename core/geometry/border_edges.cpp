#include "core/geometry/border_edges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/geometry/closest_point.h"

namespace hapton {
namespace {

constexpr double kShareOfEdge = 0.05;
constexpr double kMostSamples = 1e4;  // of one edge

using Edge = std::pair<std::uint32_t, std::uint32_t>;

std::vector<Edge> find_borders(const TriangleMesh& mesh) {
  std::vector<Edge> edges;
  for (const Triangle& t : mesh.triangles) {
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
    for (int k = 0; k < 3; ++k) edges.emplace_back(std::minmax(t[k], t[(k + 1) % 3]));
  }
  std::sort(edges.begin(), edges.end());
  std::vector<Edge> borders;
  for (std::size_t first = 0, last = 0; first < edges.size(); first = last) {
    while (last < edges.size() && edges[last] == edges[first]) ++last;
    if (last - first == 1) borders.push_back(edges[first]);
  }
  return borders;
}

// Border edges by the cells of a grid they pass through.
class BorderGrid {
 public:
  BorderGrid(const TriangleMesh& mesh, const std::vector<Edge>& borders, double width) : mesh_(mesh), borders_(borders) {
    double sum = 0.0;
    for (const Edge& edge : borders) sum += length(edge);
    cell_ = std::max(2.0 * width, sum / static_cast<double>(borders.size()));
    for (std::uint32_t e = 0; e < borders.size(); ++e) put(e);
  }

  double length(const Edge& edge) const { return (at(edge, 1.0) - at(edge, 0.0)).norm(); }
  Vec3 at(const Edge& edge, double share) const {
    return mesh_.vertices[edge.first] + share * (mesh_.vertices[edge.second] - mesh_.vertices[edge.first]);
  }

  // Whether any border but `own` comes within `reach`, which is at most half a cell, of the point.
  bool has_other_near(std::uint32_t own, const Vec3& p, double reach) const {
    const Cell middle = cell_of(p);
    for (int i = 0; i < 27; ++i) {
      const auto found = cells_.find({middle[0] + i % 3 - 1, middle[1] + i / 3 % 3 - 1, middle[2] + i / 9 - 1});
      if (found == cells_.end()) continue;
      for (const std::uint32_t e : found->second) {
        if (e == own) continue;
        const Vec3 &a = mesh_.vertices[borders_[e].first], &b = mesh_.vertices[borders_[e].second];
        if (closest_point(a, b, b, p).distance <= reach) return true;
      }
    }
    return false;
  }

 private:
  using Cell = std::array<std::int64_t, 3>;
  struct CellHash {
    std::size_t operator()(const Cell& c) const {
      std::uint64_t h = 0x9E3779B97F4A7C15ULL;
      for (const std::int64_t i : c) h = (h ^ static_cast<std::uint64_t>(i)) * 0xFF51AFD7ED558CCDULL;
      return static_cast<std::size_t>(h ^ (h >> 32));
    }
  };

  Cell cell_of(const Vec3& p) const {
    const Vec3 from = (p - mesh_.vertices[borders_[0].first]) / cell_;
    return {static_cast<std::int64_t>(std::floor(from.x())), static_cast<std::int64_t>(std::floor(from.y())),
            static_cast<std::int64_t>(std::floor(from.z()))};
  }

  // Sampled twice a cell: whoever is within half a cell of the edge is within one of a sample.
  void put(std::uint32_t e) {
    const int n = static_cast<int>(std::clamp(std::ceil(2.0 * length(borders_[e]) / cell_), 1.0, kMostSamples));
    for (int i = 0; i <= n; ++i) {
      std::vector<std::uint32_t>& here = cells_[cell_of(at(borders_[e], static_cast<double>(i) / n))];
      if (here.empty() || here.back() != e) here.push_back(e);
    }
  }

  const TriangleMesh& mesh_;
  const std::vector<Edge>& borders_;
  double cell_ = 0.0;
  std::unordered_map<Cell, std::vector<std::uint32_t>, CellHash> cells_;
};

}  // namespace

BorderEdges count_border_edges(const TriangleMesh& mesh, double width) {
  const std::vector<Edge> borders = find_borders(mesh);
  if (borders.empty()) return {};
  const BorderGrid grid(mesh, borders, width);
  BorderEdges count;
  for (std::uint32_t e = 0; e < borders.size(); ++e) {
    const double reach = std::min(width, kShareOfEdge * grid.length(borders[e]));
    const bool is_crack = grid.has_other_near(e, grid.at(borders[e], 0.25), reach) &&
                          grid.has_other_near(e, grid.at(borders[e], 0.5), reach) &&
                          grid.has_other_near(e, grid.at(borders[e], 0.75), reach);
    ++(is_crack ? count.cracks : count.open);
  }
  return count;
}

}  // namespace hapton
