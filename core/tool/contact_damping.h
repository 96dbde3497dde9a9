#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/effects/effect_sample.h"
#include "core/effects/smooth_velocity.h"
#include "core/tool/least_motion.h"
#include "core/tool/placement.h"

namespace hapton {

// Damping coefficients of a surface that a rigid tool touches: along the normal, and tangential (viscosity).
struct DampingCoefficients {
  double normal_ns_per_m = 0.0;
  double along_ns_per_m = 0.0;

  bool is_on() const noexcept { return normal_ns_per_m > 0.0 || along_ns_per_m > 0.0; }
};

// Damping and viscosity at the contacts of a rigid tool. Contact i, with force f_i and unit normal n_i, adds the force
//   D_i = -w_i C_i u_i,   w_i = f_i / sum_j f_j max(0, n_i . n_j),
// where u_i is the velocity of the tool relative to the surface at the contact point, and C_i is the damping along the normal and along the
// surface. The weights w_i distribute the damping of one face over its contacts in proportion to their forces, whatever their number and
// objects. Contacts share damping only as far as their normals agree: those with orthogonal normals are each damped in full. If the sum
// over all contacts exceeds, in some direction of translation, the largest coefficient of the touched materials, the sum is scaled down to
// that coefficient: the tool is damped no more than by one surface. For each contact, the normal and the tangential component of D_i are
// each at most f_i, so damping vanishes with the contact force and never attracts.
//
// Force and torque are F = -G v, where v is the twist of the tool about the grip point and G = sum_i J_i^T w_i C_i J_i is a 6 x 6 matrix,
// symmetric and positive semidefinite. The distribution of a force over more than three contacts of a face is not unique and may change
// from step to step, as may the set of contacts, while the spring force stays the same. Therefore G is low-pass filtered with the time
// constant kSmoothS: it starts at zero when contact begins, decays in steps in which the tool is in contact although no contact is known
// (for example because LocalContacts::solve finds no solution), and is dropped when contact ends.
//
// A part of the scene consists of surfaces that move together: part 0 is everything at rest, and the others are the moving parts.
// Velocities: of the device relative to each part, filtered (SmoothVelocity). A jump of a part, i.e. a motion of it
// relative to the tool faster than kJumpMPerS, does not count as velocity.
// Frame: S; SI units, but local units in placements and where said. RT: all but construction, which is set-up only. Threads: one.
// Bound: for damping and for viscosity, for each part, the smaller of the sum of its contact forces and kMaxEffectForceN; the torque is at
// most this force times the longest arm. If a part is no longer touched while others are, its last contact forces count, and decay as its
// damping does.
// Passivity: dissipative, relative to the surfaces.
class ContactDamping {
 public:
  static constexpr Passivity kPassivity = Passivity::dissipative;
  static constexpr double kSmoothS = 0.005;       // time constant of the filter of G; a free choice
  static constexpr double kJumpMPerS = 1.0;       // four times the fastest surface (kMaxSurfaceSpeed); a free choice
  static constexpr std::size_t kMaxContacts = 6;  // active at once

  struct Contact {
    Vec3 arm = Vec3::Zero();     // from the grip point, local units
    Vec3 normal = Vec3::Zero();  // unit, from the scene to the tool
    double force_n = 0.0;
    int part = 0;              // index of the part of the scene; 0 is static
    std::uint32_t object = 0;  // index within the part
  };
  struct Wrench {
    Vec3 force_n = Vec3::Zero();
    Vec3 torque_nm = Vec3::Zero();  // about the grip point
  };

  // No damping.
  ContactDamping() = default;
  // damping: by part, then by object. unit_m: local unit. radius: largest distance of a point of the tool from the grip point, local units.
  ContactDamping(std::vector<std::vector<DampingCoefficients>> damping, double unit_m, double radius);

  bool is_on() const noexcept { return is_on_; }
  // Takes effect in the next step. Pre: same numbers of parts and objects as in the constructor. RT: yes.
  void set_damping(const std::vector<std::vector<DampingCoefficients>>& damping) noexcept;
  void reset() noexcept;
  // Takes the placements of the device and of each moving part (part 1 first) at this sample. dt_s: time since the previous sample; if it
  // is not above 0, the velocities do not change.
  void move(const Placement& device, std::span<const Placement> parts, double dt_s) noexcept;
  // Frame S has moved. device: the last sample's placement of the device in the new S; so the change is not taken as motion of the hand.
  void move_last(const Placement& device) noexcept { device_ = device; }
  // contacts: of this sample; only the first kMaxContacts count. is_held: the tool is in contact, whether or not its contacts are known.
  // Returns the force and torque on the tool.
  Wrench step(std::span<const Contact> contacts, bool is_held) noexcept;
  // Contact has ended: drops the filtered damping.
  void release() noexcept { touched_parts_.count = 0; }
  // The share of the last step's wrench that the contacts with this part exert on the tool.
  Wrench wrench_of_part(int part) const noexcept;

 private:
  // The share in G of one kind of damping (normal or tangential) at one part.
  struct DampingMatrix {
    Mat6 matrix = Mat6::Zero();
    double coefficient = 0.0;  // sum of weight times damping coefficient over its contacts

    void scale(double share) noexcept;
    void blend(const DampingMatrix& before, double share) noexcept;
    Vec6 force(const Vec6& velocity, double most_n) const noexcept;
  };
  struct TouchedPart {
    int part = 0;
    DampingMatrix normal = {};
    DampingMatrix along = {};
    double contact_n = 0.0;    // sum of its contact forces
    double largest = 0.0;      // largest damping coefficient of the materials touched in this step
    double upper_bound = 0.0;  // of the damping in any direction: sum of weight times coefficient
    double remaining = 1.0;    // share of its damping that has not decayed since it was last touched
    Vec6 force = Vec6::Zero();
  };
  // The parts touched in this step, then those touched shortly before: room for at least two of them, even if each contact of this step is
  // on a part of its own.
  struct TouchedParts {
    std::array<TouchedPart, kMaxContacts + 2> all;
    std::size_t count = 0;

    const TouchedPart* find(int part) const noexcept;
    TouchedPart& find_or_add(int part) noexcept;
  };
  // Velocity of the tool relative to a part, in the frame of the part.
  struct Motion {
    bool has_damping = false;
    SmoothVelocity shift;
    SmoothVelocity turn;
    Placement part;
  };

  bool has_damping(int part) const noexcept {
    return part >= 0 && static_cast<std::size_t>(part) < motions_.size() && motions_[static_cast<std::size_t>(part)].has_damping;
  }
  void update_damping() noexcept;
  DampingCoefficients damping_of(const Contact& contact) const noexcept;
  Vec6 relative_velocity(int part) const noexcept;
  void add(const Contact& contact, double normal_load_n, TouchedPart& touched) const noexcept;
  void limit(TouchedParts& touched_now) const noexcept;
  void blend(TouchedParts& touched_now, double share) const noexcept;

  std::vector<std::vector<DampingCoefficients>> damping_;
  double unit_m_ = 1.0;
  double radius_ = 0.0;
  bool is_on_ = false;
  bool is_placed_ = false;
  Placement device_;
  std::vector<Motion> motions_;  // by part
  double dt_s_ = 0.0;            // since the last step
  TouchedParts touched_parts_;
};

}  // namespace hapton
