#pragma once

#include <array>

#include "core/math/types.h"

namespace hapton {

// Whether triangle abc touches the axis-aligned box, both closed. Conservative: true if rounding leaves it open, so never false for a
// triangle that touches. Units: metres. Frame: any one frame. RT: yes. Source: Akenine-Moller, "Fast 3D Triangle-Box Overlap Testing", J.
// Graphics Tools 6 (2001): 13 separating axes. We differ in the rounding bound on every axis.
bool may_touch(const std::array<Vec3, 3>& triangle, const Vec3& box_low, const Vec3& box_high) noexcept;

}  // namespace hapton
