#include "core/geometry/normal_fans.h"

#include <fmt/core.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/shared_edges.h"

namespace hapton {
namespace {

// One side of the gap that the edge fans leave at a vertex: the normal turns from `from` to `to`.
struct Turn {
  std::uint32_t vertex;
  std::uint32_t from;
  std::uint32_t to;
  std::uint32_t source;
};

void add(ShadedMesh& mesh, const Triangle& vertices, const Triangle& normals, std::uint32_t source) {
  mesh.triangles.push_back(vertices);
  mesh.corner_normals.push_back(normals);
  mesh.source.push_back(source);
}

// The turns at one vertex; each can be taken once. A hostile file may have a hundred thousand of them. Pre: sorted by `from`.
class OpenTurns {
 public:
  explicit OpenTurns(std::span<const Turn> turns) : turns_(turns), is_taken_(turns.size(), false), taken_from_(turns.size(), 0) {}

  // The last turn that is not taken yet; null: all are taken.
  const Turn* take_last() {
    while (!turns_.empty() && is_taken_[turns_.size() - 1]) turns_ = turns_.first(turns_.size() - 1);
    return turns_.empty() ? nullptr : take(turns_.size() - 1);
  }
  // The first turn from this normal that is not taken yet; null: all of these are taken.
  const Turn* take_from(std::uint32_t normal) {
    const auto group = static_cast<std::size_t>(std::ranges::lower_bound(turns_, normal, {}, &Turn::from) - turns_.begin());
    if (group == turns_.size()) return nullptr;
    const std::size_t at = group + taken_from_[group];
    if (at == turns_.size() || turns_[at].from != normal || is_taken_[at]) return nullptr;
    ++taken_from_[group];
    return take(at);
  }

 private:
  const Turn* take(std::size_t at) {
    is_taken_[at] = true;
    return &turns_[at];
  }

  std::span<const Turn> turns_;  // without the taken turns at its end
  std::vector<bool> is_taken_;
  std::vector<std::size_t> taken_from_;  // by index of the first turn from a normal: how many turns from it take_from() has taken
};

// Links the turns of one vertex into rings; adds a fan of triangles over each ring of three or more.
void fill_vertex(ShadedMesh& mesh, std::span<const Turn> turns, NormalFanReport& report) {
  bool has_open_turn = false;
  OpenTurns open_turns(turns);
  while (const Turn* start = open_turns.take_last()) {
    std::vector<std::uint32_t> ring = {start->from};
    std::uint32_t at = start->to;
    while (at != start->from) {
      const Turn* next = open_turns.take_from(at);
      if (next == nullptr) break;
      ring.push_back(at);
      at = next->to;
    }
    if (at != start->from) {
      has_open_turn = true;
      continue;
    }
    for (std::size_t i = 1; i + 1 < ring.size(); ++i) {
      add(mesh, {start->vertex, start->vertex, start->vertex}, {ring[0], ring[i], ring[i + 1]}, start->source);
      ++report.corner_fans;
    }
  }
  report.open_corners += has_open_turn ? 1 : 0;
}

}  // namespace

NormalFanReport add_normal_fans(ShadedMesh& mesh) {
  NormalFanReport report;
  const auto faces = static_cast<std::uint32_t>(mesh.triangles.size());
  const SharedEdges edges(mesh.triangles);
  std::vector<Turn> turns;
  for (std::uint32_t t = 0; t < faces; ++t) {
    for (int k = 0; k < 3; ++k) {
      const HalfEdge* other = edges.adjacent(t, k);
      if (other == nullptr || other->triangle < t) continue;
      const std::uint32_t v0 = mesh.triangles[t][k];
      const std::uint32_t v1 = mesh.triangles[t][(k + 1) % 3];
      if ((v0 < v1) == other->upward) continue;  // inconsistently oriented: the normals do not turn, they flip
      const std::uint32_t a0 = mesh.corner_normals[t][k];
      const std::uint32_t a1 = mesh.corner_normals[t][(k + 1) % 3];
      const std::uint32_t b1 = mesh.corner_normals[other->triangle][other->corner];
      const std::uint32_t b0 = mesh.corner_normals[other->triangle][(other->corner + 1) % 3];
      // t traverses the edge from v0 to v1. So the fan traverses it from v1 to v0 beside t, and from v0 to v1 beside the other triangle.
      if (a0 != b0) {
        add(mesh, {v1, v0, v0}, {a1, a0, b0}, mesh.source[t]);
        ++report.edge_fans;
        turns.push_back({v0, b0, a0, mesh.source[t]});
      }
      if (a1 != b1) {
        add(mesh, {v1, v0, v1}, {a1, b0, b1}, mesh.source[t]);
        ++report.edge_fans;
        turns.push_back({v1, a1, b1, mesh.source[t]});
      }
    }
  }
  std::sort(turns.begin(), turns.end(),
            [](const Turn& a, const Turn& b) { return a.vertex != b.vertex ? a.vertex < b.vertex : a.from < b.from; });
  for (std::size_t first = 0; first < turns.size();) {
    std::size_t last = first;
    while (last < turns.size() && turns[last].vertex == turns[first].vertex) ++last;
    fill_vertex(mesh, std::span(turns).subspan(first, last - first), report);
    first = last;
  }
  return report;
}

std::string NormalFanReport::describe() const {
  return fmt::format("fans: {} degenerate triangles along edges, {} at corners; {} corners without a complete fan", edge_fans, corner_fans,
                     open_corners);
}

}  // namespace hapton
