#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// The vertices at which an edge of one triangle ends, by vertex; empty when the mesh has no such edge. Triangles that repeat a vertex have
// no edges. Linear in the mesh. RT: set-up only.
std::vector<std::uint8_t> find_boundary_vertices(const TriangleMesh& mesh);

// A mesh whose boundary is being joined: vertices on it are welded and edges on it split. Only triangles at the boundary are kept track of.
//
// Each change is refused that would break the surface:
// - no triangle loses its area (height below kLeastHeight tolerances where it had more) or ends up with a normal that points away from the
//   one it came with;
// - no edge gets more than two triangles, no two triangles get the same three vertices, no edge shrinks to nothing;
// - no vertex is farther than the tolerance from where it came from.
// A vertex is moved onto another one, so every position is one that the mesh came with.
//
// Units and frame: the mesh's. RT: set-up only. Threads: one.
class SeamMesh {
 public:
  static constexpr std::uint32_t kNone = 0xFFFFFFFFU;
  static constexpr double kLeastHeight = 1e-6;  // of a triangle, in tolerances: far above what contact can tell from a line

  // A boundary edge as its triangle runs along it.
  struct Edge {
    std::uint32_t from = 0;
    std::uint32_t to = 0;
    std::uint32_t triangle = 0;
    std::uint32_t apex = 0;   // its third vertex
    std::uint32_t chord = 0;  // which edge it was when it came, or is a part of since: 3 times its triangle plus its number there
    std::uint32_t other(std::uint32_t end) const { return end == from ? to : from; }
  };

  // Pre: the mesh outlives this and is changed by nothing else; at_boundary from find_boundary_vertices.
  SeamMesh(TriangleMesh& mesh, std::vector<std::uint8_t> at_boundary, double tolerance);

  double tolerance() const { return tolerance_; }
  const Vec3& position(std::uint32_t vertex) const { return mesh_.vertices[vertex]; }
  std::uint32_t standing_for(std::uint32_t vertex) const;  // what it was welded to in the end; itself when to none
  bool is_boundary(std::uint32_t a, std::uint32_t b) const;
  bool is_edge(std::uint32_t a, std::uint32_t b) const { return find(a, b).count > 0; }
  std::uint32_t boundary_count(std::uint32_t vertex) const { return boundary_count_[vertex]; }  // of edges that end there
  std::size_t valence(std::uint32_t vertex) const { return fan_of(vertex).size(); }             // Pre: at the boundary when it came

  Edge boundary_edge(std::uint32_t a, std::uint32_t b) const;  // Pre: is one
  std::vector<Edge> boundary_edges() const;                    // in the order of their triangles
  // Those that end at a vertex. Linear in its valence.
  void find_boundary_edges_at(std::uint32_t vertex, std::vector<Edge>& edges) const;
  std::vector<std::uint32_t> boundary_vertices() const;
  // What the edge, or the one it was split from, would be without splits: straight between where its ends are now.
  std::pair<Vec3, Vec3> chord_of(const Edge& edge) const;
  // Unit, in the triangle's plane, off the edge; zero when the triangle has no area.
  Vec3 inward(const Edge& edge) const;

  // The surface goes on from the triangles at one vertex, or from one triangle, to one at the other vertex, over edges that come within
  // `radius` of `near`: the two lie side by side on one piece of surface, no gap is between them. True also when that takes too long to
  // find out. Linear in the lower valence.
  bool is_joined_nearby(std::uint32_t u, std::uint32_t v, const Vec3& near, double radius) const;
  bool is_triangle_joined_nearby(std::uint32_t triangle, std::uint32_t to, const Vec3& near, double radius) const;

  enum class Weld {
    done,
    refused,
    too_far  // refused for one reason alone: a vertex welded to u before would end up farther than the tolerance from where it came from
  };
  // Moves vertex u onto v, or refuses and changes nothing. Linear in u's valence. Pre: both are at the boundary.
  Weld weld(std::uint32_t u, std::uint32_t v);
  // All vertices that this one stands for, itself among them.
  template <class Visit>
  void for_each_member(std::uint32_t vertex, Visit&& visit) const {
    std::uint32_t member = vertex;
    do {
      visit(member);
      member = next_member_[fan_number_[member]];
    } while (member != vertex);
  }
  // Splits a boundary edge at a vertex: two triangles stand for one. False: refused, nothing has changed.
  bool split(std::uint32_t a, std::uint32_t b, std::uint32_t at);
  // Takes the latest split back, while nothing else was done since. Pre: it was of this edge at this vertex.
  void unsplit(std::uint32_t a, std::uint32_t b, std::uint32_t at);

  std::size_t welded() const { return welded_; }
  std::size_t splits() const { return sources_.size(); }
  std::size_t zipped() const { return zipped_; }  // edges that got their second triangle
  std::size_t work() const { return work_; }      // triangles that were looked at round vertices: what the time is proportional to

  // Of each triangle and vertex of the mesh in order: which one it was, or is a part of.
  struct Sources {
    std::vector<std::uint32_t> triangles;
    std::vector<std::uint32_t> vertices;
  };
  // Puts the mesh in order: welded vertices go, the parts of a split triangle stand in its place, vertices keep their order. Only calls
  // about members may follow.
  Sources finish();

 private:
  struct EdgeState {
    std::uint32_t count = 0;      // of triangles
    std::uint32_t triangles = 0;  // their numbers, by exclusive or: the one of a boundary edge, or from one of two to the other
  };
  // Edges by their vertices: open addressing, at most half full; none goes.
  class EdgeTable {
   public:
    EdgeTable();
    EdgeState find(std::uint64_t key) const { return states_[slot_of(key)]; }
    EdgeState& at(std::uint64_t key);

   private:
    static constexpr std::uint64_t kEmpty = std::numeric_limits<std::uint64_t>::max();
    std::size_t slot_of(std::uint64_t key) const;
    std::vector<std::uint64_t> keys_;
    std::vector<EdgeState> states_;
    std::size_t used_ = 0;
  };

  static std::uint64_t key_of(std::uint32_t a, std::uint32_t b) { return a < b ? std::uint64_t{a} << 32 | b : std::uint64_t{b} << 32 | a; }
  EdgeState find(std::uint32_t a, std::uint32_t b) const { return edges_.find(key_of(a, b)); }
  std::vector<std::uint32_t>& fan_of(std::uint32_t vertex) { return fans_[fan_number_[vertex]]; }
  const std::vector<std::uint32_t>& fan_of(std::uint32_t vertex) const { return fans_[fan_number_[vertex]]; }
  bool is_tracked(std::uint32_t vertex) const { return fan_number_[vertex] != kNone; }
  std::uint32_t source_of(std::uint32_t triangle) const;
  Edge edge_of(std::uint32_t triangle, std::uint32_t k) const;
  void add_edge(std::uint32_t a, std::uint32_t b, std::uint32_t triangle);
  void remove_edge(std::uint32_t a, std::uint32_t b, std::uint32_t triangle);
  void add_edges(std::uint32_t triangle);
  void remove_edges(std::uint32_t triangle);
  void count_boundary(std::uint32_t a, std::uint32_t b, bool is);
  bool is_sound(std::uint32_t source, const Triangle& triangle) const;
  std::vector<std::uint32_t> put_parts_in_place();
  bool keeps_members_near(std::uint32_t u, std::uint32_t v) const;
  bool keeps_edges_apart(std::uint32_t u, std::uint32_t v) const;
  bool flood(std::vector<std::uint32_t> reached, std::uint32_t to, const Vec3& near, double radius) const;

  TriangleMesh& mesh_;
  double tolerance_;
  std::vector<Triangle> original_;                // as they came
  std::vector<std::uint32_t> sources_;            // of triangles behind these: which one they were split off
  std::vector<std::uint32_t> fan_number_;         // of each vertex, kNone away from the boundary
  std::vector<std::vector<std::uint32_t>> fans_;  // triangles round a vertex
  std::vector<std::uint32_t> boundary_count_;
  std::vector<std::uint32_t> welded_to_;
  std::vector<std::uint32_t> next_member_;  // rings of vertices that were welded together, by fan number
  std::vector<std::uint32_t> vertex_of_fan_;
  EdgeTable edges_;
  std::size_t welded_ = 0;
  std::size_t zipped_ = 0;
  mutable std::size_t work_ = 0;
};

}  // namespace hapton
