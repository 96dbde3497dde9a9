#pragma once

#include <array>

#include "core/math/types.h"

namespace hapton {

// Whether the triangle touches the axis-aligned box box_low..box_high; both contain their boundary. Conservative: true where rounding
// leaves the answer open, never false for a triangle that touches. Units: metres. Frame: any, one for all. RT: yes. Source: Akenine-Moller,
// "Fast 3D Triangle-Box Overlap Testing", J. Graphics Tools 6 (2001): 13 separating axes. We differ: each axis has a rounding bound.
bool may_touch(const std::array<Vec3, 3>& triangle, const Vec3& box_low, const Vec3& box_high) noexcept;

}  // namespace hapton
