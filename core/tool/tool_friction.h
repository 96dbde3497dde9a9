#pragma once

#include <span>

#include "core/tool/local_contacts.h"

namespace hapton {

// Coulomb friction of a rigid tool.
//
// The tool slides along one direction at a time, from its pose to the pose that the frictionless contacts would allow. Along that slide s
// the coupling does work, and friction dissipates at each contact friction * multiplier * length of the contact point's tangential motion.
// The tool sticks while the sum with the static coefficients is not less than the work; otherwise it slides until the dynamic one balances
// the work. It sticks again once the device no longer pulls onward, not when static friction would suffice again: the multipliers of many
// contacts are not unique, and from step to step the dissipation of the same slide differs by some per cent. Exact for a slide that keeps
// its direction (maximum dissipation along it); a rotation about the normal of a single contact has no friction, as at a point.
//
// The slow task moves the proxy towards a goal pose, which differs from the device's pose by the effect of friction: with frictionless
// contacts, the proxy comes to rest where friction holds the tool. So the slow task does not depend on friction.
//
// Where parts of the scene move, the tool slides and sticks in the frame of the part whose friction acts most on it: that part carries it
// along. Its slide on any other part is taken as that past the first one.
// Frame: local units. RT: yes. Threads: one.
class ToolFriction {
 public:
  // Places the tool: its next slide begins here.
  void reset(const Placement& at) noexcept;
  bool is_placed() const noexcept { return is_placed_; }
  void forget() noexcept { is_placed_ = false; }

  // The proxy came to rest here under friction: the next slide begins here.
  void move_to(const Placement& at) noexcept { at_ = at; }

  struct Step {
    Placement at;    // pose of the tool, with friction
    Placement goal;  // goal pose of the slow task
    bool sticks = false;
    LocalContacts::Held held;  // without friction
  };
  // Where the device is at `device` and `local` holds the tool. Without contact: at the device. parts: as LocalContacts::follow has them.
  Step step(const LocalContacts& local, const Placement& device, std::span<const Placement> parts = {}) noexcept;

 private:
  void carry_along(std::span<const Placement> parts) noexcept;
  void choose_carrier(const LocalContacts& local, const LocalContacts::Held& held, std::span<const Placement> parts) noexcept;

  Placement at_;
  Placement device_;  // of the previous step
  bool is_placed_ = false;
  bool sticks_ = false;
  bool slides_ = false;   // it has slid, and the device has pulled onward since
  int carrier_ = 0;       // the part that carries the tool along; 0: one that stands still
  Placement carrier_at_;  // in the last step
};

}  // namespace hapton
