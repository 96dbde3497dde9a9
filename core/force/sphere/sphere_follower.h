#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>

#include "core/collision/near_triangles.h"
#include "core/force/sphere/centre_path.h"
#include "core/force/sphere/contact_frame.h"
#include "core/force/sphere/offset_drag.h"
#include "core/force/sphere/offset_surface.h"
#include "core/force/sphere/tangent_cone.h"
#include "core/force/touch_scene.h"

namespace hapton {

// A sphere's centre that follows the device along its straight motion from event to event: the sweeping process of Moreau (1977) on the
// offset surface of all triangles. While the centre is a local minimum of its distance to the device, at most three parts of that surface
// hold it, and it is the point nearest to the device on
//
//   one plane, cylinder or sphere     a closed form
//   the curve where two meet          Newton, from where it was
//   the point where three meet        constant
//
// until an event: the contact leaves its face, edge or vertex; a multiplier reaches zero; the minimum along a curve vanishes; another
// triangle is hit; the device comes to the free side. At an event the device is held and the centre descends the steepest way to the next
// local minimum. Triangles near are gathered once for many steps (NearTriangles); only flights ask the tree.
//
// Under Coulomb friction the centre stays where it is, is dragged along its pull, or slides down along it while the device is held: see
// OffsetDrag. Then events are the pull's leaving its cone, too, and the end of the place on it.
//
// The centre never comes nearer to a triangle than offset - slop.
//
// Frame: TouchGeometry's local one. RT: yes. Bounded: an event, a triangle looked at and a round of a search are a piece of work each. A
// step has kLeastWork of them, and kWorkPerEdge more for each edge that a straight way over the object's surface crosses on the average, as
// long as the device's way and twice the pull; kMostWork in all.
class SphereFollower {
 public:
  static constexpr int kLeastWork = 4096;
  static constexpr double kWorkPerEdge = 256.0;
  static constexpr int kMostWork = 131072;
  static constexpr int kMostContacts = 8;

  enum class Outcome : std::uint8_t {
    settled,    // at a local minimum for the device at the end of its motion, or free there
    exhausted,  // out of work: a valid place short of it, to go on from in the next step
    unclear,    // cannot go on: the centre is at a valid place that it had with the device at `time`
  };

  // `offset`: how near the centre comes. `materials`: one an object. Both outlive it.
  // `is_point`: it stands for a point, which no corner holds that only its radius closes.
  SphereFollower(const TouchGeometry& geometry, std::span<const Material> materials, double offset, bool is_point = false)
      : geometry_(geometry), materials_(materials), keep_{offset, kSlop, kTolerance}, is_point_(is_point) {
    for (const Material& material : materials) has_friction_ |= material.friction_static > 0.0;
  }

  // Whether it holds the centre, or the centre was last moved by others.
  bool holds() const { return holds_; }
  void leave() {
    holds_ = false;
    cone_from_ = Vec3::Constant(std::numeric_limits<double>::infinity());
  }
  bool slides() const { return rub_.slides; }  // the dynamic coefficient is in force
  // What was gathered no longer is all there is.
  void forget_near() { near_.clear(); }

  // Takes over a centre that is free and with the device.
  void take_free(const Vec3& centre) noexcept;
  // Takes over a centre that is free, or in contact and at most `short_by` too near to what it touches. False: it cannot.
  bool take(const Vec3& centre, bool is_free, double short_by, bool slides = false) noexcept;
  // The device goes straight from `from` to `to`. Pre: holds.
  Outcome follow(const Vec3& from, const Vec3& to, double& time) noexcept;

  double offset() const { return keep_.offset; }
  const Vec3& centre() const { return centre_; }
  bool is_free() const { return touching_ == 0; }
  // What holds the centre; multipliers sum up to centre - device when it has settled.
  std::span<const OffsetContact> contacts() const { return std::span(contacts_).first(static_cast<std::size_t>(count_)); }

  std::uint64_t events() const { return events_; }  // since it was made, like all below
  std::uint64_t slips() const { return slips_; }    // pieces of way under friction with the device held
  std::uint64_t flights() const { return flights_; }
  std::uint64_t gathered() const { return gathered_; }
  std::uint64_t looked_at() const { return looked_at_; }

 private:
  static constexpr double kSlop = 0x1p-40;
  static constexpr double kTolerance = 0x1p-46;
  // The contact leaves a face so far beyond its edge, and enters it so far inside, and so for edges and their ends: rounding does not lead
  // back and forth.
  static constexpr double kOnBorder = 0x1p-44;
  static constexpr double kStill = 0x1p-42;           // a shorter way is none
  static constexpr double kLeastWay = 0x1p-40;        // at a local minimum no way is as long
  static constexpr double kNudge = 0x1p-42;           // of what balances, the device's motion decides
  static constexpr double kTurn = 0.125;              // rad, of one piece of the way
  static constexpr double kLeastStability = 0x1p-26;  // of a minimum along a curve: less, and it vanishes
  static constexpr double kAtAxis = 0x1p-39;          // from the axis of an edge or a vertex: nearer, and a direction is mostly rounding
  static constexpr double kLeastRise = 0x1p-45;       // rad: faces of less are one plane, as far as borders can tell
  static constexpr double kLeastLevel = 0x1p-50;      // in distance: less is rounding
  static constexpr double kLeastGain = 0x1p-44;
  static constexpr double kFar = 32.0;         // local units: farther out, positions are coarser than the tolerance
  static constexpr double kShallow = 0x1p-30;  // a minimum that a climb by so much leads out of is left: the reference's contact offset
  static constexpr int kMostIdle = 24;         // events that lead no nearer
  static constexpr int kMostPasses = 16;
  static constexpr int kMostExits = 128;

  enum class Next : std::uint8_t { again, wait, settled, unclear };
  // Where the contact may leave its part of the triangle: what lies beyond.
  struct Exit {
    Vec3 origin, direction;
    int slot = -1;  // in near_; -1: the same triangle
    int index = 0;
    OffsetContact::Part part = OffsetContact::Part::face;
  };
  struct Event {
    double time = 1.0;  // of the path
    int contact = -1;   // leaves its part, through `exit`
    Exit exit;
    int slot = -1;  // is hit
  };
  // A piece of the way with the device moving.
  struct Leg {
    CentrePath path;
    double time = 1.0;  // of the device at its end
    int released = -1;  // the contact whose multiplier is zero there
  };

  // Coulomb friction: the centre sticks, slips, and is dragged.
  struct Rubbing {
    bool slides = false;    // the dynamic coefficient is in force
    bool drags = false;     // the pull is on its cone, and the device draws the centre on
    bool slips = false;     // the pull has just left the cone,
    bool vanished = false;  // and the place on it at which the centre could stay is no more
    std::array<FrictionCoefficients, 3> coefficients;
  };
  struct Slip {
    CentrePath path;
    Vec3 way = Vec3::Zero();
    double length = 0.0;
    bool is_exact = false;  // the path is the way itself
    bool stops = false;     // the pull is on the cone at its end
    bool stands = false;    // it is there already
    bool waits = false;     // it has not quite left it
  };
  enum class Dragged : std::uint8_t { on, stops, leaps };
  struct DragLeg {
    CentrePath path;
    double time = 1.0;
    int released = -1;
    bool stops = false;
    bool leaps = false;
    double flow = 0.0;                        // its length, of what is not flat
    bool is_exact = false;                    // the path is the way itself, and the time
    std::array<double, 2> pace = {0.0, 0.0};  // its derivative at both ends; zero: even

    double time_at(double start, double share) const {
      const double way = time - start;
      const double even = pace[0] == 0.0 && pace[1] == 0.0 ? way : pace[0];
      const double even_there = pace[0] == 0.0 && pace[1] == 0.0 ? way : pace[1];
      return start + share * (even + share * (3.0 * way - 2.0 * even - even_there + share * (even + even_there - 2.0 * way)));
    }
  };
  struct Held {  // a pull on a centre that stays
    bool is_known = false;
    bool is_free = false;
    double way = 0.0;
    double depth = 0.0;
    FrictionCoefficients friction;
  };

  FrictionCoefficients coefficients(const OffsetContact& contact) const noexcept;
  bool rubs() const noexcept;
  OffsetDrag make_drag() noexcept;
  Next hold(const OffsetDrag::Pull& pull) noexcept;
  Next descend_rubbing(const Vec3& device, const Vec3& motion) noexcept;
  bool make_slip(const OffsetDrag& drag, const OffsetDrag::Pull& pull, const Vec3& device, bool has_vanished, Slip& slip) noexcept;
  Next drag(const Vec3& from, const Vec3& to, double& time) noexcept;
  Dragged make_drag_leg(const OffsetDrag& drag, const Vec3& from, const Vec3& to, double time, DragLeg& leg) noexcept;
  Dragged make_flow_leg(const OffsetDrag& drag, const Vec3& from, const Vec3& to, double time, DragLeg& leg) noexcept;
  Dragged make_last_leg(const Vec3& device, double time, const Vec3& normal, DragLeg& leg) const noexcept;
  double find_reach(const Vec3& way) noexcept;
  Held find_held(const Vec3& pull) const noexcept;
  Next stay_rubbing(const Vec3& from, const Vec3& to, double& time) noexcept;

  struct Span {
    double begin = 0.0, end = 1.0;
  };
  static Span find_span(const Vec3& from, const Vec3& to);
  Outcome follow_near(const Vec3& from, const Vec3& to, double& time) noexcept;
  bool pass_by(const Vec3& from, const Vec3& to, double& time) noexcept;
  Next drop_weaker(const Vec3& pull) noexcept;
  int most_work(const Vec3& from, const Vec3& to) const noexcept;
  Next fly(const Vec3& from, const Vec3& to, double& time) noexcept;
  Next fly_to(const Vec3& to, double& until) noexcept;
  bool find_active(const Vec3& pull, const Vec3& motion, Vec3& way) noexcept;
  Next descend(const Vec3& device, const Vec3& motion) noexcept;
  Next slide(const Vec3& from, const Vec3& to, double& time) noexcept;
  Next wait(const Vec3& from, const Vec3& to, double& time) const noexcept;
  bool find_way_off(const Vec3& motion) noexcept;
  void hold_against(const Vec3& device, const Vec3& motion) noexcept;
  bool is_on_axis(const Vec3& device) const noexcept;
  double time_off_axis(const Vec3& from, const Vec3& to, double time) const noexcept;
  template <class Place>
  void place_at_event(const CentrePath& path, Event& event, Place&& place) noexcept;
  Next stay(const Vec3& from, const Vec3& to, double& time) noexcept;
  bool make_leg(const Vec3& from, const Vec3& to, double time, Leg& leg) const noexcept;
  bool make_descent(const Vec3& device, bool is_unstable, CentrePath& path) const noexcept;
  CentrePath roll(const OffsetContact& contact, const Vec3& device) const noexcept;
  bool climb_down_curve(const Vec3& device, bool is_unstable, CentrePath& path) const noexcept;
  bool climb(const Vec3& way, double length, const Vec3& device, bool is_unstable, CentrePath& path) const noexcept;
  double find_stability(const Vec3& c, const Vec3& device) const noexcept;
  Vec3 find_rate(const Vec3& c, const Vec3& device, const Vec3& motion) const noexcept;
  double find_turn(const Vec3& move) const noexcept;
  bool solve(const Vec3& device, Vec3& c) const noexcept;
  bool solve_on_curve(const Vec3& device, Vec3& c) const noexcept;
  void guide(CentrePath& path) const noexcept;
  bool restore(Vec3& c) const noexcept;
  bool find_frame(const Vec3& c, ContactFrame& frame) const noexcept;
  bool cover(const CentrePath& path, double& until) noexcept;
  bool gather(const Vec3& towards) noexcept;
  bool find_event(const CentrePath& path, Event& event) noexcept;
  int find_exits(const OffsetContact& contact) noexcept;
  void note_candidates(const Vec3& from, const Vec3& to, double near) noexcept;
  bool take_event(const Event& event, const CentrePath& path) noexcept;
  std::optional<Next> end_leg(const CentrePath& path, const Event& event, bool is_whole, int released, const Vec3& device) noexcept;
  void leave_part(int i, const Exit& exit, const Vec3& way) noexcept;
  int find_rising(const OffsetContact& contact, int edge, const Vec3& way) noexcept;
  static constexpr int kMostExitWork = 16384;
  bool find_apex(Vec3& apex) const noexcept;
  bool find_cone() noexcept;
  double least_corner_way(const Vec3& pull) const noexcept;
  double time_to_corner_way(const Vec3& from, const Vec3& to, double time) noexcept;
  bool leave_rest(const Vec3& device, const Vec3& motion) noexcept;
  bool go_round(const TangentCone::Steepest& to, double wide, bool ahead) noexcept;
  bool go_over(const Vec3& way, double height) noexcept;
  template <class Go>
  bool try_way(const Vec3& device, const Vec3& motion, Go&& go) noexcept;
  Vec3 find_lift(double height) noexcept;
  bool go_straight(const Vec3& motion, double share) noexcept;
  int find_level(const OffsetContact& contact, const Exit& exit) noexcept;
  bool add_contact(const OffsetContact& contact) noexcept;
  void remove_contact(int i) noexcept;
  void note_move(const Vec3& from) noexcept;
  void note_gain(const Vec3& device, bool has_moved) noexcept;
  unsigned held_corners(const ContactTriangle& shape) const noexcept;
  bool holds_part_of(const ContactTriangle& shape, std::uint32_t triangle) const noexcept;
  bool can_touch(std::uint32_t triangle, const ContactTriangle& shape, const Vec3& p) const noexcept;
  bool is_clear(double short_by) noexcept;
  bool is_clear_here(double short_by) noexcept;
  bool is_shallow(const Vec3& device, Vec3& way) const noexcept;
  void note_multipliers(const Vec3& device) noexcept;

  const TouchGeometry& geometry_;
  std::span<const Material> materials_;
  CentrePath::Keep keep_;
  bool is_point_;
  bool has_friction_ = false;
  Rubbing rub_;
  bool holds_ = false;
  bool is_descending_ = false;
  bool has_lost_minimum_ = false;  // along the curve: it goes on by hint_
  Vec3 centre_ = Vec3::Zero();
  std::array<OffsetContact, kMostContacts> contacts_;
  int count_ = 0;
  int touching_ = 0;          // of contacts_: the first count_ hold, the others were met here
  Vec3 hint_ = Vec3::Zero();  // which way it was going
  NearTriangles near_;
  double reach_ = 0.0;                                    // of the next gathering
  std::array<int, NearTriangles::kCapacity> candidates_;  // of what is near: what may be met on a path
  int candidate_count_ = 0;
  std::array<Exit, kMostExits> exits_;
  int work_ = 0;                 // triangles looked at in this step
  int idle_ = 0;                 // events that led no nearer
  double least_distance_ = 0.0;  // to the device where it is
  TangentCone cone_;             // of the corner that the centre was last at rest in
  bool has_cone_ = false;
  Vec3 cone_from_ = Vec3::Constant(std::numeric_limits<double>::infinity());
  int corner_tries_ = 0;  // in this step,
  int passes_ = 0;        // and places passed by
  std::uint64_t step_ = 1;
  int exit_work_ = 0;  // in this step, on ways off a rest
  std::uint64_t tried_over_in_ = 0;
  std::uint64_t events_ = 0, slips_ = 0, flights_ = 0, gathered_ = 0, looked_at_ = 0;
};

// Goes to the event. A path is a little off the way itself: Newton's steps lead to where something is hit, or a border is passed.
template <class Place>
void SphereFollower::place_at_event(const CentrePath& path, Event& event, Place&& place) noexcept {
  constexpr int kMostRounds = 6;
  place(event.time);
  const bool is_hit = event.slot >= 0;
  if ((!is_hit && event.contact < 0) || (is_hit && path.is_straight()) || event.time <= 0.0) return;
  for (int i = 0; i < kMostRounds; ++i) {
    ++work_;
    double gap = 0.0;
    double rate = 0.0;
    if (is_hit) {
      const Separation at = near_.shape(event.slot).separation(centre_);
      gap = at.distance - keep_.offset;
      rate = at.normal.dot(path.slope(event.time));
    } else {
      gap = kOnBorder - event.exit.direction.dot(centre_ - event.exit.origin);
      rate = -event.exit.direction.dot(path.slope(event.time));
    }
    if (std::fabs(gap) <= (is_hit ? 0.125 * keep_.slop : 0.25 * kOnBorder) || !(rate < 0.0)) return;
    const double time = std::clamp(event.time - gap / rate, 0.0, 1.0);
    if (time == event.time) return;
    event.time = time;
    place(time);
  }
}

}  // namespace hapton
