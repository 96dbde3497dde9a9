#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// A place where a wall of a mesh is thin.
struct ThinPlace {
  std::uint32_t triangle = 0;  // one face of the wall
  Vec3 point = Vec3::Zero();   // on that face
  double thickness = 0.0;      // from the point to the other face, along the triangle's normal
};

struct ThinWalls {
  std::size_t triangles = 0;          // number of triangles with a thin place
  std::optional<ThinPlace> thinnest;  // nothing: no wall is thin
};

// Two triangles are the two faces of a wall if their normals are opposite within an angle; this is the cosine of the angle. Faces that are
// inclined more form a wedge, which has an edge and no thickness.
constexpr double kWallCosine = 0.8660254037844386;  // 30 degrees

// Finds where walls are thinner than `width`: rays from points spread over each triangle go straight through the wall behind the triangle
// to the first triangle that shares no vertex with it. That triangle is the other face if it faces the other way. Triangles with a side
// longer than four times `width` are sampled more densely, up to kMaxThicknessRays points; a thinner place between the points is missed.
// Faces nearer than a millionth of the mesh's extent count as one place, as where parts touch: rays pass through them. Units and frame:
// those of the mesh. Pre: width > 0. Time: n log n. RT: set-up only.
constexpr int kMaxThicknessRays = 64;
ThinWalls find_thin_walls(const TriangleMesh& mesh, double width);

// The distance from p along the unit direction to the triangle abc, if it is in (0, most). A ray that misses the triangle's edges by no
// more than rounding still meets it. RT: yes.
std::optional<double> find_ray_hit(const Vec3& p, const Vec3& direction, double max_distance, const Vec3& a, const Vec3& b,
                                   const Vec3& c) noexcept;

// Calls use(point) for the points of one triangle from which the thickness is measured; of a small one only its centroid. RT: yes.
template <class Use>
void for_each_thickness_sample(const Vec3& a, const Vec3& b, const Vec3& c, double width, Use&& use) {
  // Parts of each side: at most four times `width` long, so that a thin place of that extent is found.
  const double longest = std::sqrt(std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()}));
  int parts = 1;
  while (parts * parts < kMaxThicknessRays && longest > 4.0 * width * parts) ++parts;
  const double step = 1.0 / parts;
  for (int i = 0; i < parts; ++i) {
    for (int j = 0; i + j < parts; ++j) {
      const auto at = [&](double u, double v) -> Vec3 { return a + step * u * (b - a) + step * v * (c - a); };
      use(at(i + 1.0 / 3.0, j + 1.0 / 3.0));
      if (i + j + 1 < parts) use(at(i + 2.0 / 3.0, j + 2.0 / 3.0));
    }
  }
}

}  // namespace hapton
