#pragma once

#include <cstdint>
#include <vector>

#include "closed_loop/hand_path.h"
#include "core/base/result.h"
#include "core/force/force_method.h"
#include "core/geometry/triangle_mesh.h"

namespace hapton {

// A hand approaches a mesh, slides back and forth over it, rests there, and leaves.
struct SlidePlan {
  std::uint64_t seed = 1;  // decides place, direction and curvature
  double speed_m_per_s = 0.1;
  double slide_s = 4.0;
  double stroke_m = 0.15;  // length of path after which the hand turns back
  double depth_m = 1e-3;
  double rest_s = 0.8;
  double after_s = 0.5;  // simulated after the hand has left
  double period_s = 1e-3;
};

// The point of the surface at the hand, and the intended depth of the device below it (negative: above it). One row for each period.
struct SlideRow {
  Vec3 p_SQ = Vec3::Zero();
  Vec3 outward_S = Vec3::Zero();  // unit
  double depth_m = 0.0;

  Vec3 device_m() const noexcept { return p_SQ - depth_m * outward_S; }
};

struct SlidePath {
  std::vector<SlideRow> rows;
  std::size_t first_sliding_row = 0;
  std::size_t first_resting_row = 0;
  std::size_t first_leaving_row = 0;  // the hand begins to rise from the surface

  // Where a hand with this spring has to aim so that the device follows the rows against a surface of this stiffness.
  HandPath make_hand_path(double hand_n_per_m, double surface_n_per_m, double period_s) const;
};

// A path over the surface, straight or in a wide curve; the depth is measured along a normal that is smoothed over 2 mm of path. Paths are
// drawn at random until approach and departure touch nothing, and the proxy of `method`, which is stepped to check this,
// stays within two depths of the device. Error: no triangle of the mesh has an area; no such path in 1000 draws.
Result<SlidePath> make_slide_path(const TriangleMesh& mesh, ForceMethod& method, const SlidePlan& plan);

}  // namespace hapton
