#pragma once

#include <cstdint>
#include <functional>

#include "core/base/result.h"
#include "link/hub_client.h"
#include "runtime/clock.h"
#include "tools/live/marker_line.h"

namespace hapton {

// While should_continue returns true, marks each change of the line and prints each reply. Then waits for the replies that are missing, up
// to LineMarker::kReplyTimeoutNs for each marker. Returns how many changes were too short to be seen; 0 if the driver does not count
// changes. Error, one line: the line cannot be read any more. Pre: client has joined. RT: no. Threads: one.
Result<std::uint64_t> mark_changes(DigitalLine& line, LineMarker& marker, HubClient& client, const Clock& clock,
                                   const std::function<bool()>& should_continue);

}  // namespace hapton
