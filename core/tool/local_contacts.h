#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/tool/least_motion.h"
#include "core/tool/placement.h"

namespace hapton {

// Coefficients of Coulomb friction of a surface; the dynamic one is at most the static one.
struct CoulombFriction {
  double friction_static = 0.0;
  double friction_dynamic = 0.0;
};

// Data of a contact for friction: the arm (its point on the tool from the grip point, along the scene's axes) and the friction of the
// surface; and for surfaces that move, the part and where the contact was found.
struct LocalContact {
  Vec3 arm = Vec3::Zero();
  CoulombFriction friction;
  int part = 0;                // index of the part of the scene that it is on; 0 does not move
  std::uint32_t object = 0;    // index within the part
  Vec3 point = Vec3::Zero();   // on the surface, when the contact was found
  Vec3 anchor = Vec3::Zero();  // `point` in the frame of the part, at the pose the part should have had then
  double found_least = 0.0;    // the bound's `least` when the contact was found
};

// The `least` of a contact's bound when the parts are at `parts`: found_least plus how far the contact's point has moved along the normal.
// The turn of the plane is neglected, as of second order. Part 0: unchanged. parts: as in LocalContacts::follow. RT: yes.
double moved_least(const MotionBound& bound, const LocalContact& contact, std::span<const Placement> parts) noexcept;

// What a rigid tool touches or is about to touch: a local set in the sense of the FDH paper, which the slow task finds and the fast task
// computes with. Each pair of features that is a local minimum of the distance keeps the tool on its side of a plane through its contact
// (Ortega, Redon & Coquillart 2007, section 5: constraint-based force between two steps of the pose). No heap memory. Frame: local units.
struct LocalContacts {
  static constexpr std::size_t kMax = 64;

  // Motions (shift, then turn about the grip point) from `proxy` with row . motion >= least keep the tool outside.
  std::array<MotionBound, kMax> bounds = {};
  std::array<LocalContact, kMax> contacts = {};  // of each bound
  std::size_t count = 0;
  Placement proxy;                         // collision-free pose of the tool, from which motions are measured
  Mat6 inverse_root = Mat6::Identity();    // as MotionEnergy::inverse_root, with the contacts' curvature
  Vec6 plain_inverse_root = Vec6::Ones();  // the same, of the coupling alone
  Vec6 stiffness = Vec6::Ones();           // of the coupling, divided by its linear stiffness
  double tolerance = 0.0;                  // by which a bound may be missed
  bool is_blocked = true;                  // there is no force
  bool is_held = false;                    // too many pairs were near: the tool stays where it is

  // Adds a contact; of more than kMax, keeps those with the least room (largest `least`).
  void add(const MotionBound& bound, const LocalContact& contact = {}) noexcept;

  // After the parts have moved since the contacts were found: raises or lowers the bounds on moving parts (moved_least). parts: the pose
  // that each moving part should have, part 1 first. RT: yes.
  void follow(std::span<const Placement> parts) noexcept;

  // The pose at which the bounds hold the tool while the device is at `device`: the device's pose if no bound stops the tool. RT: yes, up
  // to four calls of find_least_motion with at most kMax bounds.
  Placement constrain(const Placement& device) const noexcept { return solve(device).at; }

  // True if this motion from `proxy` violates no bound.
  bool allows(const Vec6& motion) const noexcept;
  // The motion from `proxy` nearest to this one that the bounds allow, in the metric of the coupling alone: the motion itself if they allow
  // it, and zero if they contradict each other. RT: as constrain.
  Vec6 project(const Vec6& motion) const noexcept;

  // The result of constrain() as `at`, and the bounds that hold the tool there. motion: from `proxy`. multipliers: as in LeastMotion, local
  // units; times the coupling's stiffness, forces. No bound is active if the device is free, or if no solution was found (at = proxy).
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
