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
  std::uint64_t seed = 1;  // of the place and the direction
  double speed_m_per_s = 0.1;
  double slide_s = 4.0;
  double stroke_m = 0.15;  // until it turns back
  double depth_m = 1e-3;
  double rest_s = 0.8;
  double after_s = 0.5;  // watched on after it has left
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
  // Rows where these begin; leaving, it rises from the surface.
  std::size_t sliding = 0;
  std::size_t resting = 0;
  std::size_t leaving = 0;

  // What a hand with this spring aims at so that the device goes there against a surface of this stiffness.
  HandPath make_hand_path(double hand_n_per_m, double surface_n_per_m, double period_s) const;
};

// A walk over the surface in a straight line or a wide curve, with depth along a normal that is smoothed over 2 mm. Walks are drawn at
// random until approach and departure are free and the zero-delay proxy stays within two depths of the device, so that a hand can slide
// there; `method` is stepped to check this. Error: no such walk in 1000 draws.
Result<SlidePath> make_slide_path(const TriangleMesh& mesh, ForceMethod& method, const SlidePlan& plan);

}  // namespace hapton
