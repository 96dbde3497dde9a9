#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/collision/triangle_cache.h"

namespace hapton {

// Finds the constrained minimum of the distance to the device for a point held by a surface, from the triangles' adjacency alone: straight
// over faces, along concave edges, round vertices, always nearer to the device. It works where the surface is locally manifold: each edge
// on the path has two faces, each vertex one closed fan, and no face is inclined by more than 60 degrees to the first. The result needs no
// sweep, only a check that no other triangle is near the path (TriangleCache::is_clear). Anything else, including minima at vertices, is
// left to the caller's general method.
//
// Frame: the cache's local frame. RT: yes.
class FacetDescent {
 public:
  // A face that is an active constraint of the point.
  struct Constraint {
    std::uint32_t slot = TriangleCache::kNoSlot;
    Vec3 normal = Vec3::Zero();  // unit, towards the point
    double multiplier = 0.0;     // point - device = sum of multiplier * normal, without friction
  };

  // Coulomb friction of the surface. The point sticks if the projection of the device on the face is no farther away than `at_rest` times
  // the depth; a sliding point stops `sliding` times the depth short of it.
  struct Friction {
    double at_rest = 0.0;
    double sliding = 0.0;
    bool slides = false;  // state after the last step
  };

  // rest_offset: the point's distance from the surface. margin: distance within which an edge or vertex affects the point; rest_offset is
  // far below it.
  FacetDescent(TriangleCache& cache, double rest_offset, double margin) : cache_(cache), rest_offset_(rest_offset), margin_(margin) {}
  FacetDescent(TriangleCache& cache, double rest_offset, double margin, const Friction& friction)
      : cache_(cache), rest_offset_(rest_offset), margin_(margin), friction_(friction), has_friction_(true), slides_(friction.slides) {}

  // Starts at `start`, held by one face or by the two faces of a concave edge; multipliers need not be set. Returns false where the surface
  // is not locally manifold, or where the path leaves the cached region.
  bool run(const Vec3& start, std::span<const Constraint> held, const Vec3& device) noexcept;

  // Valid after a run that returned true.
  bool met_concave_edge() const { return met_concave_edge_; }  // the path met a concave edge or a vertex
  bool slides() const { return slides_; }                      // friction did not hold the point
  const Vec3& end() const { return end_; }
  std::span<const Constraint> constraints() const { return {constraints_.data(), static_cast<std::size_t>(constraint_count_)}; }
  std::span<const std::uint32_t> faces() const {
    return {faces_.data(), static_cast<std::size_t>(face_count_)};
  }  // cache slots of the faces on the path

 private:
  static constexpr int kMaxPoints = 24;
  static constexpr int kMaxFaces = 64;
  static constexpr int kMaxFan = 16;

  enum class Next : std::uint8_t { face, edge, corner, done, unclear };
  // A face and the side that the point is on.
  struct Facet {
    std::uint32_t slot;
    double side;  // 1: the side that the vertex order shows counter-clockwise; -1: the other
    const ContactTriangle* shape;
  };
  // Position on the surface. On a face: `edge` is the edge it entered by, `corner` the vertex it came from, or -1. On an edge: number
  // `edge` of `facet`, with `other` on the other side. At a vertex: number `corner` of `facet`.
  struct State {
    const Facet* facet = nullptr;
    const Facet* other = nullptr;
    int edge = -1;
    int corner = -1;
    int other_edge = -1;
  };
  using Fan = std::array<const Facet*, kMaxFan>;

  bool begin(const Vec3& start, std::span<const Constraint> held);
  Next cross_face(const Vec3& device);
  Next follow_edge(const Vec3& device);
  Next turn_corner(const Vec3& device);
  bool collect_fan(Fan& fan, std::array<int, kMaxFan>& corners, int& count);
  bool winds_once(std::span<const Facet* const> fan, std::span<const int> corners);
  const Facet* find_other(const Facet& facet, int edge, int& other_edge);
  bool move_to_edge(int edge);
  void move_to_face(const Facet* facet, int edge, int corner);
  bool is_clear(std::span<const Vec3> points) const;
  bool go_to(const Vec3& p);
  const Facet* add_facet(std::uint32_t slot, double side);
  static const ContactTriangle& shape(const Facet* facet) { return *facet->shape; }
  static Vec3 normal_of(const Facet* facet) { return facet->side * facet->shape->normal(); }
  static Vec3 projection_on(const Facet* facet, const Vec3& device);
  bool apply_friction(const Vec3& device, const Vec3& projection, Vec3& goal);
  Next settle_on_face(const Vec3& device, const Vec3& goal);
  Next settle_in_concave_edge(const Vec3& device, const Vec3& on_edge);

  TriangleCache& cache_;
  double rest_offset_;
  double margin_;
  State at_;
  Vec3 first_normal_ = Vec3::Zero();
  std::array<Vec3, kMaxPoints> points_;
  int point_count_ = 0;
  std::array<Facet, kMaxFaces> facets_;         // faces on the path so far
  std::array<std::uint32_t, kMaxFaces> faces_;  // their cache slots
  int face_count_ = 0;
  Vec3 end_ = Vec3::Zero();
  std::array<Constraint, 2> constraints_;
  int constraint_count_ = 0;
  bool met_concave_edge_ = false;
  Friction friction_;
  bool has_friction_ = false;
  bool slides_ = false;
};

}  // namespace hapton
