#pragma once

#include <Eigen/Geometry>

#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/triangle_mesh.h"
#include "core/math/types.h"
#include "scene/touch_mesh.h"

namespace hapton {

// Scales and shifts a scene so that it fits. Frame: S. RT: no.
struct SceneFit {
  Vec3 centre = Vec3::Zero();
  double scale = 1.0;

  Vec3 apply(const Vec3& p_S) const { return scale * (p_S - centre); }
  void apply(TriangleMesh& mesh, SealReport& sealed) const;
};

// The lengths of a report on cracks, scaled with its mesh.
void scale_widths(SealReport& sealed, double scale);

// A note on the scale, unless it is 1 as far as its four digits say: "fit_m: scene scaled by 0.1". by: the key or table
// that gives it. RT: no.
void note_scale(std::string_view by, const SceneFit& fit, std::vector<std::string>& notes);

// Of a mesh file alone, which is box before the fit: its length, its scale unless that is 1, and how to leave it as it is. RT: no.
std::string describe_fit(const std::string& path, const Eigen::AlignedBox3d& box, const SceneFit& fit);

// The largest scale, and the translation, that fit the box into one of size_m around the origin. Error: the box is a point.
Result<SceneFit> find_fit(const Eigen::AlignedBox3d& box, const Vec3& size_m);

}  // namespace hapton
