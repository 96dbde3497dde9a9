#pragma once

#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "core/force/mapped_surface.h"
#include "core/geometry/triangle_mesh.h"

namespace hapton {

// An image on a mesh. All texture coordinates are different, so that a wrong triangle is noticed.
inline SurfaceMaps made_maps(const TriangleMesh& mesh) {
  auto triangles = std::make_shared<std::vector<MappedTriangle>>();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    MappedTriangle made;
    for (std::size_t k = 0; k < 3; ++k) {
      made.corner[k] = mesh.corner(t, static_cast<int>(k));
      made.texcoord[k] = Eigen::Vector2d(3.0 * made.corner[k].x() + made.corner[k].z(), 2.0 * made.corner[k].y());
    }
    triangles->push_back(made);
  }
  std::vector<float> texels;
  for (int n = 0; n < 64 * 64; ++n) texels.push_back(0.5F + 0.5F * std::sin(0.05F * static_cast<float>(n)));
  const auto image = std::make_shared<const SurfaceImage>(64, 64, std::move(texels));
  return {.triangles = triangles, .height = {.image = image, .at_black = -1e-3, .at_white = 0.0}};
}

}  // namespace hapton
