#pragma once

#include "core/tool/local_contacts.h"

namespace hapton {

// Coulomb friction of a rigid tool: where the contacts let the tool slide, friction holds it back.
//
// The tool slides along one direction at a time, from where it is to where the contacts alone would hold it. Along that slide s the
// coupling pulls with the power of its force, and friction takes the power of each contact's: sum of friction * multiplier * length of the
// contact point's tangential motion. The tool stays while the static one is not less; otherwise it slides until the dynamic one balances
// the pull. It sticks again once the device no longer pulls onward: the share of each of many contacts is not unique, and from step to step
// the power of the same slide differs by some per cent. Exact for a slide that keeps its direction (maximum dissipation along it); a turn about a single contact's normal meets no
// friction, as at a point.
//
// The pose is followed towards a goal that lies off the device by what friction takes: held by the contacts alone, it comes to rest where
// friction holds the tool. So the slow task needs to know nothing of friction.
// Frame: local units. RT: yes. Threads: one.
class ToolFriction {
 public:
  // The tool is put there: it slides from there on.
  void reset(const Placement& at) noexcept;
  bool is_placed() const noexcept { return is_placed_; }
  void forget() noexcept { is_placed_ = false; }

  // The pose came to rest here, where friction was to hold it: the next slide begins here.
  void move_to(const Placement& at) noexcept { at_ = at; }

  struct Step {
    Placement at;    // where the tool is, with friction
    Placement goal;  // what the pose follows
    bool sticks = false;
  };
  // Where the device is at `device` and `local` holds the tool. Without contact: at the device.
  Step step(const LocalContacts& local, const Placement& device) noexcept;

 private:
  Placement at_;
  Placement device_;  // of the step before
  bool is_placed_ = false;
  bool sticks_ = false;
  bool slides_ = false;  // has slid, and the device has pulled onward since
};

}  // namespace hapton
