#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/collision/object_geometry.h"

namespace hapton {

// The vertices and edges of a mesh as features of their own, for contact between meshes.
//
// A vertex or an edge belongs to several triangles, of which one owns it, so that each pair of features is found from one pair of triangles
// (representative triangles, Curtis, Tamstorf & Manocha 2008). Every triangle at a non-manifold edge owns that edge.
// Threads: immutable. RT: queries yes, construction set-up only. Pre: the geometry outlives this.
class SurfaceFeatures {
 public:
  explicit SurfaceFeatures(const ObjectGeometry& surface);

  const ObjectGeometry& surface() const { return *surface_; }
  bool owns_vertex(std::uint32_t t, int k) const { return (owned_[t] >> k & 1U) != 0; }
  bool owns_edge(std::uint32_t t, int k) const { return (owned_[t] >> (3 + k) & 1U) != 0; }

  std::size_t bytes() const { return owned_.capacity() + (first_.capacity() + ring_.capacity()) * sizeof(std::uint32_t); }

  // The vertices that share a triangle with v; one that shares several appears several times.
  std::span<const std::uint32_t> ring(std::uint32_t v) const { return std::span(ring_).subspan(first_[v], first_[v + 1] - first_[v]); }

  // True if vertex v is a local maximum of its surface along `outward`: no edge rises from it by more than `slope` times the edge's length.
  bool is_local_maximum(std::uint32_t v, const Vec3& outward, double slope = kFlat) const noexcept;
  // The same for edge k of triangle t: neither in t nor in the triangle adjacent there, if any, does the opposite vertex rise above it.
  bool is_local_maximum(std::uint32_t t, int k, const Vec3& outward, double slope = kFlat) const noexcept;

  // The direction between two features that are a contact offset apart has an error of about 2^-30.
  static constexpr double kFlat = 0x1p-28;

 private:
  const ObjectGeometry* surface_;
  std::vector<std::uint8_t> owned_;   // per triangle: bits 0..2 its vertices, 3..5 its edges
  std::vector<std::uint32_t> first_;  // per vertex, into ring_; one more at the end
  std::vector<std::uint32_t> ring_;
};

}  // namespace hapton
