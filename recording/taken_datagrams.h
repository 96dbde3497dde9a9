#pragma once

#include <cstdint>
#include <optional>

#include "link/codec.h"
#include "link/session_entry.h"

namespace hapton {

// Leaves out datagrams of a recording that its hub certainly dropped: those of an earlier session of the hub, with other samples of the
// same numbers, and what only a haptics node sends from another address than that of the hub's haptics node. Others that the hub dropped
// (duplicates, those of unknown peers) pass. Knows the haptics node by where the hub sends the device's states, so that reading may begin
// anywhere, and entries may be missing. RT: yes. Threads: one.
class TakenDatagrams {
 public:
  // session: SessionHeader::session; 0: not known.
  explicit TakenDatagrams(std::uint64_t session) noexcept : session_(session) {}

  // Of the next entry, received or sent.
  bool take(const SessionEntry& entry, const Datagram& datagram) noexcept;

 private:
  std::uint64_t session_;
  std::optional<Address> joining_;  // the last haptics node that has said Hello
  std::optional<Address> haptics_;  // none: not known
};

}  // namespace hapton
