#pragma once

#include <span>

#include "core/tool/contact_cones.h"
#include "core/tool/local_contacts.h"

namespace hapton {

// Coulomb friction of a rigid tool: from the tool's last pose, finds the pose at which the contacts of a step hold it (ContactCones).
//
// Static friction acts from when the tool sticks until it slides. It sticks again once no contact slides and the device no longer pulls it
// onward, not as soon as static friction would suffice: the distribution of the force over many contacts is not unique, and a tool that is
// turned slowly would stick again and again. Rotation about the normal of a single contact is without friction, as at a point contact.
//
// The slow task moves the proxy to the pose at which friction holds the tool (Step::goal), so ToolProxy need not know friction, and
// contacts are found where the tool is. (If the proxy followed the device displaced by the friction instead, a tool that pivots about a
// corner would swing: that force holds it at one orientation only.)
//
// If parts of the scene move, the tool slides and sticks in the frame of the part with the largest friction on it (the carrier), which
// carries it along. Its slide on every other part is taken to be its slide relative to the carrier.
// Frame: local units. RT: yes. Threads: one.
class ToolFriction {
 public:
  // Places the tool: its next slide begins at this pose.
  void reset(const Placement& at) noexcept;
  bool is_placed() const noexcept { return is_placed_; }
  void forget() noexcept {
    is_placed_ = false;
    cones_.forget();
  }

  // Call when the proxy has moved to Step::goal and ended at this pose: the next slide begins there.
  void move_to(const Placement& at) noexcept { at_ = at; }

  struct Step {
    Placement at;                      // pose of the tool, with friction
    Placement goal;                    // for the slow task's proxy: `at`, or the device if the tool is free
    LocalContacts::Solution solution;  // the contacts' solution without friction
  };
  // parts: as in LocalContacts::follow. Without contact the pose is `device`; but a tool that was held turns by 0.1 rad a call at most.
  Step step(const LocalContacts& local, const Placement& device, std::span<const Placement> parts = {}) noexcept;

  // Writes what the contacts of the last step exert; returns their number. The sum is that of the coupling, except where the turn is
  // limited to 0.1 rad or bounds are still violated. Pre: Step::solution has active contacts; local: as in step().
  std::size_t list_forces(const LocalContacts& local, std::span<ContactForce, ContactCones::kMax> forces) const noexcept {
    return cones_.list_forces(local, forces);
  }

 private:
  void carry_along(std::span<const Placement> parts) noexcept;
  void choose_carrier(const LocalContacts& local, const LocalContacts::Solution& solution, std::span<const Placement> parts) noexcept;

  ContactCones cones_;
  Placement at_;
  Placement device_;  // of the previous step
  bool is_placed_ = false;
  bool sticks_ = false;
  bool slides_ = false;   // the tool slides, or has slid and the device has pulled it onward since
  int carrier_ = 0;       // number of the part that carries the tool along; 0: what stands still
  Placement carrier_at_;  // of the carrier in the last step
};

}  // namespace hapton
