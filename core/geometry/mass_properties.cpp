#include "core/geometry/mass_properties.h"

#include <cmath>

#include "core/geometry/inside_out.h"
#include "core/geometry/mesh_measures.h"

namespace hapton {

std::optional<MassProperties> compute_mass_properties(const TriangleMesh& mesh) {
  if (!count_edges(mesh).closed()) return std::nullopt;
  // The volume of a body that is inside out would count as negative: the sum may be above zero, with an inertia that no solid has.
  if (count_closed_bodies(mesh).inside_out > 0) return std::nullopt;
  const MeshBounds bounds = compute_bounds(mesh);
  const Vec3 middle = bounds.centre();

  // A tetrahedron with one corner at the origin and the others at a, b, c has the volume det(a, b, c) / 6, the first moment volume (a + b +
  // c) / 4, and the second moment volume (a a' + b b' + c c' + s s') / 20 with s = a + b + c.
  double volume = 0.0;
  Vec3 first_moment = Vec3::Zero();
  Mat3 second_moment = Mat3::Zero();
  for (const auto& triangle : mesh.triangles) {
    const Vec3 a = mesh.vertices[triangle[0]] - middle;
    const Vec3 b = mesh.vertices[triangle[1]] - middle;
    const Vec3 c = mesh.vertices[triangle[2]] - middle;
    const Vec3 sum = a + b + c;
    const double tetrahedron_volume = a.dot(b.cross(c)) / 6.0;
    volume += tetrahedron_volume;
    first_moment += tetrahedron_volume / 4.0 * sum;
    second_moment += tetrahedron_volume / 20.0 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
  }
  // The largest volume that may be rounding: each term is below extent^3, and takes fewer than eight roundings of 2^-53.
  const double rounding = 0x1p-50 * static_cast<double>(mesh.triangles.size()) * std::pow(bounds.extent(), 3);
  if (!(volume > rounding)) return std::nullopt;

  const Vec3 centre = first_moment / volume;
  const Mat3 covariance = second_moment / volume - centre * centre.transpose();
  return MassProperties{
      .volume = volume, .centre = middle + centre, .inertia_per_mass = covariance.trace() * Mat3::Identity() - covariance};
}

}  // namespace hapton
