#pragma once

#include <cstdint>

#include "core/base/button_bit.h"
#include "devices/device.h"

namespace hapton {

// The dead man's switch: what the user must hold so that there can be force. A device that senses a hand must report that it is held (a
// device without such a sensor always reports so). A button can be required as well; no requirement can be removed. RT: yes.
class DeadMansSwitch {
 public:
  // Buttons are counted from 1 to 32; any other number changes nothing.
  void require_button(int button) noexcept { buttons_ |= button_bit(button); }
  bool is_held(const DeviceSample& sample) const noexcept { return sample.is_held && (sample.buttons & buttons_) == buttons_; }
  std::uint32_t required_buttons() const noexcept { return buttons_; }

 private:
  std::uint32_t buttons_ = 0;
};

}  // namespace hapton
