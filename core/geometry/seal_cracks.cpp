#include "core/geometry/seal_cracks.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "core/geometry/boundary_edges.h"
#include "core/geometry/closest_point.h"
#include "core/geometry/mesh_measures.h"
#include "core/geometry/seam_joiner.h"
#include "core/geometry/vertex_tree.h"

namespace hapton {
namespace {

constexpr int kMaxTries = 16;                    // attempts of join() and of join_until_settled(); kMaxJoins and kMaxWork bound the time
constexpr int kMaxPasses = 8;                    // of join_in_passes(); ordinary surfaces need one or two that change something
constexpr double kMaxOffsetOfPart = 2.0;         // largest distance of a part of a split triangle from that triangle, in tolerances
constexpr std::size_t kMaxWork = 5000;           // per boundary vertex; ordinary surfaces need less than a fiftieth of that
constexpr std::size_t kTrianglesPerVertex = 64;  // so many triangles of the mesh cost as much as one boundary vertex
// Limit on repetitions of a whole join, so that many close vertices do not take minutes: ordinary surfaces need one or two, dense clusters
// dozens. A small mesh may have more repetitions, until all together have cost as much as kMaxJoinedVertices boundary vertices.
constexpr std::size_t kMaxJoins = 6;
constexpr std::size_t kMaxJoinedVertices = 60'000;

struct WorkBudget {
  std::size_t work_left = 0;
  std::size_t vertices_left = 0;
  bool is_spent = false;
  bool is_crowded = false;  // one join alone takes too much work
};

std::size_t count_vertices(const std::vector<std::uint8_t>& at_boundary) {
  return static_cast<std::size_t>(std::count(at_boundary.begin(), at_boundary.end(), 1));
}

std::size_t cost_of_join(const TriangleMesh& mesh, const std::vector<std::uint8_t>& at_boundary) {
  return count_vertices(at_boundary) + mesh.triangles.size() / kTrianglesPerVertex;
}

WorkBudget make_budget(const TriangleMesh& mesh, const std::vector<std::uint8_t>& at_boundary) {
  return {.work_left = kMaxWork * count_vertices(at_boundary),
          .vertices_left = std::max(kMaxJoins * cost_of_join(mesh, at_boundary), kMaxJoinedVertices)};
}

struct Method {
  double share = kSealedShare;
  Turning turning = Turning::any;
};

// Joins until nothing more can be joined. Parts whose joining would exceed the tolerance are added to `excluded`, and everything is
// repeated: the sides of a notch, for example, are close at its tip, and would be zipped up from the tip, vertex by vertex.
// Calls use(joiner, joined mesh) at the end, unless there is no boundary or the budget is used up.
template <class Use>
void join(const TriangleMesh& mesh, const Method& method, SeamParts& excluded, WorkBudget& budget, Use&& use) {
  const std::vector<std::uint8_t> at_boundary = find_boundary_vertices(mesh);
  if (at_boundary.empty()) return;
  const double tolerance = method.share * compute_bounds(mesh).extent();
  const std::size_t cost = cost_of_join(mesh, at_boundary);
  for (int tries = 1;; ++tries) {
    const std::size_t before = excluded.size();
    TriangleMesh joined_mesh = mesh;
    SeamJoiner joiner(joined_mesh, at_boundary, tolerance, excluded, method.turning);
    budget.is_spent = budget.vertices_left < cost;
    if (budget.is_spent) return;
    if (!joiner.run(budget.work_left)) {
      budget.is_spent = budget.is_crowded = true;
      return;
    }
    budget.work_left -= joiner.work();
    budget.vertices_left -= cost;
    if (excluded.size() > before && tries < kMaxTries) continue;
    use(joiner, joined_mesh);
    return;
  }
}

// A mesh that was joined once or more, compared with the given one; mesh and mapping are empty if nothing was joined.
struct Sealing {
  TriangleMesh mesh;
  SealReport report;
  SeamMesh::Mapping mapping;
  bool is_settled = false;  // there is nothing left to join
};

SealReport make_report(SeamJoiner& joiner) {
  return {.welded_vertices = joiner.seam().welded(),
          .split_triangles = joiner.seam().splits(),
          .zipped_edges = joiner.seam().zipped(),
          .widest_gap = joiner.widest_gap(),
          .tolerance = joiner.seam().tolerance(),
          .boundary_edges = joiner.boundary_edges(),
          .boundary_edges_left = joiner.seam().boundary_edges().size()};
}

void add(const SealReport& next, SealReport& report) {
  report.welded_vertices += next.welded_vertices;
  report.split_triangles += next.split_triangles;
  report.zipped_edges += next.zipped_edges;
  report.widest_gap = std::max(report.widest_gap, next.widest_gap);
  report.boundary_edges_left = next.boundary_edges_left;
}

// Adds to `sealing` what was joined next, on the mesh in `sealing`.
void add(Sealing next, Sealing& sealing) {
  if (!sealing.report.has_sealed()) {
    sealing = std::move(next);
    return;
  }
  add(next.report, sealing.report);
  sealing.mesh = std::move(next.mesh);
  for (std::uint32_t& vertex : sealing.mapping.resulting_vertices) vertex = next.mapping.resulting_vertices[vertex];
  for (std::uint32_t& triangle : next.mapping.source_triangles) triangle = sealing.mapping.source_triangles[triangle];
  sealing.mapping.source_triangles = std::move(next.mapping.source_triangles);
}

// Returns the excluded parts of the given mesh as parts of the mesh in `sealing`.
SeamParts to_sealed_parts(const SeamParts& parts, const TriangleMesh& mesh, const Sealing& sealing) {
  SeamParts sealed_parts;
  const std::vector<std::uint32_t>& sealed_vertex = sealing.mapping.resulting_vertices;
  for (const std::uint32_t v : parts.vertices) sealed_parts.vertices.insert(sealed_vertex[v]);
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const std::uint32_t chord : parts.chords) {
    const Triangle& t = mesh.triangles[chord / 3];
    edges.insert(std::minmax({sealed_vertex[t[chord % 3]], sealed_vertex[t[(chord + 1) % 3]]}));
  }
  if (edges.empty()) return sealed_parts;
  for (std::uint32_t t = 0; t < sealing.mesh.triangles.size(); ++t) {
    const Triangle& triangle = sealing.mesh.triangles[t];
    for (std::uint32_t k = 0; k < 3; ++k) {
      if (edges.contains(std::minmax({triangle[k], triangle[(k + 1) % 3]}))) sealed_parts.chords.insert(3 * t + k);
    }
  }
  return sealed_parts;
}

// Joins in passes until nothing more can be joined. The parts in `excluded` stay as they are.
Sealing join_in_passes(const TriangleMesh& mesh, const Method& method, SeamParts& excluded, WorkBudget& budget) {
  Sealing sealing;
  for (int pass = 0; pass <= kMaxPasses && !sealing.is_settled && !budget.is_spent; ++pass) {
    SeamParts followed;
    if (pass > 0) followed = to_sealed_parts(excluded, mesh, sealing);
    Sealing next{.mesh = {}, .report = {}, .mapping = {}, .is_settled = true};
    join(pass == 0 ? mesh : sealing.mesh, method, pass == 0 ? excluded : followed, budget, [&](SeamJoiner& joiner, TriangleMesh& joined) {
      next.report = make_report(joiner);
      if (!next.report.has_sealed()) return;
      next.mapping = joiner.seam().finish();
      next.mesh = std::move(joined);
      next.is_settled = false;
    });
    if (pass == 0 || next.report.has_sealed())
      add(std::move(next), sealing);
    else
      sealing.is_settled = true;
  }
  return sealing;
}

std::array<Vec3, 3> corners_of(const TriangleMesh& mesh, std::size_t t) {
  return {mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)};
}

bool is_in_bounds(const std::array<Vec3, 3>& before, const std::array<Vec3, 3>& after, bool is_part, double tolerance) {
  if (!is_sound_change(before, after, tolerance)) return false;
  if (!is_part) return true;
  return std::all_of(after.begin(), after.end(), [&](const Vec3& corner) {
    return closest_point(before[0], before[1], before[2], corner).distance <= kMaxOffsetOfPart * tolerance;
  });
}

// What several passes together have changed too much: vertices of the given mesh that moved farther than the tolerance and, for a triangle
// that changed beyond the bounds (is_in_bounds), its edges if it was split, otherwise its vertices.
SeamParts find_excessive_changes(const TriangleMesh& mesh, const Sealing& sealing) {
  SeamParts found;
  const double tolerance = sealing.report.tolerance;
  const SeamMesh::Mapping& mapping = sealing.mapping;
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
    if (!((sealing.mesh.vertices[mapping.resulting_vertices[v]] - mesh.vertices[v]).norm() <= tolerance)) found.vertices.insert(v);
  }
  std::vector<std::uint32_t> parts(mesh.triangles.size(), 0);
  for (const std::uint32_t t : mapping.source_triangles) ++parts[t];
  for (std::uint32_t t = 0; t < sealing.mesh.triangles.size(); ++t) {
    const std::uint32_t source = mapping.source_triangles[t];
    const std::array<Vec3, 3> before = corners_of(mesh, source);
    const std::array<Vec3, 3> after = corners_of(sealing.mesh, t);
    const bool is_part = parts[source] > 1;
    if (before == after || is_in_bounds(before, after, is_part, tolerance)) continue;
    if (is_part) {
      found.chords.insert({3 * source, 3 * source + 1, 3 * source + 2});
    } else {
      found.vertices.insert(mesh.triangles[source].begin(), mesh.triangles[source].end());
    }
  }
  return found;
}

// Excludes parts. Each time a part has to be excluded again, a larger neighbourhood of it is excluded, too.
class Exclusion {
 public:
  Exclusion(const TriangleMesh& mesh, double radius) : mesh_(mesh), at_boundary_(find_boundary_vertices(mesh)), radius_(radius) {}

  void exclude(const SeamParts& parts, SeamParts& excluded) {
    std::map<int, std::unordered_set<std::uint32_t>> by_rings;
    const auto exclude_vertex = [&](std::uint32_t v) { by_rings[exclusion_counts_[v]++].insert(v); };
    for (const std::uint32_t v : parts.vertices) exclude_vertex(v);
    for (const std::uint32_t chord : parts.chords) {
      if (!excluded.chords.insert(chord).second) exclude_vertex(mesh_.triangles[chord / 3][chord % 3]);
    }
    if (by_rings.empty()) return;
    std::unordered_set<std::uint32_t> reached;
    for (int rings = by_rings.rbegin()->first; rings >= 0; --rings) {
      if (const auto found = by_rings.find(rings); found != by_rings.end()) reached.insert(found->second.begin(), found->second.end());
      if (rings > 0) grow(reached);
    }
    excluded.vertices.insert(reached.begin(), reached.end());
  }

 private:
  // Adds the boundary vertices near the reached ones, and the boundary vertices of triangles at the reached ones.
  void grow(std::unordered_set<std::uint32_t>& reached) const {
    const VertexTree tree(mesh_.vertices, {reached.begin(), reached.end()});
    std::vector<VertexTree::NearVertex> found;
    std::unordered_set<std::uint32_t> more;
    for (std::uint32_t v = 0; v < at_boundary_.size(); ++v) {
      if (at_boundary_[v] == 0) continue;
      tree.find_nearest(mesh_.vertices[v], SeamMesh::kNone, radius_, 1, found);
      if (!found.empty()) more.insert(v);
    }
    for (const Triangle& t : mesh_.triangles) {
      if (std::none_of(t.begin(), t.end(), [&](std::uint32_t v) { return reached.contains(v); })) continue;
      std::copy_if(t.begin(), t.end(), std::inserter(more, more.end()), [&](std::uint32_t v) { return at_boundary_[v] != 0; });
    }
    reached.insert(more.begin(), more.end());
  }

  const TriangleMesh& mesh_;
  std::vector<std::uint8_t> at_boundary_;
  double radius_;
  std::unordered_map<std::uint32_t, int> exclusion_counts_;
};

// Joins in passes. If they change parts too much, excludes these and repeats the passes. Returns nothing if the budget is used up.
std::optional<Sealing> join_in_bounds(const TriangleMesh& mesh, const Method& method, SeamParts& excluded, WorkBudget& budget) {
  std::optional<Exclusion> exclusion;
  for (;;) {
    Sealing sealing = join_in_passes(mesh, method, excluded, budget);
    if (budget.is_spent) return std::nullopt;
    if (!sealing.report.has_sealed()) return sealing;
    const SeamParts excessive = find_excessive_changes(mesh, sealing);
    if (excessive.size() == 0) return sealing;
    if (!exclusion) exclusion.emplace(mesh, sealing.report.tolerance);
    exclusion->exclude(excessive, excluded);
  }
}

// Calls join_in_bounds(), and then repeats it on its result without exclusions until there is nothing to join.
std::optional<Sealing> join_until_settled(const TriangleMesh& mesh, const Method& method, SeamParts& excluded, WorkBudget& budget) {
  std::optional<Sealing> sealing = join_in_bounds(mesh, method, excluded, budget);
  if (!sealing || !sealing->report.has_sealed() || (excluded.size() == 0 && sealing->is_settled)) return sealing;
  sealing->is_settled = false;
  for (int tries = 0; tries < kMaxTries && !sealing->is_settled; ++tries) {
    SeamParts none;
    std::optional<Sealing> again = join_in_bounds(sealing->mesh, method, none, budget);
    if (!again) return std::nullopt;
    if (again->report.has_sealed())
      add(std::move(*again), *sealing);
    else
      sealing->is_settled = true;
  }
  return sealing;
}

// Seals so that sealing the result by the same method changes nothing.
std::optional<Sealing> seal(const TriangleMesh& mesh, const Method& method, SeamParts& excluded, WorkBudget& budget) {
  std::optional<Exclusion> exclusion;
  for (;;) {
    std::optional<Sealing> sealing = join_until_settled(mesh, method, excluded, budget);
    if (!sealing || !sealing->report.has_sealed()) return sealing;
    const SeamParts excessive = find_excessive_changes(mesh, *sealing);
    if (excessive.size() == 0) return sealing->is_settled ? std::move(sealing) : std::nullopt;
    if (!exclusion) exclusion.emplace(mesh, sealing->report.tolerance);
    exclusion->exclude(excessive, excluded);
  }
}

// Seals by the careful method (Turning::little), then the result by the other method (Turning::any) if that settles.
std::optional<Sealing> seal_carefully(const TriangleMesh& mesh, double share, WorkBudget budget) {
  SeamParts excluded;
  std::optional<Exclusion> exclusion;
  for (;;) {
    std::optional<Sealing> sealing = seal(mesh, {.share = share, .turning = Turning::little}, excluded, budget);
    if (!sealing || !sealing->report.has_sealed()) return sealing;
    SeamParts none;
    WorkBudget more_budget = make_budget(sealing->mesh, find_boundary_vertices(sealing->mesh));
    std::optional<Sealing> more = seal(sealing->mesh, {.share = share, .turning = Turning::any}, none, more_budget);
    if (!more || !more->report.has_sealed()) return sealing;
    add(std::move(*more), *sealing);
    const SeamParts excessive = find_excessive_changes(mesh, *sealing);
    if (excessive.size() == 0) return sealing;
    if (!exclusion) exclusion.emplace(mesh, sealing->report.tolerance);
    exclusion->exclude(excessive, excluded);
  }
}

// Seals by the method that joins most. If it does not settle, and not because of is_crowded, seals carefully. Nothing if neither settles.
std::optional<Sealing> seal_by_best_method(const TriangleMesh& mesh, double share, const std::vector<std::uint8_t>& at_boundary) {
  const WorkBudget budget = make_budget(mesh, at_boundary);
  WorkBudget used = budget;
  SeamParts excluded;
  std::optional<Sealing> sealing = seal(mesh, {.share = share, .turning = Turning::any}, excluded, used);
  return sealing || used.is_crowded ? std::move(sealing) : seal_carefully(mesh, share, budget);
}

void count_unsealed(const TriangleMesh& mesh, const std::vector<std::uint8_t>& at_boundary, SealReport& report) {
  if (report.boundary_edges_left == 0) return;
  const BoundaryEdges unsealed = count_boundary_edges(mesh, at_boundary, report.tolerance);
  report.unsealed_edges = unsealed.cracks;
  report.widest_unsealed = unsealed.widest_crack;
}

}  // namespace

TriangleMesh seal_cracks(TriangleMesh mesh, SealReport& report, double share, std::vector<std::uint32_t>* source) {
  report = {};
  if (source != nullptr) {
    source->resize(mesh.triangles.size());
    std::iota(source->begin(), source->end(), 0U);
  }
  std::vector<std::uint8_t> at_boundary = find_boundary_vertices(mesh);
  if (at_boundary.empty()) return mesh;
  std::optional<Sealing> sealing = seal_by_best_method(mesh, share, at_boundary);
  if (sealing) {
    report = sealing->report;
    report.tolerance = share * compute_bounds(mesh).extent();
  } else {
    const std::size_t edges = count_edges(mesh).boundary;
    report = {
        .tolerance = share * compute_bounds(mesh).extent(), .boundary_edges = edges, .boundary_edges_left = edges, .has_given_up = true};
  }
  if (report.has_sealed()) {
    mesh = std::move(sealing->mesh);
    at_boundary = find_boundary_vertices(mesh);
    if (source != nullptr) *source = std::move(sealing->mapping.source_triangles);
  }
  count_unsealed(mesh, at_boundary, report);
  return mesh;
}

std::string SealReport::describe() const {
  const std::string unsealed =
      unsealed_edges == 0 ? "" : fmt::format("; {} of them are at cracks up to {:.3g} m wide", unsealed_edges, widest_unsealed);
  if (has_given_up) {
    return fmt::format("cracks not sealed: its {} boundary edges lie too close together to identify gaps of {:.3g} m{}; repair the mesh",
                       boundary_edges, tolerance, unsealed);
  }
  const std::string why =
      unsealed.empty() ? "" : unsealed + ": closing them would move a vertex too far, flip a triangle or join what is not one surface";
  if (!has_sealed() && unsealed_edges == 0)
    return fmt::format("no cracks up to {:.3g} m wide; {} boundary edges", tolerance, boundary_edges);
  if (!has_sealed()) return fmt::format("no cracks sealed; {} boundary edges{}", boundary_edges, why);
  return fmt::format(
      "sealed cracks up to {:.3g} m wide: welded {} vertices, split {} triangles, joined {} pairs of boundary edges; {} of {} left{}",
      widest_gap, welded_vertices, split_triangles, zipped_edges, boundary_edges_left, boundary_edges, why);
}

}  // namespace hapton
