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

// Parts of a mesh: vertices that are welded or split an edge, and edges that are split (SeamMesh::Edge::chord).
struct SeamParts {
  std::unordered_set<std::uint32_t> vertices;
  std::unordered_set<std::uint32_t> chords;
  std::size_t size() const { return vertices.size() + chords.size(); }
};

// Joins boundary edges that run side by side within a tolerance, until no more can be joined: their ends are welded, or one is split where
// the other ends. Vertices and edges that are close without running side by side stay apart, and so do the sides of a narrow strip.
//
// An edge is not joined to a surface of opposite orientation, or to one that folds back, where its own surface seems to continue beyond a
// gap of up to 4 tolerances: else the two sides of a thin sheet whose cracks are wider than its thickness would be joined.
//
// The order is: seams that make a consistently oriented surface, seams of opposite orientation, seams that fold back by more than 120
// degrees; within each kind, vertices before T-junctions, and the nearest first. An edge is split only if a part of it is joined to another
// edge at once, so the number of boundary edges never grows. seam_mesh.h lists the changes that are allowed.
//
// Units and frame: the mesh's. RT: set-up only. Threads: one. Time: n log n in the boundary; for a vertex in a dense cluster the nearest 32
// vertices and VertexTree::kMaxSegments edges are examined.
class SeamJoiner {
 public:
  // Pre: mesh and excluded outlive this; at_boundary is from find_boundary_vertices. excluded: parts that are neither welded nor split.
  // Parts whose joining would exceed the tolerance are added to `excluded`: vertices that would move others farther than the tolerance
  // from their origin, and edges along which a gap would be closed, split by split, to where it is wider than the tolerance. Joining must
  // then be repeated on the original mesh.
  SeamJoiner(TriangleMesh& mesh, std::vector<std::uint8_t> at_boundary, double tolerance, SeamParts& excluded,
             Turning turning = Turning::any);

  // Joins. Call it once. False: it took more than most_work and is not finished; do not use the mesh then.
  bool run(std::size_t most_work);
  std::size_t work() const { return seam_.work() + candidates_; }  // proportional to the time

  SeamMesh& seam() { return seam_; }
  std::size_t boundary_edges() const { return boundary_edges_; }  // number of boundary edges before joining
  double widest_gap() const { return widest_gap_; }               // widest gap that was joined
  SeamParts joined() const;

 private:
  using Edge = SeamMesh::Edge;
  // The kinds of seams, in order of preference.
  enum Kind : std::uint8_t { straight, flipped, sharp, kind_count };
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
    std::uint32_t edge = 0;  // index into edges_
    std::uint32_t vertex = 0;
    double share = 0.0;  // along the edge
    auto order() const { return std::tie(squared_distance, edge, vertex); }
    bool operator<(const Junction& other) const { return order() < other.order(); }
    bool operator==(const Junction& other) const { return edge == other.edge && vertex == other.vertex; }
  };
  struct Closest {
    double share = 0.0;  // along the segment, not clamped to it
    double squared_distance = 0.0;
    bool is_inside() const { return share > 0.0 && share < 1.0; }
  };

  const Vec3& at(std::uint32_t vertex) const { return seam_.position(vertex); }
  bool is_near(double squared_distance) const { return squared_distance <= tolerance_ * tolerance_; }
  static Closest closest_on(const Vec3& a, const Vec3& b, const Vec3& p);
  Closest closest(const Edge& edge, std::uint32_t vertex) const { return closest_on(at(edge.from), at(edge.to), at(vertex)); }
  bool is_close_by(const Edge& edge, std::uint32_t vertex) const;
  static std::uint64_t key_of(std::uint32_t a, std::uint32_t b);
  Kind kind_of(const Edge& one, std::uint32_t a, const Edge& other, std::uint32_t b) const;

  void find_reserved_edges();
  bool is_reserved(const Edge& edge) const { return kind_ != straight && reserved_chords_.contains(edge.chord); }

  bool is_spent() const { return most_work_ == 0 || work() > most_work_; }
  void find_pairs();
  bool is_seam_at(std::uint32_t u, std::uint32_t v);
  bool is_seam_from_far_end(std::uint32_t u, std::uint32_t v);
  bool is_across_strip(std::uint32_t u, std::uint32_t v, const Edge& e, const Edge& f) const;
  void weld_round();
  bool weld(std::uint32_t u, std::uint32_t v);
  bool weld_between(std::uint32_t u, std::uint32_t v);
  bool weld_at_member(std::uint32_t u, const std::vector<std::uint32_t>& members_of_u, std::uint32_t v,
                      const std::vector<std::uint32_t>& members_of_v);
  bool move_apart(std::uint32_t u, const std::vector<std::uint32_t>& members_of_u, std::uint32_t v,
                  const std::vector<std::uint32_t>& members_of_v);

  void find_junctions();
  void split_round();
  std::optional<Edge> find_boundary_edge(std::uint32_t a, std::uint32_t b) const;
  std::optional<Edge> find_piece(std::uint32_t edge, double share) const;
  bool cut(const Edge& piece, std::uint32_t vertex);
  void uncut(const Edge& piece, std::uint32_t vertex);
  bool zip_at(const Edge& piece, std::uint32_t vertex);
  bool zip_to_end(const Edge& piece, std::uint32_t vertex, const Edge& f, std::uint32_t end);
  bool zip_with_second(const Edge& piece, std::uint32_t vertex, const Edge& f, std::uint32_t far_end);
  bool is_kind_joined_now(const Edge& piece, const Edge& f, std::uint32_t vertex, bool runs_on) const;
  bool is_over_strip(const Edge& piece, std::uint32_t vertex, const Edge& f) const;

  SeamMesh seam_;
  double tolerance_;
  Turning turning_;
  const TriangleMesh& mesh_;
  SeamParts& excluded_;
  std::size_t most_work_ = 0;
  std::size_t candidates_ = 0;  // pairs and junctions examined
  // The changes that were made and not undone.
  struct Cut {
    std::uint32_t chord = 0;
    std::uint32_t vertex = 0;
  };
  std::vector<std::uint32_t> welded_vertices_;
  std::vector<Cut> made_cuts_;
  std::unordered_set<std::uint64_t> separated_pairs_;  // pairs of positions to which vertices were moved apart
  Kind kind_ = straight;
  std::unordered_set<std::uint32_t> reserved_chords_;  // chords of edges beyond which a surface seems to continue, past too wide a gap
  std::size_t changes_ = 0;
  double widest_gap_ = 0.0;
  std::size_t boundary_edges_ = 0;
  std::vector<Edge> edges_u_, edges_v_;
  std::vector<Pair> pairs_;
  std::vector<Junction> junctions_;
  std::size_t pairs_found_at_ = ~std::size_t{0};  // changes_ when pairs_ was found
  std::size_t junctions_found_at_ = ~std::size_t{0};
  // For one round of splits: the boundary edges at its start, where each was cut since, and the edge to which each piece belongs.
  std::vector<Edge> edges_;
  std::unordered_map<std::uint32_t, std::map<double, std::uint32_t>> cuts_of_edge_;
  std::unordered_map<std::uint64_t, std::uint32_t> edge_number_;
};

}  // namespace hapton
