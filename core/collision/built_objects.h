#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/collision/box.h"
#include "core/collision/object_geometry.h"

namespace hapton {

// The objects of a scene, built for a probe: a snapshot that any number of TouchGeometry share, so that a scene in which one object has
// moved shares all others with the scene before. Threads: immutable. RT: set-up only.
struct BuiltObjects {
  LocalFrame frame;
  std::optional<double> shading_crease_rad;                    // of the smooth normals, as ObjectGeometry has it
  std::vector<std::shared_ptr<const TriangleMesh>> meshes;     // frame S: what the objects were built of
  std::vector<std::shared_ptr<const ObjectGeometry>> objects;  // with the marks of each other (MarkedObjects)
  std::vector<Box> bounds;                                     // of each object, local

  // Whether these are the objects of a scene of those very meshes, with such normals.
  bool are_of(const std::vector<std::shared_ptr<const TriangleMesh>>& scene, std::optional<double> crease_rad) const {
    return meshes == scene && shading_crease_rad == crease_rad;
  }
};

}  // namespace hapton
