#pragma once

#include <cstdint>

#include "core/collision/wide_bvh.h"
#include "core/force/evaluation/force_error.h"
#include "core/geometry/triangle_mesh.h"

namespace hapton {

// Counts the facets that a proxy crosses, from its path alone and outside all timing, so that it works for any method.
class FacetLocator {
 public:
  // Pre: the mesh outlives it.
  explicit FacetLocator(const TriangleMesh& mesh);

  // The triangle nearest to p; the lower one of two at the same distance.
  std::uint32_t find_nearest(const Vec3& p) const;

  // Changes of the nearest triangle at kSamples equal parts of the path. Facets passed between two of them are missed, so this is a lower
  // bound.
  std::uint64_t count_crossed(const Vec3& from, const Vec3& to) const;

  static constexpr int kSamples = 8;  // of a path: the nearest triangle is found at each eighth

 private:
  const TriangleMesh& mesh_;
  Vec3 origin_;
  WideBvh tree_;
};

}  // namespace hapton
