#include "core/geometry/mesh_topology.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/disjoint_sets.h"

namespace hapton {
namespace {

constexpr double kDegenerateArea = 1e-14;  // largest area of a degenerate triangle, over its longest edge squared
constexpr double kNeedleHeight = 0.01;     // height below which a triangle is a needle, over its longest edge

bool repeats_vertex(const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

// One side of one triangle.
struct HalfEdge {
  std::uint32_t high = 0;    // the edge's vertex with the higher number
  std::uint32_t corner = 0;  // 3 * triangle + k: the side runs from corner k to k + 1
  bool is_upward = false;    // from the vertex with the lower number to the other
};

std::uint32_t next_corner(std::uint32_t corner) { return corner % 3 == 2 ? corner - 2 : corner + 1; }

// Items in buckets 0..count-1, in the order of their arrival.
template <class Item>
struct Buckets {
  std::vector<std::size_t> first;
  std::vector<Item> items;

  std::span<Item> operator[](std::size_t bucket) {
    return std::span<Item>(items).subspan(first[bucket], first[bucket + 1] - first[bucket]);
  }
};

// Counting sort in two passes. Each pass calls each(add), which calls add(bucket, item) for every item.
template <class Item, class Each>
Buckets<Item> fill_buckets(std::size_t count, Each each) {
  Buckets<Item> buckets;
  buckets.first.assign(count + 1, 0);
  each([&](std::size_t bucket, const Item&) { ++buckets.first[bucket + 1]; });
  std::partial_sum(buckets.first.begin(), buckets.first.end(), buckets.first.begin());
  buckets.items.resize(buckets.first.back());
  std::vector<std::size_t> next(buckets.first.begin(), buckets.first.end() - 1);
  each([&](std::size_t bucket, const Item& item) { buckets.items[next[bucket]++] = item; });
  return buckets;
}

class TopologyCounter {
 public:
  explicit TopologyCounter(const TriangleMesh& mesh) : mesh_(mesh) {}

  MeshTopology count() {
    result_.triangles = mesh_.triangles.size();
    count_shapes();
    count_edges();
    count_vertices_and_components();
    count_duplicates();
    return result_;
  }

 private:
  void count_shapes() {
    if (mesh_.triangles.empty()) return;
    Eigen::AlignedBox3d box;
    for (const Triangle& t : mesh_.triangles) {
      for (const std::uint32_t v : t) box.extend(mesh_.vertices[v]);
    }
    result_.lowest = box.min();
    result_.highest = box.max();
    const Vec3 centre = box.center();
    Vec3 area_vector = Vec3::Zero();
    for (const Triangle& t : mesh_.triangles) count_shape(t, centre, area_vector);
    // So far this is the volume between surface and box centre, which keeps the digits of a small mesh far from the origin. This term makes
    // it the volume between surface and origin; the term is zero for a closed mesh.
    result_.signed_volume += centre.dot(area_vector) / 3.0;
  }

  void count_shape(const Triangle& t, const Vec3& centre, Vec3& area_vector) {
    const Vec3& a = mesh_.vertices[t[0]];
    const Vec3& b = mesh_.vertices[t[1]];
    const Vec3& c = mesh_.vertices[t[2]];
    const double longest2 = std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
    const Vec3 normal = 0.5 * (b - a).cross(c - a);
    const double area = normal.norm();
    area_vector += normal;
    if (repeats_vertex(t) || area <= kDegenerateArea * longest2)
      ++result_.degenerate_triangles;
    else if (2.0 * area < kNeedleHeight * longest2)
      ++result_.needle_triangles;
    result_.signed_volume += (a - centre).dot((b - centre).cross(c - centre)) / 6.0;
  }

  void count_edges() {
    auto edges = fill_buckets<HalfEdge>(mesh_.vertices.size(), [&](auto add) {
      for (std::uint32_t corner = 0; corner < 3 * mesh_.triangles.size(); ++corner) {
        const std::uint32_t from = vertex_at(corner);
        const std::uint32_t to = vertex_at(next_corner(corner));
        if (from != to) add(std::min(from, to), HalfEdge{.high = std::max(from, to), .corner = corner, .is_upward = from < to});
      }
    });
    DisjointSets fans(3 * mesh_.triangles.size());
    std::vector<double> lengths;
    for (std::size_t low = 0; low < mesh_.vertices.size(); ++low) {
      const std::span<HalfEdge> around = edges[low];
      std::stable_sort(around.begin(), around.end(), [](const HalfEdge& a, const HalfEdge& b) { return a.high < b.high; });
      for (std::size_t begin = 0, end = 0; begin < around.size(); begin = end) {
        while (end < around.size() && around[end].high == around[begin].high) ++end;
        count_edge(around.subspan(begin, end - begin), fans);
        lengths.push_back((mesh_.vertices[around[begin].high] - mesh_.vertices[low]).norm());
      }
    }
    count_fans(fans);
    if (lengths.empty()) return;
    const auto median = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
    std::nth_element(lengths.begin(), median, lengths.end());
    result_.median_edge = *median;
    const auto [shortest, longest] = std::minmax_element(lengths.begin(), lengths.end());
    result_.shortest_edge = *shortest;
    result_.longest_edge = *longest;
  }

  void count_edge(std::span<const HalfEdge> sides, DisjointSets& fans) {
    if (sides.size() == 1) ++result_.boundary_edges;
    if (sides.size() > 2) ++result_.nonmanifold_edges;
    if (sides.size() == 2 && sides[0].is_upward == sides[1].is_upward) ++result_.inconsistent_edges;
    for (std::size_t i = 1; i < sides.size(); ++i) {
      fans.join(corner_at_low(sides[0]), corner_at_low(sides[i]));
      fans.join(corner_at_high(sides[0]), corner_at_high(sides[i]));
    }
  }

  static std::uint32_t corner_at_low(const HalfEdge& side) { return side.is_upward ? side.corner : next_corner(side.corner); }
  static std::uint32_t corner_at_high(const HalfEdge& side) { return side.is_upward ? next_corner(side.corner) : side.corner; }

  // A vertex is manifold if all its corners are in one fan.
  void count_fans(DisjointSets& fans) {
    std::vector<std::uint32_t> fan_count(mesh_.vertices.size(), 0);
    for (std::uint32_t corner = 0; corner < 3 * mesh_.triangles.size(); ++corner) {
      if (!repeats_vertex(mesh_.triangles[corner / 3]) && fans.root(corner) == corner) ++fan_count[vertex_at(corner)];
    }
    result_.nonmanifold_vertices =
        static_cast<std::size_t>(std::count_if(fan_count.begin(), fan_count.end(), [](auto n) { return n > 1; }));
  }

  void count_vertices_and_components() {
    DisjointSets pieces(mesh_.vertices.size());
    std::vector<bool> used(mesh_.vertices.size(), false);
    for (const Triangle& t : mesh_.triangles) {
      pieces.join(t[0], t[1]);
      pieces.join(t[1], t[2]);
      for (const std::uint32_t v : t) used[v] = true;
    }
    for (std::uint32_t v = 0; v < used.size(); ++v) {
      result_.vertices += used[v] ? 1 : 0;
      result_.components += used[v] && pieces.root(v) == v ? 1 : 0;
    }
  }

  void count_duplicates() {
    using HigherTwo = std::pair<std::uint32_t, std::uint32_t>;
    auto by_lowest = fill_buckets<HigherTwo>(mesh_.vertices.size(), [&](auto add) {
      for (Triangle t : mesh_.triangles) {
        std::sort(t.begin(), t.end());
        add(t[0], HigherTwo(t[1], t[2]));
      }
    });
    for (std::size_t v = 0; v < mesh_.vertices.size(); ++v) {
      const std::span<HigherTwo> higher = by_lowest[v];
      std::sort(higher.begin(), higher.end());
      for (std::size_t i = 1; i < higher.size(); ++i) result_.duplicate_triangles += higher[i] == higher[i - 1] ? 1 : 0;
    }
  }

  std::uint32_t vertex_at(std::uint32_t corner) const { return mesh_.triangles[corner / 3][corner % 3]; }

  const TriangleMesh& mesh_;
  MeshTopology result_;
};

}  // namespace

MeshTopology compute_mesh_topology(const TriangleMesh& mesh) { return TopologyCounter(mesh).count(); }

}  // namespace hapton
