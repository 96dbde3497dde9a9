#pragma once

#include <cstdint>

#include "core/base/button_bit.h"
#include "devices/device.h"

namespace hapton {

// The dead man's switch: what must be held for force. A device that senses a hand must report it as held (one that cannot always reports
// held). A button can be required as well; no requirement can be removed.
// RT: yes.
class DeadMansSwitch {
 public:
  // Counted from 1; a number that no button has changes nothing.
  void require_button(int button) noexcept { buttons_ |= button_bit(button); }
  bool is_held(const DeviceSample& sample) const noexcept { return sample.is_held && (sample.buttons & buttons_) == buttons_; }
  std::uint32_t required_buttons() const noexcept { return buttons_; }

 private:
  std::uint32_t buttons_ = 0;
};

}  // namespace hapton
