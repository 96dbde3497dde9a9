#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/collision/box.h"
#include "core/collision/object_geometry.h"

namespace hapton {

// The objects of a scene, built for a probe: a snapshot that any number of TouchGeometry share, so that a scene in which one object has
// moved shares all other objects with the previous scene. Threads: immutable. RT: set-up only.
struct BuiltObjects {
  LocalFrame frame;
  std::optional<double> shading_crease_rad;                    // of the smooth normals, see ObjectGeometry
  std::vector<std::shared_ptr<const TriangleMesh>> meshes;     // frame S: the objects were built from these
  std::vector<std::shared_ptr<const ObjectGeometry>> objects;  // triangles near another object are marked (MarkedObjects)
  std::vector<Box> bounds;                                     // of each object, local, with a margin for rounding

  // Whether these objects were built from exactly these meshes (the same pointers in the same order), with this crease angle.
  bool are_built_from(const std::vector<std::shared_ptr<const TriangleMesh>>& scene, std::optional<double> crease_rad) const {
    return meshes == scene && shading_crease_rad == crease_rad;
  }
};

}  // namespace hapton
