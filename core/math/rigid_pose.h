#pragma once

#include <array>
#include <optional>

#include "core/math/types.h"

namespace hapton {

// The one check that 12 numbers from outside are a rigid pose: row-major 3 x 4, [R|t]. Codec, hub and haptics node all use it, so that a
// pose which one of them accepts is accepted by all.
// Frames: any. Units: t in m. RT: yes. Threads: any.

// The sum of |R R^T - I| over its nine elements, at most. A dial of the knob box multiplies thousands of rotations in single precision
// (6e-8 each) before it renormalises; a scale or shear of 0.1 % is a mistake of the sender. Also the protocol's figure
// (proto/hapton.proto).
constexpr double kRigidTolerance = 1e-3;
// Largest coordinate of t: squares and products of it stay finite.
constexpr double kMaxTranslationM = 1e9;

// False for numbers that are not finite, and for a rotation that is scaled, sheared or mirrored beyond the tolerance.
bool is_rigid(const std::array<float, 12>& X) noexcept;

// The pose, its rotation orthonormal to double precision; none if it is not rigid.
std::optional<Pose> find_rigid_pose(const std::array<float, 12>& X) noexcept;

}  // namespace hapton
