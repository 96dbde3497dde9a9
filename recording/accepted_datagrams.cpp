#include "recording/accepted_datagrams.h"

#include <type_traits>
#include <variant>

namespace hapton {
namespace {

// True for those messages used from recordings that only a haptics node may send (HubPeers).
bool is_of_haptics(const Message& message) {
  return std::visit(
      [](const auto& one) {
        using One = std::remove_cvref_t<decltype(one)>;
        return std::is_same_v<One, ForceCommand> || std::is_same_v<One, HapticsSetup> || std::is_same_v<One, MaterialState> ||
               std::is_same_v<One, ObjectMove> || std::is_same_v<One, Carves> || std::is_same_v<One, ObjectShape> ||
               std::is_same_v<One, ShapeStart>;
      },
      message);
}

}  // namespace

bool AcceptedDatagrams::accept(const SessionEntry& entry, const Datagram& datagram) noexcept {
  // A Hello belongs to no session.
  if (const auto* hello = std::get_if<Hello>(&datagram.message)) {
    if (hello->role == NodeRole::haptics) {
      joining_haptics_ = entry.peer;
    } else if (joining_haptics_ == entry.peer) {
      joining_haptics_.reset();
    }
    return true;
  }
  if (session_ != 0 && datagram.header.session != session_) return false;
  if (entry.kind == SessionEntry::Kind::sent) {
    const auto* welcome = std::get_if<Welcome>(&datagram.message);
    const bool has_joined = welcome != nullptr && welcome->accepted && joining_haptics_ == entry.peer;
    if (has_joined || std::holds_alternative<DeviceState>(datagram.message)) haptics_address_ = entry.peer;
    return true;
  }
  return !haptics_address_ || *haptics_address_ == entry.peer || !is_of_haptics(datagram.message);
}

}  // namespace hapton
