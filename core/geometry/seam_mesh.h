#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// Marks the vertices of edges with one triangle; empty if the mesh has no such edge. Triangles that repeat a vertex have no edges. Linear
// in the mesh. RT: set-up only.
std::vector<std::uint8_t> find_boundary_vertices(const TriangleMesh& mesh);

// How far a triangle may turn that has an edge shorter than a few tolerances: as others, by less than 90 degrees; or by less than half of
// that, so that turning it twice does not flip it.
enum class Turning : std::uint8_t { any, little };

// Whether a triangle may become, or be split into, another one: not turned by 90 degrees or more, and not too thin for contact (height
// below kMinHeight tolerances where it had more). A triangle without an area may become anything.
bool is_sound_change(const std::array<Vec3, 3>& before, const std::array<Vec3, 3>& after, double tolerance, Turning turning = Turning::any);

// A mesh whose boundary is being joined: vertices on it are welded and edges on it split. Only triangles at the boundary are tracked.
//
// A change is rejected if it would break the surface:
// - no triangle loses its area (height below kMinHeight tolerances where it had more) or gets a normal that points away from its original
// one;
// - no edge gets more than two triangles, no two triangles get the same three vertices, no edge shrinks to nothing;
// - no vertex is farther than the tolerance from its origin. A vertex is moved onto another one, so every position is one of the original
// mesh.
//
// Units and frame: the mesh's. RT: set-up only. Threads: one.
class SeamMesh {
 public:
  static constexpr std::uint32_t kNone = 0xFFFFFFFFU;
  static constexpr double kMinHeight = 1e-6;  // of a triangle, in tolerances: far above what contact can distinguish from a line

  // A boundary edge in the direction of its triangle.
  struct Edge {
    std::uint32_t from = 0;
    std::uint32_t to = 0;
    std::uint32_t triangle = 0;
    std::uint32_t apex = 0;   // its third vertex
    std::uint32_t chord = 0;  // the original edge that it is, or is a part of: 3 times its triangle plus its number there
    std::uint32_t other(std::uint32_t end) const { return end == from ? to : from; }
  };

  // Pre: the mesh outlives this and nothing else changes it; at_boundary from find_boundary_vertices.
  SeamMesh(TriangleMesh& mesh, std::vector<std::uint8_t> at_boundary, double tolerance, Turning turning = Turning::any);

  double tolerance() const { return tolerance_; }
  const Vec3& position(std::uint32_t vertex) const { return mesh_.vertices[vertex]; }
  std::uint32_t standing_for(std::uint32_t vertex) const;  // the vertex it was finally welded to; itself if none
  bool is_boundary(std::uint32_t a, std::uint32_t b) const;
  bool is_edge(std::uint32_t a, std::uint32_t b) const { return find(a, b).count > 0; }
  std::uint32_t boundary_count(std::uint32_t vertex) const { return boundary_count_[vertex]; }  // edges that end there
  std::size_t valence(std::uint32_t vertex) const { return fan_of(vertex).size(); }             // Pre: at the boundary originally

  Edge boundary_edge(std::uint32_t a, std::uint32_t b) const;  // Pre: it is one
  std::vector<Edge> boundary_edges() const;                    // in the order of their triangles
  // The boundary edges at a vertex. Linear in its valence.
  void find_boundary_edges_at(std::uint32_t vertex, std::vector<Edge>& edges) const;
  std::vector<std::uint32_t> boundary_vertices() const;
  // The edge without splits: the straight line between the present ends of the edge that it was split from.
  std::pair<Vec3, Vec3> chord_of(const Edge& edge) const;
  // Unit, in the triangle's plane, perpendicular to the edge; zero if the triangle has no area.
  Vec3 inward(const Edge& edge) const;

  // Whether the surface continues from the triangles at one vertex, or from one triangle, to one at the other vertex, over edges that come
  // within `radius` of `near`: the two lie side by side on one piece of surface, without a gap between them. Also true if the search takes
  // too long. Linear in the lower valence.
  bool is_joined_nearby(std::uint32_t u, std::uint32_t v, const Vec3& near, double radius) const;
  bool is_triangle_joined_nearby(std::uint32_t triangle, std::uint32_t to, const Vec3& near, double radius) const;

  enum class Weld {
    done,
    rejected,
    too_far  // rejected only because a vertex welded to u before would be farther than the tolerance from its origin
  };
  // Moves vertex u onto v, or rejects and changes nothing. Linear in u's valence. Pre: both are at the boundary.
  Weld weld(std::uint32_t u, std::uint32_t v);
  // All vertices welded into this one, itself included.
  template <class Visit>
  void for_each_member(std::uint32_t vertex, Visit&& visit) const {
    std::uint32_t member = vertex;
    do {
      visit(member);
      member = next_member_[fan_number_[member]];
    } while (member != vertex);
  }
  // Lets `member` stand for the vertices welded into u instead of u, so that all triangles at u move there. False: rejected, nothing has
  // changed. Linear in u's valence. Pre: for_each_member(u) visits it.
  bool move_to_member(std::uint32_t u, std::uint32_t member);
  // Splits a boundary edge at a vertex: two triangles replace one. False: rejected, nothing has changed.
  bool split(std::uint32_t a, std::uint32_t b, std::uint32_t at);
  // Undoes the latest split if nothing else has changed since. Pre: it was of this edge at this vertex.
  void unsplit(std::uint32_t a, std::uint32_t b, std::uint32_t at);

  std::size_t welded() const { return welded_; }
  std::size_t splits() const { return sources_.size(); }
  std::size_t zipped() const { return zipped_; }  // edges that received their second triangle
  std::size_t work() const { return work_; }      // triangles examined at vertices; proportional to the time

  struct Sources {
    std::vector<std::uint32_t> triangles;  // for each of the resulting mesh, in order: the original one that it was, or is a part of
    std::vector<std::uint32_t> vertices;   // for each original one: the one of the resulting mesh that it became
  };
  // Finishes the mesh: removes welded vertices, puts the parts of a split triangle in its place; vertices keep their order. Only calls
  // about members may follow.
  Sources finish();

 private:
  struct EdgeState {
    std::uint32_t count = 0;      // of triangles
    std::uint32_t triangles = 0;  // their numbers, combined by exclusive or: the one of a boundary edge; with one of two known, the other
  };
  // Edges by their vertices: open addressing, at most half full; nothing is removed.
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
  bool stays_sound(std::uint32_t u, std::uint32_t v) const;
  bool keeps_members_near(std::uint32_t u, std::uint32_t v) const;
  void rename(std::uint32_t u, std::uint32_t v);
  bool keeps_edges_apart(std::uint32_t u, std::uint32_t v) const;
  bool flood(std::vector<std::uint32_t> reached, std::uint32_t to, const Vec3& near, double radius) const;

  TriangleMesh& mesh_;
  double tolerance_;
  Turning turning_;
  std::vector<Triangle> original_;                // as they came
  std::vector<std::uint32_t> sources_;            // of added triangles: the one that each was split from
  std::vector<std::uint32_t> fan_number_;         // by vertex; kNone away from the boundary
  std::vector<std::vector<std::uint32_t>> fans_;  // triangles at a vertex
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
