#pragma once

#include "core/base/result.h"
#include "link/codec.h"
#include "link/session_reader.h"
#include "recording/taken_datagrams.h"

namespace hapton {

// Calls visit(entry, its decoded datagram or null) for all entries that can be read; SessionReader::problem() then says whether the file
// was complete. Null: no datagram, an unreadable one, or left out (TakenDatagrams). Ends with the first error that a visit returns. RT: no.
template <class Visit>
Result<void> for_each_entry(SessionReader& reader, Visit&& visit) {
  Codec codec;
  TakenDatagrams taken(reader.header().session);
  SessionEntry entry;
  while (reader.next(entry)) {
    Datagram datagram;
    const bool is_readable = !entry.datagram.empty() && codec.decode(entry.datagram, datagram) == DecodeStatus::ok;
    const bool is_taken = is_readable && taken.take(entry, datagram);
    if (const Result<void> done = visit(entry, is_taken ? &datagram : nullptr); !done) return done;
  }
  return {};
}

// Error: the recording is truncated or damaged; the entries before that were read.
inline Result<void> check_end(const SessionReader& reader) {
  if (reader.problem().empty()) return {};
  return fail("{}", reader.problem());
}

}  // namespace hapton
