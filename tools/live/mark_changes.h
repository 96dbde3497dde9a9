#pragma once

#include <cstdint>
#include <functional>

#include "core/base/result.h"
#include "link/hub_client.h"
#include "runtime/clock.h"
#include "tools/live/marker_line.h"

namespace hapton {

// Marks the changes of a line while goes_on, and prints each reply. Then no marker waits any more: the replies that are missing are waited
// for, up to LineMarker::kPatienceNs. Returns how many changes were too short to be seen; 0 where the driver does not count. Error, one
// line: the line is gone. Pre: client has joined. RT: no. Threads: one.
Result<std::uint64_t> mark_changes(DigitalLine& line, LineMarker& marker, HubClient& client, const Clock& clock,
                                   const std::function<bool()>& goes_on);

}  // namespace hapton
