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

// Damping of a surface where a rigid tool touches it: along the normal, and along the surface (viscosity).
struct ContactDamping {
  double normal_ns_per_m = 0.0;
  double along_ns_per_m = 0.0;

  bool is_on() const noexcept { return normal_ns_per_m > 0.0 || along_ns_per_m > 0.0; }
};

// Damping and viscosity at the contacts of a rigid tool. Contact i, with force f_i and unit normal n_i, has
//   D_i = -w_i C_i u_i,   w_i = f_i / sum_j f_j max(0, n_i . n_j),
// u_i the velocity of the tool past the surface at its point, C_i the damping along the normal and along the surface. So the contacts of a
// face share its damping by their forces, however many they are and whichever objects they are on; surfaces across each other share less.
// Where the sum over all contacts is larger in some direction of the shift than the largest coefficient of the materials that are touched,
// along the normal or along the surface, all of it is scaled down to that: the tool is nowhere damped more than by one surface. Neither
// part of D_i is larger than f_i, so it ends with its contact, and damping never attracts.
//
// Force and torque are F = -G v, G = sum_i J_i^T w_i C_i J_i with 6 x 6 coordinates about the grip point, symmetric and not negative. How
// the force of a face is distributed over more than three contacts is not unique and may change from step to step, and so may what is
// touched while the spring's force stays. So G is smoothed over kSmoothS: it begins at zero with contact, goes on from step to step
// whatever is touched, decays where a step knows no contact although something holds the tool, and ends with contact.
//
// Velocities: of the device past each part of the scene, smoothed (SmoothVelocity). A part that jumps, i.e. moves past the tool faster than
// kJumpMPerS, has no velocity.
// Frame: S, lengths in local units where said. RT: step yes, construction set-up only. Threads: one.
// Bound: the force of the contacts with a part, and kMostEffectForceN, each for damping and viscosity; of the torque, that times the
// farthest arm. What is left of contacts with a part that ended in the midst of others is bounded by what their force was, and decays.
// Passivity: dissipative, relative to the surfaces.
class ContactDrag {
 public:
  static constexpr Passivity kPassivity = Passivity::dissipative;
  static constexpr double kSmoothS = 0.005;
  static constexpr double kJumpMPerS = 1.0;
  static constexpr std::size_t kMostContacts = 6;  // active at once

  struct Contact {
    Vec3 arm = Vec3::Zero();  // from the grip point, local units
    Vec3 normal = Vec3::Zero();
    double force_n = 0.0;
    int part = 0;              // of the scene; 0 stands still
    std::uint32_t object = 0;  // of the part
  };
  struct Wrench {
    Vec3 force_n = Vec3::Zero();
    Vec3 torque_nm = Vec3::Zero();  // about the grip point
  };

  // Off.
  ContactDrag() = default;
  // damping: of each object of each part. radius: of the tool, local units.
  ContactDrag(std::vector<std::vector<ContactDamping>> damping, double unit_m, double radius);

  bool is_on() const noexcept { return is_on_; }
  // From the next step on. Pre: as many parts and objects as it was made with. RT: yes.
  void set_damping(const std::vector<std::vector<ContactDamping>>& damping) noexcept;
  void reset() noexcept;
  // The device's placement at this sample, and that of each part that moves; dt_s: since the sample before; if not above 0, the velocities
  // stay what they were.
  void move(const Placement& device, std::span<const Placement> parts, double dt_s) noexcept;
  // The frame S has moved: at the last sample the device was at this placement in it. That is no motion of the hand.
  void move_last(const Placement& device) noexcept { device_ = device; }
  // Contacts of this sample; at most kMostContacts count. is_held: something holds the tool, whether or not its contacts are known.
  // Returns the sum on the tool.
  Wrench step(std::span<const Contact> contacts, bool is_held) noexcept;
  // There is no contact.
  void release() noexcept { touched_.count = 0; }
  // Of the last step: on the tool, by the contacts with that part.
  Wrench on_tool_by(int part) const noexcept;

 private:
  // One of the two kinds of damping.
  struct Metric {
    Mat6 matrix = Mat6::Zero();
    double coefficient = 0.0;  // sum of its weights

    void scale(double share) noexcept;
    void blend(const Metric& before, double share) noexcept;
    Vec6 force(const Vec6& velocity, double most_n) const noexcept;
  };
  struct Touched {
    int part = 0;
    Metric normal = {};
    Metric along = {};
    double contact_n = 0.0;  // of its contacts
    // Coefficients of this sample's contacts: the largest of a material, and what they add up to at most in any direction.
    double largest = 0.0;
    double upper_bound = 0.0;
    double left = 1.0;  // of what it was when it was touched last
    Vec6 force = Vec6::Zero();
  };
  // Those that are touched, then those that were a moment ago.
  struct TouchedParts {
    std::array<Touched, kMostContacts + 2> all;
    std::size_t count = 0;

    const Touched* find(int part) const noexcept;
    Touched& at(int part) noexcept;
  };
  // How the tool moves past a part, in the frame of the part.
  struct Motion {
    bool has_damping = false;
    SmoothVelocity shift;
    SmoothVelocity turn;
    Placement part;
  };

  bool has_damping(int part) const noexcept {
    return part >= 0 && static_cast<std::size_t>(part) < motions_.size() && motions_[static_cast<std::size_t>(part)].has_damping;
  }
  void note_damping() noexcept;
  ContactDamping damping_of(const Contact& contact) const noexcept;
  Vec6 velocity_past(int part) const noexcept;
  void add(const Contact& contact, double along_n, Touched& touched) const noexcept;
  void limit(TouchedParts& now) const noexcept;
  void blend(TouchedParts& now, double share) const noexcept;

  std::vector<std::vector<ContactDamping>> damping_;
  double unit_m_ = 1.0;
  double radius_ = 0.0;
  bool is_on_ = false;
  bool is_placed_ = false;
  Placement device_;
  std::vector<Motion> motions_;  // by part
  double dt_s_ = 0.0;            // since the last step
  TouchedParts touched_;
};

}  // namespace hapton
