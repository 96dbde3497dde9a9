#pragma once

#include <array>
#include <optional>

#include "core/math/types.h"

namespace hapton {

// The only test whether 12 received numbers are a rigid pose: row-major 3 x 4, [R|t]. Codec, hub and haptics node all use it, so they all
// accept the same poses. Frames: any. Units: t in m. RT: yes. Threads: any.

// Largest sum of |R R^T - I| over its nine elements. A dial of the knob box multiplies thousands of rotations in single precision (6e-8
// each) before it renormalises; a scale or shear of 0.1 % is an error of the sender. The protocol has the same number (proto/hapton.proto).
constexpr double kRigidTolerance = 1e-3;
// Largest coordinate of t, so that its squares and products stay finite.
constexpr double kMaxTranslationM = 1e9;

// False for numbers that are not finite, and for a rotation scaled, sheared or mirrored beyond the tolerance.
bool is_rigid(const std::array<float, 12>& X) noexcept;

// The pose, with its rotation orthonormal in double precision; empty if the numbers are not rigid (is_rigid).
std::optional<Pose> find_rigid_pose(const std::array<float, 12>& X) noexcept;

// The position in frame B of a point given in frame A; X_AB is the rigid pose of B in A. RT: yes.
inline Vec3 to_frame(const Pose& X_AB, const Vec3& p_A) noexcept { return X_AB.linear().transpose() * (p_A - X_AB.translation()); }

}  // namespace hapton
