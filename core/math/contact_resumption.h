#pragma once

#include <cstdint>

#include "core/math/rotation_vector.h"
#include "core/math/types.h"

namespace hapton {

// Whether a probe or a tool continues after a break in the samples or in the force, or begins anew.

// A contact continues after a break only if the device is within this distance (m) of where the probe was. A hand that meets no resistance
// moves a few millimetres in the time of a restart; farther away it may have gone around what it touched.
constexpr double kResumeReachM = 0.02;
// The same for the orientation of a tool (rad): at this angle the end of a tool that is 40 mm long has moved by kResumeReachM.
constexpr double kResumeTurnRad = 0.5;

// Samples come in time if they are less than this apart. After a longer gap the governor has released the force.
constexpr std::int64_t kLongGapNs = 20'000'000;

// Whether the straight line between two samples may be taken for the path of the hand, so that a probe may follow it: it is no longer than
// kResumeReachM, or the second sample came in time and the hand was no faster than hands are (a device that was away comes back in one
// step). Otherwise the hand may have gone around something. Frame: W. RT: yes.
inline bool is_path_known(const Vec3& from, const Vec3& to, std::int64_t gap_ns) noexcept {
  constexpr double kFastestPathMPerS = 10.0;  // twice the fastest hand (safety/safety_limits.h)
  const double moved_m = (to - from).norm();
  return moved_m <= kResumeReachM || (gap_ns < kLongGapNs && moved_m <= 1e-9 * static_cast<double>(gap_ns) * kFastestPathMPerS);
}

// The same for the turn of a tool. Pre: unit quaternions. Frame: W. RT: yes.
inline bool is_turn_known(const Quat& from, const Quat& to, std::int64_t gap_ns) noexcept {
  constexpr double kFastestTurnRadPerS = 50.0;  // above the fastest turn of a wrist
  const double turn = turn_between(from, to).norm();
  return turn <= kResumeTurnRad || (gap_ns < kLongGapNs && turn <= 1e-9 * static_cast<double>(gap_ns) * kFastestTurnRadPerS);
}

// Whether the device point has left the surface of its last contact on the outer side: it is on or beyond the plane through the
// proxy of that contact. Contact must then not be resumed, because it would hold the device from the wrong side of the surface.
// p_P: the proxy of the last contact. outward: proxy minus device point at that time, of any length; a zero vector (only effects
// acted) gives false. p_D: the device point now; true if it is not a number. Frames: any, one for all. Units: any, one for all. RT:
// yes.
inline bool has_left_contact(const Vec3& p_P, const Vec3& outward, const Vec3& p_D) noexcept {
  return !outward.isZero(0.0) && !((p_P - p_D).dot(outward) > 0.0);
}

}  // namespace hapton
