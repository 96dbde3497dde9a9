#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>

#include "core/force/sphere/centre_path.h"
#include "core/force/sphere/contact_set.h"
#include "core/force/sphere/corner_exit.h"
#include "core/force/sphere/drag_legs.h"
#include "core/force/sphere/gathered_triangles.h"
#include "core/force/sphere/large_fan.h"
#include "core/force/sphere/local_minimum.h"
#include "core/force/sphere/path_events.h"
#include "core/force/sphere/wedge.h"
#include "core/force/step_work.h"
#include "core/force/touch_scene.h"

namespace hapton {

// Moves a sphere's centre so that it follows the device along a straight motion, from event to event: the sweeping process of Moreau (1977)
// on the offset surface of all triangles. While the centre is a local minimum of its distance to the device, at most three parts of that
// surface are active, and it is the point closest to the device on
//
//   one plane, cylinder or sphere        in closed form
//   the curve where two of them meet     by Newton's method, from its last position
//   the point where three of them meet   constant
//
// until the next event: the contact leaves its face, edge or vertex; a multiplier reaches zero; the minimum along a curve vanishes; the
// sphere touches another triangle; the device comes to the free side. At an event the device is held, and the centre follows the steepest
// descent to the next local minimum. The triangles nearby are gathered once for many steps; only flights query the tree. Its classes:
//
//   ContactSet, LocalMinimum             what holds the centre, and where
//   MinimumLegs, DescentPath, DragLegs   the next piece of path
//   PathEvents                           what ends that piece
//   GatheredTriangles                    the triangles nearby
//   LargeFan, CornerExit, Wedge          where thousands of triangles meet, and where a point is held or is not
//
// Under Coulomb friction the centre sticks, is dragged along with the pull on the friction cone, or slips along the pull while the device
// is held: see OffsetDrag. There are then further events: the pull leaves the friction cone; the equilibrium on the cone vanishes.
//
// The centre never comes nearer to a triangle than offset - slop.
//
// Frame and units: TouchGeometry's local ones. RT: yes, bounded: follow() begins no event after `most_work` units of work (step_work.h),
// and completes the event that it has begun.
class SphereFollower {
 public:
  enum class Outcome : std::uint8_t {
    settled,    // at a local minimum for the device at the end of its motion, or free there
    exhausted,  // out of work with the device at `time`: a valid position on the path, from which the next step continues seamlessly
    failed,     // cannot continue: the centre is at a valid position for the device at `time`
  };

  // `offset`: the distance of a centre in contact. `materials`: one for each object. Geometry and materials outlive this object.
  // `is_point`: the sphere represents a point, so a corner that only the sphere's radius closes does not hold it.
  SphereFollower(const TouchGeometry& geometry, std::span<const Material> materials, double offset, bool is_point = false)
      : materials_(materials),
        contacts_({offset, kSlop, kTolerance}),
        near_(geometry, materials, contacts_.clearance(), (is_point ? kMinOfPoint : kMinOfSphere) * offset),
        is_point_(is_point),
        fan_(geometry) {
    note_friction();
  }
  // The friction of the materials has changed: a centre in contact settles again at the beginning of the next motion.
  void note_friction() noexcept {
    has_friction_ = false;
    for (const Material& material : materials_) has_friction_ |= material.friction_static > 0.0;
    is_descending_ |= !contacts_.is_empty();
  }

  // Whether the centre is where the last step left the proxy. False: something else moved the proxy; call start() again.
  bool is_tracking() const { return is_tracking_; }
  void stop_tracking() {
    is_tracking_ = false;
    forget_corner();
  }
  bool slides() const { return friction_.slides; }  // the dynamic coefficient applies
  // The set of triangles has changed: they are gathered again.
  void forget_near() {
    near_.clear();
    fan_.forget();
    forget_corner();
  }
  // Resets everything except the counters: later steps do not depend on earlier ones.
  void forget() noexcept;

  // Begins with a centre that is free and at the device.
  void start_free(const Vec3& centre) noexcept;
  // Begins with a centre that is free, or in contact and nearer than the offset by at most `short_by`. False: it cannot begin there.
  bool start(const Vec3& centre, bool is_free, double short_by, bool slides = false) noexcept;
  // The device moves straight from `from` (time 0) to `to` (time 1), beginning at `time`. Pre: is_tracking().
  Outcome follow(const Vec3& from, const Vec3& to, double& time, int most_work = StepWork::kMax) noexcept;
  // After a call of follow that failed: the centre is at a local minimum for the device at the end of its motion, in a slit as wide as the
  // sphere, and a sweep may bring a point nearer to the device. False after start.
  bool is_in_slit() const { return is_in_slit_; }
  int work() const { return work_; }  // units, of the last call of start or follow
  // Whether a flight of the last call was given up because it met too many triangles.
  bool has_given_up_flight() const { return has_given_up_flight_; }

  double offset() const { return contacts_.offset(); }
  const Vec3& centre() const { return centre_; }
  bool is_free() const { return contacts_.is_empty(); }
  // The active contacts. When settled, the sum of multiplier * normal is centre - device.
  std::span<const OffsetContact> contacts() const { return contacts_.active(); }

  std::uint64_t events() const { return events_; }  // since construction, like all below
  std::uint64_t slips() const { return slips_; }    // pieces of path under friction with the device held
  std::uint64_t flights() const { return flights_; }
  std::uint64_t gathered() const { return near_.gathered(); }
  std::uint64_t queried() const { return queried_; }

 private:
  // Of Clearance, in local units: 4,096 and 64 times the rounding of a coordinate.
  static constexpr double kSlop = 0x1p-40;
  static constexpr double kTolerance = 0x1p-46;
  // The least radius of a gathered ball, in offsets. For a point, the offset is far below the size of triangles.
  static constexpr double kMinOfPoint = 64.0;
  static constexpr double kMinOfSphere = 0x1p-6;
  static constexpr double kMinGain = 0x1p-44;   // coming nearer by less is no progress: 256 times the rounding of a coordinate
  static constexpr double kFarDistance = 32.0;  // local units; farther out, the rounding of positions exceeds the tolerance
  static constexpr int kMaxTurns = 64;          // descents towards a device farther out, each with a new direction to it
  static constexpr double kBalance = 0x1p-28;   // distance from the boundary of a face within which the sphere balances on it
  static constexpr int kWorkOfEvent = 5;        // units, in addition to its queries
  static constexpr int kMaxCornerTries = 2;     // in a motion
  static constexpr int kMaxIdleEvents = 24;     // events without progress; a choice
  static constexpr int kMaxSkips = 16;          // in a motion; a choice
  static constexpr int kMaxFlightTests = 512;   // triangles outside of large fans that a flight may test

  enum class Next : std::uint8_t { again, wait, settled, failed };
  using Exit = PathEvents::Exit;
  using Event = PathEvents::Event;

  // Coulomb friction: stick, slip, or drag.
  struct FrictionState {
    bool slides = false;        // the dynamic coefficient is in force
    bool drags = false;         // the pull is on its cone and the device drags the centre
    bool slips = false;         // the pull has just left the cone
    bool has_vanished = false;  // the equilibrium on the cone has vanished
    double step = 0.0;          // OffsetDrag::Flow::step of the last drag; 0: none yet
    std::array<FrictionCoefficients, 3> coefficients;
  };
  struct Reaction {  // of the contacts, to the pull on a centre that sticks
    bool is_known = false;
    bool is_free = false;
    double tangential = 0.0;
    double depth = 0.0;
    FrictionCoefficients friction;
  };

  const Clearance& clearance() const { return contacts_.clearance(); }
  LocalMinimum minimum() const { return LocalMinimum(contacts_); }
  PathEvents events_on() { return {contacts_, near_, event_space_, work_}; }
  void forget_corner() { corner_.at = Vec3::Constant(std::numeric_limits<double>::infinity()); }
  CornerExit corner() { return {contacts_, near_, centre_, corner_, work_}; }
  Wedge wedge() { return {contacts_, near_, centre_, work_}; }
  DragLegs drag_legs() { return {contacts_, events_on(), centre_, friction_.step, work_}; }

  FrictionCoefficients coefficients(const OffsetContact& contact) const noexcept;
  bool has_friction_here() const noexcept;
  OffsetDrag make_drag() noexcept;
  Next hold(const OffsetDrag::Pull& pull) noexcept;
  Next descend_with_friction(const Vec3& device, const Vec3& motion) noexcept;
  Next drag(const Vec3& from, const Vec3& to, double& time) noexcept;
  bool note_short_drag(double device_travel) noexcept;
  double time_on_line(const OffsetDrag& drag, const Vec3& from, const Vec3& to, const Vec3& start, double time, const DragLeg& leg,
                      double share) noexcept;
  Reaction find_reaction(const Vec3& pull) const noexcept;
  class StickSearch;
  Next stay_with_friction(const Vec3& from, const Vec3& to, double& time) noexcept;

  struct Span {
    double begin = 0.0, end = 1.0;
  };
  // A shorter motion of the device counts as no progress: where many such pieces follow each other, a point skips ahead (skip_ahead).
  double least_progress() const { return is_point_ ? LocalMinimum::kAtAxis : LocalMinimum::kMinMotion; }
  static Span find_span(const Vec3& from, const Vec3& to);
  Outcome follow_finite(const Vec3& from, const Vec3& to, double& time) noexcept;
  Outcome follow_near(const Vec3& from, const Vec3& to, double& time) noexcept;
  Next follow_event(const Vec3& from, const Vec3& to, double& time, bool has_fans) noexcept;
  bool is_near_path(const Vec3& centre, const CentrePath& path, double share) const noexcept;
  bool note_lingering() noexcept;
  bool skip_ahead(const Vec3& from, const Vec3& to, double& time) noexcept;
  bool are_same_contact() const noexcept;
  Next drop_weaker(const Vec3& pull) noexcept;
  Next fly(const Vec3& from, const Vec3& to, double& time) noexcept;
  Next fly_to(const Vec3& to, double& until) noexcept;
  Next descend(const Vec3& device, const Vec3& motion) noexcept;
  bool opens_within_rounding(const CentrePath& path, const Vec3& pull) const noexcept;
  Next descend_no_farther(const Vec3& device, bool is_unstable) noexcept;
  Next descend_along(const CentrePath& path, const Vec3& device, bool is_on_contacts) noexcept;
  Next slide(const Vec3& from, const Vec3& to, double& time) noexcept;
  Next wait(const Vec3& from, const Vec3& to, double& time) const noexcept;
  bool find_escape_direction(const Vec3& motion) noexcept;
  Next stay(const Vec3& from, const Vec3& to, double& time) noexcept;
  Next stay_within_rounding(const Vec3& to, double& time) noexcept;
  Next lose_minimum(const Vec3& hint) noexcept;
  bool cross_fan(const Vec3& from, const Vec3& to, double& time) noexcept;
  bool apply_event(const Event& event, const CentrePath& path) noexcept;
  std::optional<Next> end_leg(const CentrePath& path, const Event& event, bool is_whole, int released, const Vec3& device) noexcept;
  void move_to_next_part(int i, const Exit& exit, const Vec3& direction) noexcept;
  int find_rising(const OffsetContact& contact, int edge, const Vec3& direction) noexcept;
  bool roll_off_face() noexcept;
  bool leave_by_flight(const Vec3& device, const Vec3& motion) noexcept;
  bool leave_slit_sideways(const Vec3& device, const Vec3& motion) noexcept;
  bool is_in_narrow_slit() const noexcept;  // between active contacts at nearly opposite sides
  bool straighten_in_slit() noexcept;
  bool fills_slit() noexcept;
  bool note_slit(bool has_device_moved) noexcept;  // false: it was noted before at this place, and the device has not moved
  bool leave_minimum(const Vec3& device, const Vec3& motion) noexcept;
  bool leave_corner(const Vec3& device, const Vec3& motion) noexcept;
  bool leave_reentrant_corner(const Vec3& device, const Vec3& motion) noexcept;
  bool move_past_corner(const Vec3& target, double radius) noexcept;
  bool fly_around_corner(const TangentCone::Steepest& to, double radius, bool ahead) noexcept;
  bool fly_over(const Vec3& displacement, double height) noexcept;
  template <class Go>
  bool try_escape(const Vec3& device, const Vec3& motion, Go&& go) noexcept;
  Vec3 find_lift(double height) noexcept;
  bool fly_straight(const Vec3& motion, double share) noexcept;
  int find_coplanar(const OffsetContact& contact, const Exit& exit) noexcept;
  bool overlaps(const ContactTriangle& shape) const noexcept;
  bool note_move(const Vec3& from) noexcept;  // whether the centre has moved
  void note_gain(const Vec3& device, bool has_moved) noexcept;

  std::span<const Material> materials_;
  ContactSet contacts_;
  GatheredTriangles near_;
  bool is_point_;
  bool has_friction_ = false;
  FrictionState friction_;
  bool is_tracking_ = false;
  bool is_descending_ = false;
  bool is_carried_ = false;  // the last step ran out of work
  bool has_given_up_flight_ = false;
  Vec3 lingered_at_ = Vec3::Zero();  // the centre where lingering_events_ began
  std::optional<Vec3> slit_at_;      // the centre, when a slit was last left to sweeps
  bool is_in_slit_ = false;          // the last call left a slit to sweeps
  int short_drags_ = 0;              // consecutive drags that were short (note_short_drag)
  int lingering_events_ = 0;         // events at lingered_at_, above a usual number
  bool has_lost_minimum_ = false;    // the descent continues along direction_hint_
  Vec3 centre_ = Vec3::Zero();
  Vec3 direction_hint_ = Vec3::Zero();  // the last direction of motion
  PathEvents::Space event_space_;
  LargeFan fan_;
  int work_ = 0;  // units, of this call
  int most_work_ = 0;
  int idle_events_ = 0;             // consecutive events without progress
  double least_distance_ = 0.0;     // least of centre to device, since the device moved
  Vec3 far_target_ = Vec3::Zero();  // the target of the last descent towards a device beyond kFarDistance
  CornerExit::Memory corner_;
  int corner_tries_ = 0;                    // in this motion of the device
  int skip_count_ = 0;                      // calls of skip_ahead in this motion
  std::uint64_t motion_ = 1;                // number of this motion; counts up from 1
  bool has_untried_escapes_ = false;        // the last call reached its work limit before it tried them: the next call does
  std::optional<Vec3> untried_escapes_at_;  // the centre in the minimum that they leave; none: nothing is left to try
  bool resumes_escapes_ = false;            // this call continues with untried escapes, and has not yet tried one
  int escapes_reached_ = 0;                 // number reached at this minimum in this call, tried or skipped
  int failed_escapes_ = 0;                  // number of them that failed, also in earlier calls: not tried again
  std::uint64_t last_fly_over_ = 0;         // motion_ when a flight over a barrier was last tried; 0: never
  std::uint64_t events_ = 0, slips_ = 0, flights_ = 0, queried_ = 0;
};

}  // namespace hapton
