#pragma once

#include "core/base/result.h"
#include "link/codec.h"
#include "link/session_reader.h"

namespace hapton {

// Calls visit(entry, datagram or null) for all entries that can be read; the reader then knows whether that was all. A visitor that returns
// an error ends it. RT: no.
template <class Visit>
Result<void> for_each_entry(SessionReader& reader, Visit&& visit) {
  Codec codec;
  SessionEntry entry;
  while (reader.next(entry)) {
    Datagram datagram;
    const bool is_readable = !entry.datagram.empty() && codec.decode(entry.datagram, datagram) == DecodeStatus::ok;
    if (const Result<void> done = visit(entry, is_readable ? &datagram : nullptr); !done) return done;
  }
  return {};
}

// A truncated recording is an error.
inline Result<void> check_end(const SessionReader& reader) {
  if (reader.problem().empty()) return {};
  return fail("{}", reader.problem());
}

}  // namespace hapton
