#include "core/geometry/simplify_small.h"

#include <fmt/core.h>
#include <meshoptimizer.h>

#include <algorithm>

namespace hapton {

Result<SimplifyReport> simplify_small(TriangleMesh& mesh, double max_error) {
  if (!(max_error >= 0.0 && max_error <= 1.0)) {
    return fail("simplification: the error bound {:g} is a share of the mesh's longest side; give 0 to 1", max_error);
  }
  SimplifyReport report;
  report.before = report.after = mesh.triangles.size();
  if (max_error == 0.0 || mesh.triangles.empty()) return report;

  Vec3 low = mesh.vertices.front();
  Vec3 high = low;
  for (const Vec3& v : mesh.vertices) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  const double side = (high - low).maxCoeff();
  if (!(side > 0.0)) return report;
  // Single precision is enough to choose which vertices go; those that stay keep their double precision.
  std::vector<float> positions(3 * mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Vec3 p = (mesh.vertices[i] - low) / side;
    for (int k = 0; k < 3; ++k) positions[3 * i + static_cast<std::size_t>(k)] = static_cast<float>(p[k]);
  }
  std::vector<unsigned int> indices;
  indices.reserve(3 * mesh.triangles.size());
  for (const Triangle& t : mesh.triangles) indices.insert(indices.end(), t.begin(), t.end());
  float error = 0.0F;
  const std::size_t kept = meshopt_simplify(indices.data(), indices.data(), indices.size(), positions.data(), mesh.vertices.size(),
                                            3 * sizeof(float), 0, static_cast<float>(max_error), meshopt_SimplifyLockBorder, &error);
  mesh.triangles.resize(kept / 3);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) mesh.triangles[t] = {indices[3 * t], indices[3 * t + 1], indices[3 * t + 2]};
  report.after = mesh.triangles.size();
  report.error_m = static_cast<double>(error) * side;
  return report;
}

std::string SimplifyReport::describe() const {
  return before == after ? fmt::format("simplify: {} triangles, none merged", before)
                         : fmt::format("simplify: {} triangles made {}, moved by at most {:g} m", before, after, error_m);
}

}  // namespace hapton
