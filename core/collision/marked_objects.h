#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "core/collision/box.h"
#include "core/collision/object_geometry.h"

namespace hapton {

// The objects of a scene with the triangles marked that are near another object, where a point or a sphere cannot follow the surface by
// adjacency alone. What the marks of two objects say of each other is kept until one of them is replaced, and an object whose marks stay is
// the same one as before. So replacing an object costs what lies near it, however large the scene is, and a copy of each object whose marks
// have changed.
//
// Units: local. Threads: one; the objects are shared and immutable. RT: set-up only.
class MarkedObjects {
 public:
  // objects: each as it is without the others, all in one local frame. bounds: of each, empty for one without triangles. Returns each with
  // its marks: itself where no triangle is near another object, else a copy.
  std::vector<std::shared_ptr<const ObjectGeometry>> update(const std::vector<std::shared_ptr<const ObjectGeometry>>& objects,
                                                            std::span<const Box> bounds);

 private:
  using NearOthers = std::map<std::uint32_t, std::vector<std::uint32_t>>;  // by other object: the triangles near it; none is left out

  struct Object {
    std::shared_ptr<const ObjectGeometry> plain;
    std::shared_ptr<const ObjectGeometry> marked;
    NearOthers near;
  };

  std::vector<Object> objects_;
};

}  // namespace hapton
