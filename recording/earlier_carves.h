#pragma once

#include <cstdint>
#include <variant>

#include "link/messages.h"

namespace hapton {

// Determines which carves of the first haptics process were made before the recording began. The hub requests them, so they are received
// during it. Nothing is carved without cycles, and each force states the newest carve before its step: so the first force determines it
// exactly. If a Carves message comes before it, as after the haptics node joined, all carves up to its newest count as earlier. RT: yes.
class EarlierCarves {
 public:
  // Takes each message that the hub received, in their order.
  void add(const Message& message) noexcept {
    if (is_known_) return;
    if (const auto* force = std::get_if<ForceCommand>(&message)) set_last(force->carve_serial);
    if (const auto* carves = std::get_if<Carves>(&message)) set_last(carves->newest);
  }
  // The serial of the last of them; 0: there is none, or no force and no Carves has come.
  std::uint32_t last() const noexcept { return last_; }

 private:
  void set_last(std::uint32_t serial) noexcept {
    is_known_ = true;
    last_ = serial;
  }

  bool is_known_ = false;
  std::uint32_t last_ = 0;
};

}  // namespace hapton
