#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/tool/least_motion.h"
#include "core/tool/placement.h"

namespace hapton {

// Coulomb friction of a surface; the dynamic one is not above the static one.
struct CoulombFriction {
  double friction_static = 0.0;
  double friction_dynamic = 0.0;
};

// The data of a contact that friction needs: its point on the tool from the grip point, along the scene's axes, and the surface there. And
// what is needed where the surface moves.
struct LocalContact {
  Vec3 arm = Vec3::Zero();
  CoulombFriction friction;
  int part = 0;                // of the scene that it is on; 0 stands still
  std::uint32_t object = 0;    // of the part
  Vec3 point = Vec3::Zero();   // on the surface, when the contact was found
  Vec3 anchor = Vec3::Zero();  // the same in the frame of the part, where that should have been then
  double found_least = 0.0;    // of the bound, when the contact was found
};

// The bound of a contact with a part that moves, once the parts are at `parts`: raised or lowered by how far its point has moved along the
// normal. That the plane turns is of second order. parts: as LocalContacts::follow has them. RT: yes.
double moved_least(const MotionBound& bound, const LocalContact& contact, std::span<const Placement> parts) noexcept;

// What a rigid tool touches or is about to touch: a local set in the sense of the FDH paper, which the slow task finds and the fast task
// computes with. Each pair of features that is a local minimum of the distance keeps the tool on its side of a plane through its contact
// (Ortega, Redon & Coquillart 2007, section 5: constraint-based force between two steps of the pose). Plain memory. Frame: local units.
struct LocalContacts {
  static constexpr std::size_t kMax = 64;

  // Motions (shift, then turn about the grip point) from `proxy` with row . motion >= least keep the tool outside.
  std::array<MotionBound, kMax> bounds = {};
  std::array<LocalContact, kMax> contacts = {};  // of each bound
  std::size_t count = 0;
  Placement proxy;                         // where the tool was found to be free
  Mat6 inverse_root = Mat6::Identity();    // as in ToolProxy: what contacts do as their levers turn included
  Vec6 plain_inverse_root = Vec6::Ones();  // the coupling's alone
  Vec6 stiffness = Vec6::Ones();           // of the coupling, over its linear one
  double tolerance = 0.0;                  // of a bound
  bool is_blocked = true;                  // there is no force
  bool is_held = false;                    // too much was near: the tool stays where it is

  // Keeps the kMax with the least room.
  void add(const MotionBound& bound, const LocalContact& contact = {}) noexcept;

  // The parts have moved since the contacts were found: raises or lowers the bounds of those that move (moved_least). parts: where each
  // should be, without the one that stands still. RT: yes.
  void follow(std::span<const Placement> parts) noexcept;

  // Where the bounds hold the tool while the device is there: the device itself where none does. RT: yes, at most kMax bounds a round of
  // find_least_motion.
  Placement constrain(const Placement& device) const noexcept { return solve(device).at; }

  // No bound is violated by this motion from `proxy`.
  bool allows(const Vec6& motion) const noexcept;
  // The motion from `proxy` nearest to this one that the bounds allow, in the metric of the coupling alone: the motion itself if they allow
  // it, and zero if they contradict each other. RT: as constrain.
  Vec6 project(const Vec6& motion) const noexcept;

  // The same, with what holds the tool there. The motion is from `proxy`; multipliers as LeastMotion has them, in local units: times the
  // coupling's stiffness they are forces. None is active where the device is free, and where the tool stays for want of a solution.
  struct Solution {
    Placement at;
    Vec6 motion = Vec6::Zero();
    std::array<int, 6> active = {-1, -1, -1, -1, -1, -1};
    Vec6 multipliers = Vec6::Zero();
    int active_count = 0;
  };
  Solution solve(const Placement& device) const noexcept;
};

}  // namespace hapton
