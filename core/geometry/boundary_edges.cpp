#include "core/geometry/boundary_edges.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include "core/geometry/median_tree.h"
#include "core/geometry/seam_mesh.h"
#include "core/geometry/segment_slabs.h"

namespace hapton {
namespace {

constexpr double kMaxGapShare = 0.05;    // share of an edge's length: a wider gap beside it is not a crack (boundary_edges.h)
constexpr std::size_t kMaxMeasured = 8;  // points for which the nearest edge is searched; a free choice
constexpr std::size_t kExtraEdges = 64;  // added to the number of edges, so that a small mesh is examined completely; a free choice

using Edge = std::pair<std::uint32_t, std::uint32_t>;

std::vector<Edge> find_boundary_edges(const TriangleMesh& mesh, const std::vector<std::uint8_t>& at_boundary) {
  if (at_boundary.empty()) return {};
  std::vector<Edge> edges;
  for (const Triangle& t : mesh.triangles) {
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
    for (int k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(t[k], t[(k + 1) % 3]);
      if (at_boundary[low] != 0 && at_boundary[high] != 0) edges.emplace_back(low, high);
    }
  }
  std::sort(edges.begin(), edges.end());
  std::vector<Edge> borders;
  for (std::size_t first = 0, last = 0; first < edges.size(); first = last) {
    while (last < edges.size() && edges[last] == edges[first]) ++last;
    if (last - first == 1) borders.push_back(edges[first]);
  }
  return borders;
}

struct Segment {
  Vec3 a, along;
  double inverse_squared = 0.0;  // 1 / (length squared); 0: the segment is a point

  Segment(const Vec3& from, const Vec3& to) : a(from), along(to - from) {
    const double squared = along.squaredNorm();
    if (squared > 0.0) inverse_squared = 1.0 / squared;
  }
  double squared_distance(const Vec3& p) const {
    const Vec3 to_p = p - a;
    return (to_p - std::clamp(along.dot(to_p) * inverse_squared, 0.0, 1.0) * along).squaredNorm();
  }
};

// Points on boundary edges for which an edge within their radius is searched, in a kd-tree. A point is done once an edge was found, or
// after kMaxMisses edges were not within its radius. So thousands of points and edges in one place cost time in proportion to their
// number, not to its square.
class PendingPoints {
 public:
  struct Point {
    Vec3 at;
    double radius = 0.0;
    std::uint32_t edge = 0;    // its own edge, which does not count
    std::uint32_t misses = 0;  // edges tested that were not within the radius
    bool is_found = false;
    double squared_gap = 0.0;  // to the edge that was found, which need not be the nearest
  };

  explicit PendingPoints(std::vector<Point> points) : points_(std::move(points)) {
    const auto reach_of = [](const Point& p) {
      return Eigen::AlignedBox3d(p.at - Vec3::Constant(p.radius), p.at + Vec3::Constant(p.radius));
    };
    tree_ = MedianTree(points_, kLeafSize, reach_of, [](const Point& p) -> const Vec3& { return p.at; });
  }

  // Tests edge ab against all points that are not done.
  void test_edge(std::uint32_t edge, const Vec3& a, const Vec3& b) {
    const Segment segment(a, b);
    const SegmentSlabs slabs(a, b);
    const auto enter = [&](const MedianTree::Node& node) {
      ++work_;
      return node.open_items != 0 && slabs.meets(node.box.min(), node.box.max());
    };
    tree_.visit_open(enter, [&](std::uint32_t i) { return try_point(points_[i], edge, segment); });
  }

  const std::vector<Point>& points() const { return points_; }
  std::size_t work() const { return work_; }

 private:
  static constexpr std::uint32_t kLeafSize = 4;
  static constexpr std::uint32_t kMaxMisses = 512;  // misses of one point

  // True if the point is done now.
  bool try_point(Point& point, std::uint32_t edge, const Segment& segment) {
    if (point.is_found || point.misses == kMaxMisses || point.edge == edge) return false;
    ++work_;
    point.squared_gap = segment.squared_distance(point.at);
    point.is_found = point.squared_gap <= point.radius * point.radius;
    return point.is_found || ++point.misses == kMaxMisses;
  }

  std::vector<Point> points_;
  MedianTree tree_;  // `open_items` of a node: its points that are not done
  std::size_t work_ = 0;
};

std::vector<PendingPoints::Point> points_along(const TriangleMesh& mesh, const std::vector<Edge>& borders,
                                               const std::vector<std::uint32_t>& edges, const std::vector<double>& shares, double width) {
  std::vector<PendingPoints::Point> points;
  points.reserve(shares.size() * edges.size());
  for (const std::uint32_t e : edges) {
    const Vec3& from = mesh.vertices[borders[e].first];
    const Vec3 along = mesh.vertices[borders[e].second] - from;
    const double radius = std::min(width, kMaxGapShare * along.norm());
    for (const double share : shares) points.push_back({.at = from + share * along, .radius = radius, .edge = e});
  }
  return points;
}

double find_squared_gap(const TriangleMesh& mesh, const std::vector<Edge>& borders, const PendingPoints::Point& point) {
  double squared_gap = point.squared_gap;
  for (std::uint32_t e = 0; e < borders.size(); ++e) {
    if (e == point.edge) continue;
    squared_gap =
        std::min(squared_gap, Segment(mesh.vertices[borders[e].first], mesh.vertices[borders[e].second]).squared_distance(point.at));
  }
  return squared_gap;
}

// The widest of the gaps at these points. Exact gaps are computed in descending order of the gaps found so far, which are upper bounds,
// until no other gap can be wider. After kMaxMeasured points, the result is an upper bound.
double find_widest_gap(const TriangleMesh& mesh, const std::vector<Edge>& borders, std::vector<PendingPoints::Point> points,
                       std::size_t& work) {
  const std::size_t count = std::min(points.size(), kMaxMeasured + 1);
  std::partial_sort(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(count), points.end(),
                    [](const PendingPoints::Point& p, const PendingPoints::Point& q) {
                      return p.squared_gap != q.squared_gap ? p.squared_gap > q.squared_gap : p.edge < q.edge;
                    });
  double widest_squared = 0.0;
  for (std::size_t i = 0; i < count && points[i].squared_gap > widest_squared; ++i) {
    if (i == kMaxMeasured) return std::sqrt(points[i].squared_gap);
    widest_squared = std::max(widest_squared, find_squared_gap(mesh, borders, points[i]));
    work += borders.size();
  }
  return std::sqrt(widest_squared);
}

}  // namespace

BoundaryEdges count_boundary_edges(const TriangleMesh& mesh, double width, std::size_t most_work) {
  return count_boundary_edges(mesh, find_boundary_vertices(mesh), width, most_work);
}

BoundaryEdges count_boundary_edges(const TriangleMesh& mesh, const std::vector<std::uint8_t>& at_boundary, double width,
                                   std::size_t most_work) {
  const std::vector<Edge> borders = find_boundary_edges(mesh, at_boundary);
  std::vector<std::uint32_t> cracks(borders.size());
  std::iota(cracks.begin(), cracks.end(), 0U);
  BoundaryEdges count;
  std::vector<PendingPoints::Point> at_cracks;
  // Most edges have no other edge beside their middle. Only the rest is tested at further points.
  for (const std::vector<double>& shares : {std::vector{0.5}, std::vector{0.25, 0.75}}) {
    PendingPoints pending(points_along(mesh, borders, cracks, shares, width));
    if (cracks.empty()) break;
    for (std::uint32_t e = 0; e < borders.size() && !count.has_given_up; ++e) {
      pending.test_edge(e, mesh.vertices[borders[e].first], mesh.vertices[borders[e].second]);
      count.has_given_up = count.work + pending.work() > most_work * (borders.size() + kExtraEdges);
    }
    std::vector<std::uint8_t> found_points(borders.size(), 0);
    for (const PendingPoints::Point& point : pending.points()) {
      if (!point.is_found) continue;
      ++found_points[point.edge];
      at_cracks.push_back(point);
    }
    std::erase_if(cracks, [&](std::uint32_t e) { return found_points[e] < shares.size(); });
    count.work += pending.work();
  }
  std::erase_if(at_cracks,
                [&](const PendingPoints::Point& point) { return !std::binary_search(cracks.begin(), cracks.end(), point.edge); });
  count.widest_crack = find_widest_gap(mesh, borders, std::move(at_cracks), count.work);
  count.cracks = cracks.size();
  count.open = borders.size() - count.cracks;
  return count;
}

}  // namespace hapton
