#pragma once

#include <cstdint>

#include "core/collision/wide_bvh.h"
#include "core/force/evaluation/force_error.h"
#include "core/geometry/triangle_mesh.h"

namespace hapton {

// Counts the facets that a proxy crosses, from its path alone, so that it works for any method. Not part of any measured time.
class FacetLocator {
 public:
  // Pre: the mesh outlives this object.
  explicit FacetLocator(const TriangleMesh& mesh);

  // The index of the triangle nearest to p; of two at the same distance the lower index.
  std::uint32_t find_nearest(const Vec3& p) const;

  // The number of changes of the nearest triangle between successive points that divide the path into kSamples equal parts. Facets passed
  // between two of these points are missed, so this is a lower bound.
  std::uint64_t count_crossed(const Vec3& from, const Vec3& to) const;

  static constexpr int kSamples = 8;  // number of parts of a path: the nearest triangle is found at each eighth

 private:
  const TriangleMesh& mesh_;
  Vec3 origin_;
  WideBvh tree_;
};

}  // namespace hapton
