#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <tuple>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "core/geometry/seam_mesh.h"
#include "core/geometry/triangle_mesh.h"

namespace hapton {

// What joining is about: vertices that are welded or split an edge, and edges that are split (SeamMesh::Edge::chord).
struct JoinedParts {
  std::unordered_set<std::uint32_t> vertices;
  std::unordered_set<std::uint32_t> chords;
  std::size_t size() const { return vertices.size() + chords.size(); }
};

// Joins boundary edges that run side by side within a tolerance, until no more can be joined: their ends are welded, or one is split where
// the other ends. Vertices and edges that lie together without running side by side stay apart, and so do the sides of a narrow strip.
//
// First those are joined that make a surface of one winding, then those of opposite winding, then those that fold back by more than 120
// degrees; among these, vertices before T-junctions and the nearest before others. What is split is zipped at once, so boundary edges never
// become more. What may be done to a mesh at all: seam_mesh.h.
//
// Units and frame: the mesh's. RT: set-up only. Threads: one. Time: n log n in the boundary; of a vertex in a crowd the nearest 32 vertices
// and VertexTree::kMostSegments edges are looked at.
class SeamJoiner {
 public:
  // Pre: mesh and untouched outlive this; at_boundary from find_boundary_vertices.
  // untouched: is neither welded nor split. What turns out to lead too far joins it: vertices that would drag others farther than the
  // tolerance from where they came from; edges along which a gap would be zipped up, split by split, to where it is wider than that. Then
  // joining is to be done again on the mesh as it came.
  SeamJoiner(TriangleMesh& mesh, std::vector<std::uint8_t> at_boundary, double tolerance, JoinedParts& untouched);

  // Once. False: it took more than most_work, and was not finished; the mesh is not to be used then.
  bool run(std::size_t most_work);
  std::size_t work() const { return seam_.work() + candidates_; }  // what the time is proportional to

  SeamMesh& seam() { return seam_; }
  std::size_t boundary_edges() const { return boundary_edges_; }  // before
  double widest_gap() const { return widest_gap_; }               // that was joined
  JoinedParts joined() const;

 private:
  using Edge = SeamMesh::Edge;
  // In this order.
  enum Kind : std::uint8_t { straight, flipped, folded, kind_count };
  struct Pair {
    double squared_distance = 0.0;
    std::uint32_t u = 0;
    std::uint32_t v = 0;
    auto order() const { return std::tie(squared_distance, u, v); }
    bool operator<(const Pair& other) const { return order() < other.order(); }
    bool operator==(const Pair& other) const { return u == other.u && v == other.v; }
  };
  // A vertex near an edge of another triangle.
  struct Junction {
    double squared_distance = 0.0;
    std::uint32_t edge = 0;  // of edges_
    std::uint32_t vertex = 0;
    double share = 0.0;  // along the edge
    auto order() const { return std::tie(squared_distance, edge, vertex); }
    bool operator<(const Junction& other) const { return order() < other.order(); }
    bool operator==(const Junction& other) const { return edge == other.edge && vertex == other.vertex; }
  };
  struct Foot {
    double share = 0.0;  // along the segment, not cut to it
    double squared_distance = 0.0;
    bool is_inside() const { return share > 0.0 && share < 1.0; }
  };

  const Vec3& at(std::uint32_t vertex) const { return seam_.position(vertex); }
  bool is_near(double squared_distance) const { return squared_distance <= tolerance_ * tolerance_; }
  static Foot foot_on(const Vec3& a, const Vec3& b, const Vec3& p);
  Foot foot(const Edge& edge, std::uint32_t vertex) const { return foot_on(at(edge.from), at(edge.to), at(vertex)); }
  bool is_close_by(const Edge& edge, std::uint32_t vertex) const;
  static std::uint64_t key_of(std::uint32_t a, std::uint32_t b);
  Kind kind_of(const Edge& one, std::uint32_t a, const Edge& other, std::uint32_t b) const;

  bool is_spent() const { return most_work_ == 0 || work() > most_work_; }
  void find_pairs();
  bool is_seam_at(std::uint32_t u, std::uint32_t v);
  bool is_seam_from_far_end(std::uint32_t u, std::uint32_t v);
  bool is_across_strip(std::uint32_t u, std::uint32_t v, const Edge& e, const Edge& f) const;
  void weld_round();
  bool weld(std::uint32_t u, std::uint32_t v);

  void find_junctions();
  void split_round();
  std::optional<Edge> find_boundary_edge(std::uint32_t a, std::uint32_t b) const;
  std::optional<Edge> find_piece(std::uint32_t edge, double share) const;
  bool cut(const Edge& piece, std::uint32_t vertex);
  void uncut(const Edge& piece, std::uint32_t vertex);
  bool zip_at(const Edge& piece, std::uint32_t vertex);
  bool zip_to_end(const Edge& piece, std::uint32_t vertex, const Edge& f, std::uint32_t end);
  bool zip_with_second(const Edge& piece, std::uint32_t vertex, const Edge& f, std::uint32_t far);
  bool is_kind(const Edge& piece, const Edge& f, std::uint32_t vertex, bool runs_on) const;
  bool is_over_strip(const Edge& piece, std::uint32_t vertex, const Edge& f) const;

  SeamMesh seam_;
  double tolerance_;
  const TriangleMesh& mesh_;
  JoinedParts& untouched_;
  std::size_t most_work_ = 0;
  std::size_t candidates_ = 0;  // pairs and junctions that were looked at
  // What was done and not taken back.
  struct Cut {
    std::uint32_t chord = 0;
    std::uint32_t vertex = 0;
  };
  std::vector<std::uint32_t> welded_;
  std::vector<Cut> cut_;
  Kind kind_ = straight;
  std::size_t changes_ = 0;
  double widest_gap_ = 0.0;
  std::size_t boundary_edges_ = 0;
  std::vector<Edge> edges_u_, edges_v_;
  std::vector<Pair> pairs_;
  std::vector<Junction> junctions_;
  std::size_t pairs_found_at_ = ~std::size_t{0};  // changes_ then
  std::size_t junctions_found_at_ = ~std::size_t{0};
  // Of a round of splits: the boundary edges at its start, where they have been cut since, and which one a piece is of.
  std::vector<Edge> edges_;
  std::unordered_map<std::uint32_t, std::map<double, std::uint32_t>> cuts_;
  std::unordered_map<std::uint64_t, std::uint32_t> edge_number_;
};

}  // namespace hapton
