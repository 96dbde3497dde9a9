#include "scene/scene_fit.h"

namespace hapton {

void SceneFit::apply(TriangleMesh& mesh, SealReport& sealed) const {
  for (Vec3& vertex : mesh.vertices) vertex = apply(vertex);
  scale_widths(sealed, scale);
}

void scale_widths(SealReport& sealed, double scale) {
  sealed.widest_gap *= scale;
  sealed.tolerance *= scale;
}

Result<SceneFit> find_fit(const Eigen::AlignedBox3d& box, const Vec3& size_m) {
  if (!(box.sizes().maxCoeff() > 0.0)) return fail("all vertices are at one point, so the scene cannot be scaled to a size");
  return SceneFit{box.center(), (size_m.array() / box.sizes().array()).minCoeff()};
}

}  // namespace hapton
