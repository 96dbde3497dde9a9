#pragma once

#include <cstddef>

#include "core/geometry/smooth_surface.h"

namespace hapton {

// The faces of a smooth surface as a mesh of their own, without the fans that were added between their normals.
inline TriangleMesh faces_of(const SmoothSurface& surface) {
  TriangleMesh mesh;
  mesh.vertices = surface.mesh.vertices;
  mesh.triangles.assign(surface.mesh.triangles.begin(), surface.mesh.triangles.begin() + static_cast<std::ptrdiff_t>(surface.face_count));
  return mesh;
}

}  // namespace hapton
