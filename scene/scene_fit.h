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

// The scale and the shift that fit a scene into a box. Frame: S. RT: no.
struct SceneFit {
  Vec3 centre = Vec3::Zero();
  double scale = 1.0;

  Vec3 apply(const Vec3& p_S) const { return scale * (p_S - centre); }
  void apply(TriangleMesh& mesh, SealReport& sealed) const;
};

// Scales the lengths in a report on cracks, as its mesh was scaled.
void scale_widths(SealReport& sealed, double scale);

// Adds a note on the scale, unless its first four digits are those of 1: "fit_m: scene scaled by 0.1". by: the key or table that gives the
// scale. RT: no.
void note_scale(std::string_view by, const SceneFit& fit, std::vector<std::string>& notes);

// Text for a fitted mesh file, `box` before the fit: its length, the scale unless it is 1, and how to switch the fit off. RT: no.
std::string describe_fit(const std::string& path, const Eigen::AlignedBox3d& box, const SceneFit& fit);

// The largest scale, and the shift, that fit the box into one of size_m around the origin. Error: a box that is a point or too far away.
Result<SceneFit> find_fit(const Eigen::AlignedBox3d& box, const Vec3& size_m);

}  // namespace hapton
