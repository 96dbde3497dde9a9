#pragma once

#include <array>
#include <cstdint>

#include "core/force/sphere/local_minimum.h"
#include "core/force/sphere/offset_drag.h"
#include "core/force/sphere/path_events.h"

namespace hapton {

// A slip: a piece of path along the pull, with the device held.
struct SlipPath {
  CentrePath path;
  Vec3 direction = Vec3::Zero();
  double length = 0.0;
  bool is_exact = false;    // the path is within 2^-42 local units of the exact one
  bool stops = false;       // the pull is on the cone at the end of the slip
  bool is_on_cone = false;  // the pull is on the cone already: there is no path
  bool waits = false;       // the equilibrium has not quite vanished yet: there is no path
  int released = -1;        // the contact whose multiplier is zero at the end of the slip; -1: none
};

enum class DragOutcome : std::uint8_t {
  moves,  // along the leg
  stops,  // the pull falls below the friction cone: the centre sticks
  jumps,  // the equilibrium on the cone has vanished: the centre slips
};

// One leg of a drag: a piece of path while the device moves and the pull stays on the friction cone. `time`: at its end.
struct DragLeg {
  CentrePath path;
  double time = 1.0;
  int released = -1;
  bool stops = false;
  bool jumps = false;
  double flow = 0.0;                        // length in the parameter of OffsetDrag::Flow; 0: not made by OffsetDrag::flow
  bool is_exact = false;                    // path and time are within 2^-42 of the exact ones, local units
  bool is_clear = false;                    // nothing changes the contact on the way: no event but its end
  bool is_line = false;                     // along the line where two planes meet, at an uneven speed, which the pull decides
  std::array<double, 2> pace = {0.0, 0.0};  // derivative of time_at by `share` at both ends; both zero: constant

  double time_at(double start, double share) const {
    const double duration = time - start;
    const double even = pace[0] == 0.0 && pace[1] == 0.0 ? duration : pace[0];
    const double even_there = pace[0] == 0.0 && pace[1] == 0.0 ? duration : pace[1];
    return start + share * (even + share * (3.0 * duration - 2.0 * even - even_there + share * (even + even_there - 2.0 * duration)));
  }
};

// The pieces of path of a centre on its active contacts under Coulomb friction: slips and drags, which OffsetDrag computes. A piece turns
// by at most LocalMinimum::kTurn, ends at the latest where the pull leaves the cone or a multiplier is zero, and is nearly a cubic. A view:
// all that it is made from outlives it.
//
// Frame and units: TouchGeometry's local ones. RT: yes. `work`: is raised by the units of work (step_work.h).
class DragLegs {
 public:
  // `events`: of the same contacts. `step`: the step size with which the last integration of a drag ended; 0: none yet.
  DragLegs(const ContactSet& contacts, PathEvents events, const Vec3& centre, double& step, int& work)
      : contacts_(contacts), minimum_(contacts), events_(events), centre_(centre), step_(step), work_(work) {}

  // `has_vanished`: the equilibrium on the cone has vanished, so the pull is on the cone already. `slip`: newly constructed. False: the
  // slip cannot be computed.
  bool make_slip(const OffsetDrag& drag, const OffsetDrag::Pull& pull, const Vec3& device, bool has_vanished, SlipPath& slip) noexcept;
  // The device moves straight from `from` (time 0) to `to` (time 1); the leg begins at `time`. `leg`: newly constructed.
  DragOutcome make(const OffsetDrag& drag, const Vec3& from, const Vec3& to, double time, DragLeg& leg) noexcept;

 private:
  // One search each, for the end of a slip or a leg.
  class SlipSearch;
  class FollowSearch;
  class FlowSearch;

  static constexpr double kNearZero = 0x1p-51;          // rounding of a value that crosses zero
  static constexpr double kPositionRounding = 0x1p-52;  // of a coordinate, local units
  // A centre that counts as on the cone may be off it by this much, so shorter pieces are no nearer to their cubic.
  static constexpr double kUnresolved = OffsetDrag::kMinPull;
  static constexpr double kExact = 0x1p-42;          // local units: within this the cubic counts as the exact path
  static constexpr double kMinExcessRate = 0x1p-46;  // per length of the device's motion: a drag whose excess falls faster stops
  static constexpr int kMaxSearch = 16;              // rounds of the search for an end; where rounding limits a path, more would not help

  DragOutcome make_followed_leg(const OffsetDrag& drag, const Vec3& from, const Vec3& to, double time, DragLeg& leg) noexcept;
  DragOutcome make_flow_leg(const OffsetDrag& drag, const Vec3& from, const Vec3& to, double time, DragLeg& leg) noexcept;
  DragOutcome make_last_leg(const Vec3& device, double time, const Vec3& normal, DragLeg& leg) const noexcept;
  // Rounding of the components of a pull: the rounding of the centre turns the normal of a curved part.
  double rounding_of(const OffsetDrag::Pull& pull) const noexcept;
  // How far the middle of a piece may be off its cubic: a share of the offset plus one of the length. Events are found on the cubic and
  // placed on the exact path: triangles are an offset away, so a centre that is off by a small part of the offset meets none of them.
  double max_cubic_error(double length) const noexcept;

  const ContactSet& contacts_;
  LocalMinimum minimum_;
  PathEvents events_;
  const Vec3& centre_;
  double& step_;
  int& work_;
};

}  // namespace hapton
