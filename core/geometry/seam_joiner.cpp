#include "core/geometry/seam_joiner.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/geometry/vertex_tree.h"

namespace hapton {
namespace {

constexpr std::size_t kMaxNearVertices = 32;  // nearest vertices within the tolerance that are examined for each vertex
constexpr std::size_t kMaxEdgesAtVertex = 8;  // at a vertex with more boundary edges, their far ends are not compared in pairs
constexpr std::size_t kMaxValence = 256;      // largest valence for which a weld is tried from both ends
constexpr int kMaxRounds = 64;                // of welding or splitting, for each kind of seam; the work given to run() bounds the time
constexpr double kReservedGap = 4.0;          // in tolerances: a surface seems to continue beyond a gap of up to this width
constexpr std::size_t kMaxMembers = 32;       // of vertices welded together, up to which each position is tried as the common one
// Averages: a surface that is torn apart at every edge has 3 and 2. Above these limits most of the boundary lies within one tolerance.
constexpr std::size_t kMaxPairs = 8;       // pairs per boundary edge of the original mesh
constexpr std::size_t kMaxJunctions = 64;  // junctions per boundary edge of the original mesh
constexpr double kMinFoldedCosine = 0.5;   // cosine of the angle between the two faces at a common edge: below 60 degrees they fold back

}  // namespace

SeamJoiner::SeamJoiner(TriangleMesh& mesh, std::vector<std::uint8_t> at_boundary, double tolerance, SeamParts& excluded, Turning turning)
    : seam_(mesh, std::move(at_boundary), tolerance, turning), tolerance_(tolerance), turning_(turning), mesh_(mesh), excluded_(excluded) {}

SeamJoiner::Closest SeamJoiner::closest_on(const Vec3& a, const Vec3& b, const Vec3& p) {
  const Vec3 along = b - a;
  const double length = along.squaredNorm();
  const double share = length > 0.0 ? along.dot(p - a) / length : 0.0;
  return {share, (p - a - std::clamp(share, 0.0, 1.0) * along).squaredNorm()};
}

// The vertex is within the tolerance of the edge, and its projection onto the edge's line lies inside the edge.
bool SeamJoiner::is_close_by(const Edge& edge, std::uint32_t vertex) const {
  const Closest here = closest(edge, vertex);
  return vertex != edge.apex && here.is_inside() && is_near(here.squared_distance);
}

std::uint64_t SeamJoiner::key_of(std::uint32_t a, std::uint32_t b) { return std::uint64_t{std::min(a, b)} << 32 | std::max(a, b); }

std::optional<SeamJoiner::Edge> SeamJoiner::find_boundary_edge(std::uint32_t a, std::uint32_t b) const {
  if (!seam_.is_boundary(a, b)) return std::nullopt;
  return seam_.boundary_edge(a, b);
}

bool SeamJoiner::run(std::size_t most_work) {
  most_work_ = most_work;
  boundary_edges_ = seam_.boundary_edges().size();
  for (int kind = straight; kind < kind_count; ++kind) {
    kind_ = static_cast<Kind>(kind);
    if (kind_ != straight) find_reserved_edges();
    for (int round = 0; round < kMaxRounds; ++round) {
      const std::size_t before = changes_;
      weld_round();
      if (is_spent()) return false;
      if (changes_ != before) continue;
      split_round();
      if (is_spent()) return false;
      if (changes_ == before) break;
    }
    if (pairs_.empty() && junctions_.empty()) break;
  }
  return true;
}

SeamParts SeamJoiner::joined() const {
  SeamParts parts;
  parts.vertices.insert(welded_vertices_.begin(), welded_vertices_.end());
  for (const Cut& cut : made_cuts_) {
    parts.vertices.insert(cut.vertex);
    parts.chords.insert(cut.chord);
  }
  return parts;
}

// The kind of seam that two boundary edges would form, which run side by side from their neighbouring vertices `a` of one and `b` of the
// other. `a` and `b` may be the same.
SeamJoiner::Kind SeamJoiner::kind_of(const Edge& one, std::uint32_t a, const Edge& other, std::uint32_t b) const {
  if (seam_.inward(one).dot(seam_.inward(other)) > kMinFoldedCosine) return sharp;
  return (one.from == a) == (other.from == b) ? flipped : straight;
}

void SeamJoiner::find_reserved_edges() {
  const double radius = kReservedGap * tolerance_;
  reserved_chords_.clear();
  VertexTree tree(mesh_.vertices, seam_.boundary_vertices());
  std::vector<VertexTree::NearVertex> found;
  for (const Edge& edge : seam_.boundary_edges()) {
    tree.find_near_segment(at(edge.from), at(edge.to), radius, found);
    for (const VertexTree::NearVertex& near : found) {
      if (near.vertex == edge.from || near.vertex == edge.to || seam_.valence(near.vertex) > kMaxValence) continue;
      seam_.find_boundary_edges_at(near.vertex, edges_v_);
      for (const Edge& other : edges_v_) {
        if (other.triangle == edge.triangle || seam_.inward(edge).dot(seam_.inward(other)) > kMinFoldedCosine) continue;
        if ((at(edge.to) - at(edge.from)).dot(at(other.to) - at(other.from)) >= 0.0) continue;
        const std::uint32_t far_end = other.other(near.vertex);
        const double at_far = std::min({closest(edge, far_end).squared_distance, closest(other, edge.from).squared_distance,
                                        closest(other, edge.to).squared_distance});
        const double squared_gap = std::max(near.squared_distance, at_far);
        if (squared_gap <= radius * radius && !is_near(squared_gap)) reserved_chords_.insert({edge.chord, other.chord});
      }
    }
  }
}

void SeamJoiner::find_pairs() {
  if (pairs_found_at_ == changes_) return;
  pairs_found_at_ = changes_;
  pairs_.clear();
  const auto add = [&](std::uint32_t u, std::uint32_t v) {
    if (u == v || seam_.is_edge(u, v)) return;
    const double squared = (at(u) - at(v)).squaredNorm();
    if (is_near(squared)) pairs_.push_back({squared, std::min(u, v), std::max(u, v)});
  };
  const std::vector<std::uint32_t> vertices = seam_.boundary_vertices();
  const VertexTree tree(mesh_.vertices, vertices);
  std::vector<VertexTree::NearVertex> found;
  std::vector<Edge> edges;
  std::vector<std::uint8_t> is_full(mesh_.vertices.size(), 0);
  for (const std::uint32_t u : vertices) {
    tree.find_nearest(at(u), u, tolerance_, kMaxNearVertices, found);
    if (found.size() == kMaxNearVertices) is_full[u] = 1;
    for (const VertexTree::NearVertex& near : found) {
      // A vertex with a lower number that has examined all its neighbours has added the pair already.
      if (near.vertex > u || is_full[near.vertex] != 0) add(u, near.vertex);
    }
    // Edges from one vertex may run in the same direction: their far ends are compared, however many edges there are at these ends.
    if (seam_.boundary_count(u) > kMaxEdgesAtVertex) continue;
    seam_.find_boundary_edges_at(u, edges);
    for (std::size_t i = 0; i < edges.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) add(edges[i].other(u), edges[j].other(u));
    }
  }
  if (pairs_.size() > kMaxPairs * (boundary_edges_ + 16)) {
    most_work_ = 0;
    return;
  }
  std::sort(pairs_.begin(), pairs_.end());
  pairs_.erase(std::unique(pairs_.begin(), pairs_.end()), pairs_.end());
}

// Edges at u and at v run side by side, so joining these vertices helps to close the gap between the edges; and there is a gap: they are
// not the two sides of one narrow strip.
bool SeamJoiner::is_seam_at(std::uint32_t u, std::uint32_t v) {
  if (seam_.valence(u) > kMaxValence || seam_.valence(v) > kMaxValence) return is_seam_from_far_end(u, v);
  seam_.find_boundary_edges_at(u, edges_u_);
  seam_.find_boundary_edges_at(v, edges_v_);
  for (const Edge& e : edges_u_) {
    if (is_reserved(e)) continue;
    for (const Edge& f : edges_v_) {
      if (is_reserved(f)) continue;
      const std::uint32_t far_e = e.other(u);
      const std::uint32_t far_f = f.other(v);
      if (far_e != far_f && !is_near(closest(f, far_e).squared_distance) && !is_near(closest(e, far_f).squared_distance)) continue;
      if (kind_of(e, u, f, v) <= kind_ && !is_across_strip(u, v, e, f)) return true;
    }
  }
  return false;
}

// The same, only for edges that share their far end. Searches at the vertex of lower valence, which determines the cost.
bool SeamJoiner::is_seam_from_far_end(std::uint32_t u, std::uint32_t v) {
  if (seam_.valence(u) > seam_.valence(v)) std::swap(u, v);
  seam_.find_boundary_edges_at(u, edges_u_);
  return std::any_of(edges_u_.begin(), edges_u_.end(), [&](const Edge& e) {
    const std::uint32_t far_end = e.other(u);
    if (!seam_.is_boundary(far_end, v)) return false;
    const Edge f = seam_.boundary_edge(far_end, v);
    return !is_reserved(e) && !is_reserved(f) && kind_of(e, u, f, v) <= kind_ && !is_across_strip(u, v, e, f);
  });
}

bool SeamJoiner::is_across_strip(std::uint32_t u, std::uint32_t v, const Edge& e, const Edge& f) const {
  const Vec3 to_v = at(v) - at(u);
  if (!(seam_.inward(e).dot(to_v) > 0.0 && seam_.inward(f).dot(to_v) < 0.0)) return false;
  return seam_.is_joined_nearby(u, v, at(u) + 0.5 * to_v, to_v.norm());
}

void SeamJoiner::weld_round() {
  find_pairs();
  if (is_spent()) return;
  candidates_ += pairs_.size();
  for (const Pair& pair : pairs_) {
    if (is_spent()) return;
    std::uint32_t u = seam_.representative_of(pair.u);
    std::uint32_t v = seam_.representative_of(pair.v);
    if (u == v || seam_.boundary_count(u) == 0 || seam_.boundary_count(v) == 0) continue;
    if (excluded_.vertices.contains(u) || excluded_.vertices.contains(v)) continue;
    const double squared = (at(u) - at(v)).squaredNorm();
    if (seam_.is_edge(u, v) || !is_seam_at(u, v) || !(is_near(squared) ? weld(u, v) : weld_between(u, v))) continue;
    widest_gap_ = std::max(widest_gap_, is_near(squared) ? std::sqrt(squared) : (at(pair.u) - at(pair.v)).norm());
    welded_vertices_.insert(welded_vertices_.end(), {u, v});
    ++changes_;
  }
}

// The vertex with fewer triangles moves, so that joining a vertex that is split into n copies takes n log n steps.
bool SeamJoiner::weld(std::uint32_t u, std::uint32_t v) {
  if (seam_.valence(u) > seam_.valence(v) || (seam_.valence(u) == seam_.valence(v) && u < v)) std::swap(u, v);
  const SeamMesh::Weld first = seam_.weld(u, v);
  if (first == SeamMesh::Weld::done) return true;
  const SeamMesh::Weld second = seam_.valence(v) > kMaxValence ? SeamMesh::Weld::rejected : seam_.weld(v, u);
  if (second == SeamMesh::Weld::done) return true;
  if (first != SeamMesh::Weld::too_far && second != SeamMesh::Weld::too_far) return false;
  std::vector<std::uint32_t> members_of_u, members_of_v;
  seam_.for_each_member(u, [&](std::uint32_t member) { members_of_u.push_back(member); });
  seam_.for_each_member(v, [&](std::uint32_t member) { members_of_v.push_back(member); });
  if (members_of_u.size() + members_of_v.size() <= kMaxMembers) {
    candidates_ += members_of_u.size() * members_of_v.size();
    if (weld_at_member(u, members_of_u, v, members_of_v) || weld_at_member(v, members_of_v, u, members_of_u)) return true;
    if (move_apart(u, members_of_u, v, members_of_v)) return false;
  }
  excluded_.vertices.insert(members_of_u.begin(), members_of_u.end());
  excluded_.vertices.insert(members_of_v.begin(), members_of_v.end());
  return false;
}

// Welds u and v if vertices welded to them are near each other, although u and v themselves no longer are.
bool SeamJoiner::weld_between(std::uint32_t u, std::uint32_t v) {
  if (turning_ == Turning::little) return false;
  std::vector<std::uint32_t> members_of_u, members_of_v;
  seam_.for_each_member(u, [&](std::uint32_t member) { members_of_u.push_back(member); });
  seam_.for_each_member(v, [&](std::uint32_t member) { members_of_v.push_back(member); });
  if (members_of_u.size() + members_of_v.size() > kMaxMembers) return false;
  candidates_ += members_of_u.size() * members_of_v.size();
  return weld_at_member(u, members_of_u, v, members_of_v) || weld_at_member(v, members_of_v, u, members_of_u);
}

// Welds u and v at the position of another vertex welded to u that is within the tolerance of all vertices welded to u or v.
bool SeamJoiner::weld_at_member(std::uint32_t u, const std::vector<std::uint32_t>& members_of_u, std::uint32_t v,
                                const std::vector<std::uint32_t>& members_of_v) {
  const auto is_near_all = [&](std::uint32_t member, const std::vector<std::uint32_t>& all) {
    return std::all_of(all.begin(), all.end(), [&](std::uint32_t other) { return is_near((at(other) - at(member)).squaredNorm()); });
  };
  for (const std::uint32_t member : members_of_u) {
    if (member == u || !is_near_all(member, members_of_u) || !is_near_all(member, members_of_v) || !seam_.move_to_member(u, member))
      continue;
    if (seam_.weld(v, member) == SeamMesh::Weld::done) return true;
    seam_.move_to_member(member, u);
  }
  return false;
}

// Two vertices near each other that cannot be welded, because vertices welded to them before would move too far: they get positions farther
// apart than the tolerance, so that the gap between them is seen to be too wide.
bool SeamJoiner::move_apart(std::uint32_t u, const std::vector<std::uint32_t>& members_of_u, std::uint32_t v,
                            const std::vector<std::uint32_t>& members_of_v) {
  for (const std::uint32_t to_u : members_of_u) {
    for (const std::uint32_t to_v : members_of_v) {
      if (is_near((at(to_u) - at(to_v)).squaredNorm()) || separated_pairs_.contains(key_of(to_u, to_v)) || !seam_.move_to_member(u, to_u))
        continue;
      if (seam_.move_to_member(v, to_v)) {
        separated_pairs_.insert(key_of(to_u, to_v));
        ++changes_;
        return true;
      }
      seam_.move_to_member(to_u, u);
    }
  }
  return false;
}

void SeamJoiner::find_junctions() {
  cuts_of_edge_.clear();
  if (junctions_found_at_ != changes_) edges_ = seam_.boundary_edges();
  edge_number_.clear();
  for (std::uint32_t i = 0; i < edges_.size(); ++i) edge_number_[key_of(edges_[i].from, edges_[i].to)] = i;
  if (junctions_found_at_ == changes_) return;
  junctions_found_at_ = changes_;
  junctions_.clear();
  const auto add = [&](std::uint32_t i, std::uint32_t vertex) {
    const Closest here = closest(edges_[i], vertex);
    if (is_close_by(edges_[i], vertex)) junctions_.push_back({here.squared_distance, i, vertex, here.share});
  };
  const std::vector<std::uint32_t> vertices = seam_.boundary_vertices();
  VertexTree tree(mesh_.vertices, vertices);
  std::vector<VertexTree::NearVertex> found;
  for (std::uint32_t i = 0; i < edges_.size(); ++i) {
    tree.find_near_segment(at(edges_[i].from), at(edges_[i].to), tolerance_, found);
    for (const VertexTree::NearVertex& near : found) add(i, near.vertex);
    if (junctions_.size() <= kMaxJunctions * (boundary_edges_ + 16)) continue;
    most_work_ = 0;
    return;
  }
  for (const std::uint32_t u : vertices) {
    if (seam_.boundary_count(u) > kMaxEdgesAtVertex) continue;
    seam_.find_boundary_edges_at(u, edges_u_);
    for (const Edge& e : edges_u_) {
      for (const Edge& f : edges_u_) {
        if (e.triangle != f.triangle) add(edge_number_[key_of(e.from, e.to)], f.other(u));
      }
    }
  }
  std::sort(junctions_.begin(), junctions_.end());
  junctions_.erase(std::unique(junctions_.begin(), junctions_.end()), junctions_.end());
}

void SeamJoiner::split_round() {
  find_junctions();
  if (is_spent()) return;
  candidates_ += junctions_.size();
  for (const Junction& junction : junctions_) {
    if (is_spent()) return;
    if (seam_.boundary_count(junction.vertex) == 0) continue;
    const std::optional<Edge> piece = find_piece(junction.edge, junction.share);
    if (piece && is_close_by(*piece, junction.vertex) && zip_at(*piece, junction.vertex)) ++changes_;
  }
}

// The piece of an edge of this round, at a share of the edge's length; nothing if the piece is no longer boundary.
std::optional<SeamJoiner::Edge> SeamJoiner::find_piece(std::uint32_t edge, double share) const {
  std::uint32_t a = edges_[edge].from;
  std::uint32_t b = edges_[edge].to;
  if (const auto found = cuts_of_edge_.find(edge); found != cuts_of_edge_.end()) {
    const std::map<double, std::uint32_t>& cuts = found->second;
    const auto after = cuts.upper_bound(share);
    if (after != cuts.end()) b = after->second;
    if (after != cuts.begin()) a = std::prev(after)->second;
  }
  return find_boundary_edge(a, b);
}

bool SeamJoiner::cut(const Edge& piece, std::uint32_t vertex) {
  const auto found = edge_number_.find(key_of(piece.from, piece.to));
  if (found == edge_number_.end() || excluded_.chords.contains(piece.chord) || excluded_.vertices.contains(vertex)) return false;
  const std::uint32_t edge = found->second;
  const Closest here = closest(edges_[edge], vertex);
  if (!here.is_inside() || !is_near(here.squared_distance)) return false;
  const std::optional<Edge> there = find_piece(edge, here.share);
  if (!there || there->from != piece.from || there->to != piece.to) return false;
  if (!seam_.split(piece.from, piece.to, vertex)) return false;
  const auto [start, end] = seam_.chord_of(piece);
  if (!is_near(closest_on(start, end, at(vertex)).squared_distance)) {
    seam_.unsplit(piece.from, piece.to, vertex);
    excluded_.chords.insert(piece.chord);
    return false;
  }
  made_cuts_.push_back({piece.chord, vertex});
  cuts_of_edge_[edge][here.share] = vertex;
  edge_number_[key_of(piece.from, vertex)] = edge;
  edge_number_[key_of(vertex, piece.to)] = edge;
  return true;
}

// Undoes the latest cut.
void SeamJoiner::uncut(const Edge& piece, std::uint32_t vertex) {
  const std::uint32_t edge = edge_number_[key_of(piece.from, piece.to)];
  seam_.unsplit(piece.from, piece.to, vertex);
  made_cuts_.pop_back();
  cuts_of_edge_[edge].erase(closest(edges_[edge], vertex).share);
}

// Splits a piece of boundary at a vertex if that lets a part of it join an edge that ends at the vertex, at once or by a second split.
bool SeamJoiner::zip_at(const Edge& piece, std::uint32_t vertex) {
  if (is_reserved(piece)) return false;
  std::vector<Edge> alongside;
  if (seam_.valence(vertex) <= kMaxValence) {
    seam_.find_boundary_edges_at(vertex, alongside);
  } else {
    for (const std::uint32_t end : {piece.from, piece.to}) {
      if (const std::optional<Edge> edge = find_boundary_edge(end, vertex)) alongside.push_back(*edge);
    }
  }
  const double gap = std::sqrt(closest(piece, vertex).squared_distance);
  for (const bool is_second_needed : {false, true}) {
    for (const Edge& f : alongside) {
      const std::uint32_t far_end = f.other(vertex);
      if ((far_end == piece.from || far_end == piece.to) == is_second_needed || is_reserved(f)) continue;
      if (!(is_second_needed ? zip_with_second(piece, vertex, f, far_end) : zip_to_end(piece, vertex, f, far_end))) continue;
      widest_gap_ = std::max(widest_gap_, gap);
      return true;
    }
  }
  return false;
}

// As zip_at, where the edge f leads from the vertex to `end` of the piece.
bool SeamJoiner::zip_to_end(const Edge& piece, std::uint32_t vertex, const Edge& f, std::uint32_t end) {
  return kind_of(piece, end, f, end) <= kind_ && !is_over_strip(piece, vertex, f) && cut(piece, vertex);
}

// As zip_at, where the edge f leads to another vertex near the piece, or past one of the piece's ends, which is then near f.
bool SeamJoiner::zip_with_second(const Edge& piece, std::uint32_t vertex, const Edge& f, std::uint32_t far_end) {
  if (f.triangle == piece.triangle) return false;
  if (is_close_by(piece, far_end)) {
    const bool runs_on =
        closest(piece, far_end).share > closest(piece, vertex).share;  // f leads from the vertex in the direction of the piece
    if (!is_kind_joined_now(piece, f, vertex, runs_on) || is_over_strip(piece, vertex, f) || !cut(piece, vertex)) return false;
    const std::optional<Edge> remaining_piece = find_boundary_edge(vertex, runs_on ? piece.to : piece.from);
    if (remaining_piece && cut(*remaining_piece, far_end)) return true;
    uncut(piece, vertex);
    return false;
  }
  for (const std::uint32_t end : {piece.from, piece.to}) {
    if (!is_close_by(f, end) || !is_kind_joined_now(piece, f, vertex, end == piece.to)) continue;
    if (is_over_strip(piece, vertex, f) || !cut(piece, vertex)) continue;
    if (cut(f, end)) return true;
    uncut(piece, vertex);
  }
  return false;
}

// Whether seams of this kind are joined now. runs_on: f leads from the vertex in the direction of the piece, otherwise in the opposite one.
bool SeamJoiner::is_kind_joined_now(const Edge& piece, const Edge& f, std::uint32_t vertex, bool runs_on) const {
  if (seam_.inward(piece).dot(seam_.inward(f)) > kMinFoldedCosine) return kind_ >= sharp;
  const bool is_same_direction = (f.from == vertex) == runs_on;
  return (is_same_direction ? flipped : straight) <= kind_;
}

bool SeamJoiner::is_over_strip(const Edge& piece, std::uint32_t vertex, const Edge& f) const {
  const Closest here = closest(piece, vertex);
  const Vec3 on_piece = at(piece.from) + here.share * (at(piece.to) - at(piece.from));
  const Vec3 off = at(vertex) - on_piece;
  if (!(seam_.inward(piece).dot(off) > 0.0 && seam_.inward(f).dot(off) < 0.0)) return false;
  return seam_.is_triangle_joined_nearby(piece.triangle, vertex, on_piece + 0.5 * off, off.norm());
}

}  // namespace hapton
