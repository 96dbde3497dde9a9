#pragma once

#include <span>

#include "core/tool/contact_cones.h"
#include "core/tool/local_contacts.h"

namespace hapton {

// Coulomb friction of a rigid tool: where the contacts of a step hold it (ContactCones), from where it was.
//
// Static friction acts while the tool has not slid since it stuck. It sticks again once no contact slides and the device no longer pulls
// onward, not when static friction would suffice again: the distribution of the force over many contacts is not unique, and a tool that is
// turned slowly would stick again and again. A rotation about the normal of a single contact has no friction, as at a point.
//
// The slow task moves the proxy to where friction holds the tool, so it does not depend on friction, and contacts are found where the tool
// is. (If it followed the device displaced by the friction instead, a tool that pivots about a corner would swing: that force holds it at
// one orientation only.)
//
// Where parts of the scene move, the tool slides and sticks in the frame of the part whose friction acts most on it: that part carries it
// along. Its slide on any other part is taken as that past the first one.
// Frame: local units. RT: yes. Threads: one.
class ToolFriction {
 public:
  // Places the tool: its next slide begins here.
  void reset(const Placement& at) noexcept;
  bool is_placed() const noexcept { return is_placed_; }
  void forget() noexcept {
    is_placed_ = false;
    cones_.forget();
  }

  // The proxy came to rest here under friction: the next slide begins here.
  void move_to(const Placement& at) noexcept { at_ = at; }

  struct Step {
    Placement at;                      // pose of the tool, with friction
    Placement goal;                    // of the slow task: the same, or the device without contact
    LocalContacts::Solution solution;  // without friction
  };
  // Where the device is at `device` and `local` holds the tool. Without contact: at the device. parts: as LocalContacts::follow has them.
  Step step(const LocalContacts& local, const Placement& device, std::span<const Placement> parts = {}) noexcept;

 private:
  void carry_along(std::span<const Placement> parts) noexcept;
  void choose_carrier(const LocalContacts& local, const LocalContacts::Solution& solution, std::span<const Placement> parts) noexcept;

  ContactCones cones_;
  Placement at_;
  Placement device_;  // of the previous step
  bool is_placed_ = false;
  bool sticks_ = false;
  bool slides_ = false;   // it has slid, and the device has pulled onward since
  int carrier_ = 0;       // the part that carries the tool along; 0: one that stands still
  Placement carrier_at_;  // in the last step
};

}  // namespace hapton
