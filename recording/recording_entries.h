#pragma once

#include "core/base/result.h"
#include "link/codec.h"
#include "link/session_reader.h"
#include "recording/accepted_datagrams.h"

namespace hapton {

// Calls visit(entry, its decoded datagram or null) for all entries that can be read; SessionReader::problem() then says whether the file
// was complete. Null: no datagram, an unreadable one, or left out (AcceptedDatagrams). Ends with the first error that a visit returns. RT:
// no.
template <class Visit>
Result<void> for_each_entry(SessionReader& reader, Visit&& visit) {
  Codec codec;
  AcceptedDatagrams accepted(reader.header().session);
  SessionEntry entry;
  while (reader.next(entry)) {
    Datagram datagram;
    const bool is_readable = !entry.datagram.empty() && codec.decode(entry.datagram, datagram) == DecodeStatus::ok;
    const bool is_accepted = is_readable && accepted.accept(entry, datagram);
    if (const Result<void> done = visit(entry, is_accepted ? &datagram : nullptr); !done) return done;
  }
  return {};
}

// Error: the recording is truncated or damaged; the entries before that were read.
inline Result<void> check_end(const SessionReader& reader) {
  if (reader.problem().empty()) return {};
  return fail("{}", reader.problem());
}

}  // namespace hapton
