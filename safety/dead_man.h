#pragma once

#include <cstdint>

#include "devices/device.h"

namespace hapton {

// The dead man's switch: what has to be held for force to be there. Presence holds wherever a device can tell (one that cannot says it is
// held); a button may be asked for on top. It can be asked for, never waived.
// RT: yes.
class DeadMan {
 public:
  static constexpr int kMostButtons = 32;

  // button: 0 .. 31, lowest bit first; anything else changes nothing.
  void require_button(int button) noexcept {
    if (button >= 0 && button < kMostButtons) buttons_ |= std::uint32_t{1} << button;
  }
  bool is_held(const DeviceSample& sample) const noexcept { return sample.is_held && (sample.buttons & buttons_) == buttons_; }
  std::uint32_t required_buttons() const noexcept { return buttons_; }

 private:
  std::uint32_t buttons_ = 0;
};

}  // namespace hapton
