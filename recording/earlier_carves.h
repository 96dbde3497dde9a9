#pragma once

#include <cstdint>
#include <map>
#include <variant>

#include "link/messages.h"

namespace hapton {

// Determines which carves of the first process that sends carves were made before the recording began. The hub requests them, so they are
// received during it. Nothing is carved without cycles, and each force states the newest carve before its step: so the first force of that
// process determines it exactly. If its first Carves message comes before a force, as after the haptics node joined, all carves up to its
// newest count as earlier. RT: no.
class EarlierCarves {
 public:
  // Takes each datagram that the hub received, in their order.
  void add(const Datagram& datagram) {
    if (is_known_) return;
    const std::uint64_t sender = datagram.header.sender;
    if (const auto* force = std::get_if<ForceCommand>(&datagram.message)) newest_at_first_force_.try_emplace(sender, force->carve_serial);
    const auto* carves = std::get_if<Carves>(&datagram.message);
    if (carves == nullptr) return;
    const auto found = newest_at_first_force_.find(sender);
    last_ = found != newest_at_first_force_.end() ? found->second : carves->newest;
    is_known_ = true;
    newest_at_first_force_.clear();
  }
  // The serial of the last of them; 0: there is none, or no Carves message has come.
  std::uint32_t last() const noexcept { return last_; }

 private:
  std::map<std::uint64_t, std::uint32_t> newest_at_first_force_;  // by sender; empty once last_ is known
  bool is_known_ = false;
  std::uint32_t last_ = 0;
};

}  // namespace hapton
