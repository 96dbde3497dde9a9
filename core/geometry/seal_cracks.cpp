#include "core/geometry/seal_cracks.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "core/geometry/mesh_measures.h"
#include "core/geometry/seam_joiner.h"
#include "core/geometry/vertex_tree.h"

namespace hapton {
namespace {

constexpr int kMostTries = 16;
constexpr std::size_t kMostWork = 5000;  // per boundary edge: surfaces need less than a fiftieth of that
// Limit on complete repetitions, so that many close vertices do not take minutes: surfaces need one or two, dense clusters dozens. A small
// boundary may take more: kMostJoinedVertices in all.
constexpr std::size_t kMostJoins = 6;
constexpr std::size_t kMostJoinedVertices = 200'000;

struct WorkBudget {
  std::size_t left = 0;
  std::size_t joins_left = 0;
  bool is_spent = false;
};

WorkBudget make_budget(const std::vector<std::uint8_t>& at_boundary) {
  const auto vertices = static_cast<std::size_t>(std::count(at_boundary.begin(), at_boundary.end(), 1));
  return {.left = kMostWork * vertices, .joins_left = std::max(kMostJoins, kMostJoinedVertices / std::max<std::size_t>(vertices, 1))};
}

// Joins until nothing more can be joined, so that sealing again finds nothing. Where that would go too far, the parts that led there are
// excluded and everything is repeated: a notch, say, whose sides are close at its tip would be zipped up from there, vertex by vertex.
// Calls use(joiner, joined mesh) at the end; not if there is no boundary or the budget is used up.
template <class Use>
void join(const TriangleMesh& mesh, double share, JoinedParts& untouched, WorkBudget& budget, Use&& use) {
  const std::vector<std::uint8_t> at_boundary = find_boundary_vertices(mesh);
  if (at_boundary.empty()) return;
  const double tolerance = share * compute_bounds(mesh).extent();
  for (int tries = 1;; ++tries) {
    const std::size_t before = untouched.size();
    TriangleMesh joined_mesh = mesh;
    SeamJoiner joiner(joined_mesh, at_boundary, tolerance, untouched);
    if (budget.joins_left == 0 || !joiner.run(budget.left)) {
      budget.is_spent = true;
      return;
    }
    budget.left -= joiner.work();
    --budget.joins_left;
    if (untouched.size() > before && tries < kMostTries) continue;
    use(joiner, joined_mesh);
    return;
  }
}

// The parts of the original mesh that joining the joined mesh once more would join.
JoinedParts find_unsettled(const SeamMesh& seam, const SeamMesh::Sources& sources, const TriangleMesh& joined_mesh, double share,
                           WorkBudget& budget) {
  JoinedParts unsettled;
  JoinedParts none;
  join(joined_mesh, share, none, budget, [&](SeamJoiner& again, const TriangleMesh&) {
    const JoinedParts joined = again.joined();
    for (const std::uint32_t vertex : joined.vertices)
      seam.for_each_member(sources.vertices[vertex], [&](std::uint32_t member) { unsettled.vertices.insert(member); });
    for (const std::uint32_t chord : joined.chords) unsettled.chords.insert(3 * sources.triangles[chord / 3] + chord % 3);
  });
  return unsettled;
}

// Excludes the boundary within `radius` of these parts.
void leave_untouched(const TriangleMesh& mesh, const JoinedParts& parts, double radius, JoinedParts& untouched) {
  untouched.vertices.insert(parts.vertices.begin(), parts.vertices.end());
  untouched.chords.insert(parts.chords.begin(), parts.chords.end());
  const VertexTree tree(mesh.vertices, {parts.vertices.begin(), parts.vertices.end()});
  const std::vector<std::uint8_t> at_boundary = find_boundary_vertices(mesh);
  std::vector<VertexTree::Found> found;
  for (std::uint32_t v = 0; v < at_boundary.size(); ++v) {
    if (at_boundary[v] == 0) continue;
    tree.find_nearest(mesh.vertices[v], SeamMesh::kNone, radius, 1, found);
    if (!found.empty()) untouched.vertices.insert(v);
  }
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t a = mesh.triangles[t][k];
      const std::uint32_t b = mesh.triangles[t][(k + 1) % 3];
      if (at_boundary[a] != 0 && at_boundary[b] != 0 && (untouched.vertices.contains(a) || untouched.vertices.contains(b)))
        untouched.chords.insert(3 * t + k);
    }
  }
}

SealReport report_on(SeamJoiner& joiner) {
  return {.welded_vertices = joiner.seam().welded(),
          .split_triangles = joiner.seam().splits(),
          .zipped_edges = joiner.seam().zipped(),
          .widest_gap = joiner.widest_gap(),
          .tolerance = joiner.seam().tolerance(),
          .boundary_edges = joiner.boundary_edges(),
          .boundary_edges_left = joiner.seam().boundary_edges().size()};
}

SealReport give_up(const TriangleMesh& mesh, double tolerance) {
  const std::size_t edges = count_edges(mesh).boundary;
  return {.tolerance = tolerance, .boundary_edges = edges, .boundary_edges_left = edges, .has_given_up = true};
}

}  // namespace

TriangleMesh seal_cracks(TriangleMesh mesh, SealReport& report, double share, std::vector<std::uint32_t>* source) {
  report = {};
  if (source != nullptr) {
    source->resize(mesh.triangles.size());
    std::iota(source->begin(), source->end(), 0U);
  }
  JoinedParts untouched;
  WorkBudget budget = make_budget(find_boundary_vertices(mesh));
  bool is_settled = false;
  for (int tries = 1; !is_settled; ++tries) {
    is_settled = true;
    join(mesh, share, untouched, budget, [&](SeamJoiner& joiner, TriangleMesh& sealed) {
      report = report_on(joiner);
      if (!report.has_sealed()) return;
      SeamMesh::Sources sources = joiner.seam().finish();
      const JoinedParts unsettled = find_unsettled(joiner.seam(), sources, sealed, share, budget);
      if (budget.is_spent) return;
      if (unsettled.size() > 0) {
        // Clusters thinner than the tolerance, where joining some vertices moves others. They are excluded, in growing neighbourhoods if
        // necessary.
        leave_untouched(mesh, unsettled, tries == 1 ? 0.0 : report.tolerance * std::exp2(tries - 2), untouched);
        is_settled = false;
        return;
      }
      if (source != nullptr) *source = std::move(sources.triangles);
      mesh = std::move(sealed);
    });
  }
  if (budget.is_spent) report = give_up(mesh, share * compute_bounds(mesh).extent());
  return mesh;
}

std::string SealReport::describe() const {
  if (has_given_up) {
    return fmt::format("cracks not sealed: its {} boundary edges lie too close together to identify gaps of {:.3g} m; repair the mesh",
                       boundary_edges, tolerance);
  }
  if (!has_sealed()) return fmt::format("no cracks up to {:.3g} m wide; {} boundary edges", tolerance, boundary_edges);
  return fmt::format(
      "sealed cracks up to {:.3g} m wide: welded {} vertices, split {} triangles, joined {} pairs of boundary edges; {} of {} left",
      widest_gap, welded_vertices, split_triangles, zipped_edges, boundary_edges_left, boundary_edges);
}

}  // namespace hapton
