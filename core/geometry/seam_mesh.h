#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// By vertex: 1 at the ends of edges with only one triangle, otherwise 0; empty if the mesh has no such edge. Triangles that repeat a vertex
// have no edges. Time: linear in the mesh. RT: set-up only.
std::vector<std::uint8_t> find_boundary_vertices(const TriangleMesh& mesh);

// How far a triangle with an edge shorter than two tolerances may turn. any: by less than 90 degrees, as every other triangle; little: by
// less than half of that, so that two turns do not flip it.
enum class Turning : std::uint8_t { any, little };

// Whether a triangle may become `after`, or be split into triangles one of which is `after`: not turned too far (Turning) and not too thin
// for contact (height below kMinHeight tolerances and a tenth of what it was). A triangle without an area may become anything.
bool is_sound_change(const std::array<Vec3, 3>& before, const std::array<Vec3, 3>& after, double tolerance, Turning turning = Turning::any);

// A mesh whose boundary is being joined: vertices on it are welded and edges on it split. Only triangles at the boundary are tracked.
//
// A change is rejected if it would break the surface:
// - no triangle loses its area, gets too thin for contact or gets a normal that points away from its original one
// (is_sound_change);
// - no edge gets more than two triangles, no two triangles get the same three vertices, no edge shrinks to nothing;
// - no vertex is farther than the tolerance from its original position. A vertex is moved onto another one, so that every position is one
// of the original mesh.
//
// Units and frame: the mesh's. RT: set-up only. Threads: one.
class SeamMesh {
 public:
  static constexpr std::uint32_t kNone = 0xFFFFFFFFU;
  static constexpr double kMinHeight = 1e-6;  // height of a triangle in tolerances: far above what contact can distinguish from a line

  // A boundary edge, in the direction in which its triangle traverses it.
  struct Edge {
    std::uint32_t from = 0;
    std::uint32_t to = 0;
    std::uint32_t triangle = 0;
    std::uint32_t apex = 0;   // the third vertex of the triangle
    std::uint32_t chord = 0;  // the original edge that it is (a part of): 3 times the number of its triangle, plus its number there
    std::uint32_t other(std::uint32_t end) const { return end == from ? to : from; }
  };

  // Pre: the mesh outlives this and nothing else changes it; at_boundary is from find_boundary_vertices.
  SeamMesh(TriangleMesh& mesh, std::vector<std::uint8_t> at_boundary, double tolerance, Turning turning = Turning::any);

  double tolerance() const { return tolerance_; }
  const Vec3& position(std::uint32_t vertex) const { return mesh_.vertices[vertex]; }
  std::uint32_t representative_of(std::uint32_t vertex) const;  // the vertex to which this one was finally welded; itself if none
  bool is_boundary(std::uint32_t a, std::uint32_t b) const;
  bool is_edge(std::uint32_t a, std::uint32_t b) const { return find(a, b).count > 0; }
  std::uint32_t boundary_count(std::uint32_t vertex) const { return boundary_count_[vertex]; }  // boundary edges at the vertex
  std::size_t valence(std::uint32_t vertex) const { return fan_of(vertex).size(); }  // Pre: the vertex was at the boundary originally

  Edge boundary_edge(std::uint32_t a, std::uint32_t b) const;  // Pre: a b is a boundary edge
  std::vector<Edge> boundary_edges() const;                    // in the order of their triangles
  // The boundary edges at a vertex. Linear in its valence.
  void find_boundary_edges_at(std::uint32_t vertex, std::vector<Edge>& edges) const;
  std::vector<std::uint32_t> boundary_vertices() const;
  // The edge as if it had not been split: the line between the present ends of the original edge that it is a part of.
  std::pair<Vec3, Vec3> chord_of(const Edge& edge) const;
  // The direction from the edge into the triangle: unit, in the triangle's plane, perpendicular to the edge; zero if there is no area.
  Vec3 inward(const Edge& edge) const;

  // Whether the surface continues, over edges that come within `radius` of `near`, from a triangle at one vertex (or from the given
  // triangle) to a triangle at the other vertex: then the two lie side by side on one piece of surface, without a gap between them. Also
  // true if the search takes too long. Linear in the lower valence.
  bool is_joined_nearby(std::uint32_t u, std::uint32_t v, const Vec3& near, double radius) const;
  bool is_triangle_joined_nearby(std::uint32_t triangle, std::uint32_t to, const Vec3& near, double radius) const;

  enum class Weld {
    done,
    rejected,
    too_far  // rejected only because u, or a vertex welded to it before, would be farther than the tolerance from its origin
  };
  // Moves vertex u onto v, or rejects that and changes nothing. Linear in u's valence. Pre: both were at the boundary originally.
  Weld weld(std::uint32_t u, std::uint32_t v);
  // Calls visit(number) for all vertices welded to this one, itself included.
  template <class Visit>
  void for_each_member(std::uint32_t vertex, Visit&& visit) const {
    std::uint32_t member = vertex;
    do {
      visit(member);
      member = next_member_[fan_number_[member]];
    } while (member != vertex);
  }
  // Lets `member`, a vertex that for_each_member(u) visits, take the place of u for all vertices welded to u, so that all triangles at u
  // move to the position of `member`. False: rejected, nothing has changed. Linear in u's valence.
  bool move_to_member(std::uint32_t u, std::uint32_t member);
  // Splits edge a b at a vertex: two triangles replace one. False: rejected, nothing has changed. Pre: `at` was at the boundary originally.
  bool split(std::uint32_t a, std::uint32_t b, std::uint32_t at);
  // Undoes the latest split. Pre: it was of this edge at this vertex, and nothing else has changed since.
  void unsplit(std::uint32_t a, std::uint32_t b, std::uint32_t at);

  std::size_t welded() const { return welded_; }
  std::size_t splits() const { return sources_.size(); }
  std::size_t zipped() const { return zipped_; }  // edges that got their second triangle
  std::size_t work() const { return work_; }      // number of triangles examined at vertices; proportional to the time

  // Between the original mesh and the resulting one.
  struct Mapping {
    // For each triangle of the resulting mesh, in order: the original one that it is (a part of).
    std::vector<std::uint32_t> source_triangles;
    // For each original vertex: the vertex of the resulting mesh that it became.
    std::vector<std::uint32_t> resulting_vertices;
  };
  // Finishes the mesh: removes welded vertices, and puts the parts of a split triangle in its place; vertices keep their order. Afterwards
  // only representative_of and for_each_member may be called.
  Mapping finish();

 private:
  struct EdgeState {
    std::uint32_t count = 0;      // number of triangles
    std::uint32_t triangles = 0;  // exclusive or of their numbers: the number of a single one; of two, either if the other is known
  };
  // A hash table of edges by their two vertices: open addressing, at most half full; nothing is ever removed.
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
  void count_boundary(std::uint32_t a, std::uint32_t b, bool is_boundary_now);
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
  std::vector<Triangle> original_;                // the triangles as they were given
  std::vector<std::uint32_t> sources_;            // for each added triangle, the original one that it is a part of
  std::vector<std::uint32_t> fan_number_;         // by vertex; kNone where it was not at the boundary
  std::vector<std::vector<std::uint32_t>> fans_;  // the triangles at a vertex, by fan number
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
