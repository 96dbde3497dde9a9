#include "core/geometry/winding_number.h"

#include <cmath>
#include <numbers>

namespace hapton {

double compute_winding_number(const TriangleMesh& mesh, const Vec3& p) {
  double sum = 0.0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Vec3 a = mesh.corner(i, 0) - p;
    const Vec3 b = mesh.corner(i, 1) - p;
    const Vec3 c = mesh.corner(i, 2) - p;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    // From edges, not corners: near a large face the corners are far away and their triple product is a small difference of large products.
    const double volume = a.dot((b - a).cross(c - a));
    const double denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    if (volume != 0.0) sum += 2.0 * std::atan2(volume, denominator);
  }
  return sum / (4.0 * std::numbers::pi);
}

}  // namespace hapton
