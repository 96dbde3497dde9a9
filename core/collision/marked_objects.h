#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "core/collision/box.h"
#include "core/collision/object_geometry.h"

namespace hapton {

// Marks the triangles of a scene's objects that are near another object: there a point or a sphere cannot follow the surface by adjacency
// alone. The triangles that are near between two objects are remembered until one of the two is replaced, and an object whose marks do not
// change is not copied again. So the cost of replacing an object is a search of what lies near it, a copy of each object whose marks have
// changed, and one pass over the bounds of all objects.
//
// Units: local. Threads: one; the objects are shared and immutable. RT: set-up only.
class MarkedObjects {
 public:
  // objects: each as built without the others, all in one local frame. bounds: one box for each object, empty if it has no triangles.
  // Returns each object with its marks: the given one where no triangle is near another object, otherwise a marked copy.
  std::vector<std::shared_ptr<const ObjectGeometry>> update(const std::vector<std::shared_ptr<const ObjectGeometry>>& objects,
                                                            std::span<const Box> bounds);

 private:
  using NearOthers = std::map<std::uint32_t, std::vector<std::uint32_t>>;  // by other object: the triangles near it; no list is empty

  struct Object {
    std::shared_ptr<const ObjectGeometry> plain;
    std::shared_ptr<const ObjectGeometry> marked;
    NearOthers near;
  };

  std::vector<Object> objects_;
};

}  // namespace hapton
