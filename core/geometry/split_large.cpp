#include "core/geometry/split_large.h"

#include <fmt/core.h>

#include <algorithm>
#include <limits>
#include <unordered_map>

#include "core/geometry/corner_normals.h"
#include "core/geometry/shared_edges.h"

namespace hapton {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

struct Corner {
  std::uint32_t vertex;
  std::uint32_t normal;
};

// One round: every edge that is too long is halved once.
class Round {
 public:
  Round(ShadedMesh& mesh, double longest_edge) : mesh_(mesh), edges_(mesh.triangles), middle_(edges_.size(), kNone) {
    for (std::size_t e = 0; e < edges_.size(); ++e) {
      const HalfEdge& side = edges_[e][0];
      const Vec3& a = mesh_.vertices[side.low];
      const Vec3& b = mesh_.vertices[side.high];
      if (!((b - a).squaredNorm() > longest_edge * longest_edge)) continue;
      middle_[e] = static_cast<std::uint32_t>(mesh_.vertices.size() + marked_edges_);
      ++marked_edges_;
      added_triangles_ += edges_[e].size();
    }
  }

  std::size_t marked_edges() const { return marked_edges_; }
  std::size_t added_triangles() const { return added_triangles_; }

  void apply() {
    mesh_.vertices.resize(mesh_.vertices.size() + marked_edges_);
    mesh_.middle_vertices.resize(mesh_.middle_vertices.size() + marked_edges_);
    const std::size_t first_middle = mesh_.vertices.size() - mesh_.middle_vertices.size();
    for (std::size_t e = 0; e < edges_.size(); ++e) {
      if (middle_[e] == kNone) continue;
      const HalfEdge& side = edges_[e][0];
      mesh_.vertices[middle_[e]] = 0.5 * mesh_.vertices[side.low] + 0.5 * mesh_.vertices[side.high];
      mesh_.middle_vertices[middle_[e] - first_middle] = {side.low, side.high};
    }
    const auto count = static_cast<std::uint32_t>(mesh_.triangles.size());
    for (std::uint32_t t = 0; t < count; ++t) cut(t);
  }

 private:
  std::uint32_t middle_normal(std::uint32_t a, std::uint32_t b) {
    if (a == b) return a;
    const std::uint64_t key = (std::uint64_t{std::min(a, b)} << 32) | std::max(a, b);
    const auto [at, is_new] = middle_normals_.try_emplace(key, static_cast<std::uint32_t>(mesh_.normals.size()));
    if (is_new) {
      if (mesh_.middle_normals.empty()) mesh_.first_middle_normal = at->second;
      mesh_.middle_normals.push_back({std::min(a, b), std::max(a, b)});
      mesh_.normals.push_back(middle_normal_of(mesh_, mesh_.middle_normals.back()));
    }
    return at->second;
  }

  void replace_triangle(std::uint32_t t, const Corner& a, const Corner& b, const Corner& c) {
    mesh_.triangles[t] = {a.vertex, b.vertex, c.vertex};
    mesh_.corner_normals[t] = {a.normal, b.normal, c.normal};
  }
  void add_triangle(std::uint32_t from, const Corner& a, const Corner& b, const Corner& c) {
    mesh_.triangles.push_back({a.vertex, b.vertex, c.vertex});
    mesh_.corner_normals.push_back({a.normal, b.normal, c.normal});
    mesh_.source.push_back(mesh_.source[from]);
  }

  void cut(std::uint32_t t) {
    std::array<Corner, 3> corner;
    std::array<std::uint32_t, 3> middle;
    int marks = 0;
    for (int k = 0; k < 3; ++k) {
      corner[k] = {mesh_.triangles[t][k], mesh_.corner_normals[t][k]};
      middle[k] = middle_[edges_.edge_of(t, k)];
      marks += middle[k] != kNone ? 1 : 0;
    }
    if (marks == 0) return;
    std::array<Corner, 3> half{};
    for (int k = 0; k < 3; ++k) {
      if (middle[k] != kNone) half[k] = {middle[k], middle_normal(corner[k].normal, corner[(k + 1) % 3].normal)};
    }
    if (marks == 3) {
      replace_triangle(t, half[0], half[1], half[2]);
      for (int k = 0; k < 3; ++k) add_triangle(t, corner[k], half[k], half[(k + 2) % 3]);
      return;
    }
    // Rotates the corners so that edge 0 is the marked edge, or edges 0 and 1 are the two marked edges.
    int turn = 0;
    while (marks == 1 ? middle[turn] == kNone : middle[(turn + 2) % 3] != kNone) ++turn;
    const auto c = [&](int k) { return corner[(turn + k) % 3]; };
    const auto h = [&](int k) { return half[(turn + k) % 3]; };
    if (marks == 1) {
      replace_triangle(t, c(0), h(0), c(2));
      add_triangle(t, h(0), c(1), c(2));
      return;
    }
    replace_triangle(t, h(0), c(1), h(1));
    // Divides the remaining quadrilateral along its shorter diagonal.
    const auto place = [&](const Corner& at) { return mesh_.vertices[at.vertex]; };
    if ((place(h(1)) - place(c(0))).squaredNorm() <= (place(c(2)) - place(h(0))).squaredNorm()) {
      add_triangle(t, c(0), h(0), h(1));
      add_triangle(t, c(0), h(1), c(2));
    } else {
      add_triangle(t, c(0), h(0), c(2));
      add_triangle(t, h(0), h(1), c(2));
    }
  }

  ShadedMesh& mesh_;
  SharedEdges edges_;
  std::vector<std::uint32_t> middle_;
  std::unordered_map<std::uint64_t, std::uint32_t> middle_normals_;
  std::size_t marked_edges_ = 0;
  std::size_t added_triangles_ = 0;
};

}  // namespace

SplitReport split_large(ShadedMesh& mesh, double longest_edge, std::size_t max_triangles) {
  SplitReport report;
  report.longest_edge = longest_edge;
  const std::size_t before = mesh.triangles.size();
  while (longest_edge > 0.0) {
    Round round(mesh, longest_edge);
    if (round.marked_edges() == 0) break;
    if (mesh.triangles.size() + round.added_triangles() > max_triangles) {
      report.complete = false;
      break;
    }
    round.apply();
    report.edges += round.marked_edges();
  }
  report.triangles = mesh.triangles.size() - before;
  return report;
}

std::string SplitReport::describe() const {
  return fmt::format("split: {} edges longer than {:g} m halved, {} triangles added{}", edges, longest_edge, triangles,
                     complete ? "" : "; some stay long: the limit on triangles was reached");
}

}  // namespace hapton
