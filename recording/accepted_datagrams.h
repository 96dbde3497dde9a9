#pragma once

#include <cstdint>
#include <optional>

#include "link/codec.h"
#include "link/session_entry.h"

namespace hapton {

// Leaves out datagrams of a recording that its hub certainly dropped: those of an earlier session of the hub, where the same numbers mean
// other samples, and what only a haptics node may send, from another address than that of the hub's haptics node. Other datagrams that the
// hub dropped (duplicates, those of unknown peers) pass. The address to which the hub sends the device's samples is that of the haptics
// node, so reading may begin anywhere, and entries may be missing. RT: yes. Threads: one.
class AcceptedDatagrams {
 public:
  // session: SessionHeader::session; 0: not known.
  explicit AcceptedDatagrams(std::uint64_t session) noexcept : session_(session) {}

  // False: the datagram is left out. entry: the next one of the recording, received or sent, with this datagram.
  bool accept(const SessionEntry& entry, const Datagram& datagram) noexcept;

 private:
  std::uint64_t session_;
  std::optional<Address> joining_haptics_;  // the last haptics node that has said Hello
  std::optional<Address> haptics_address_;  // none: not known
};

}  // namespace hapton
