#pragma once

#include <memory>
#include <string_view>

#include "core/base/result.h"
#include "link/address.h"
#include "link/endpoint.h"

namespace hapton {

// A UDP socket bound to `bind_address` ("0.0.0.0:4950", "[::]:4950", "127.0.0.1:0"; port 0 lets the system choose). An IPv6 socket
// speaks to IPv4 peers as well, unless the host forbids it.
// filters_floods: of a hub, whose datagrams are all sealed: FloodFilter keeps unknown peers out in the kernel while they flood it.
// Receiving waits by ppoll to absolute CLOCK_MONOTONIC deadlines; a rejection by a peer that is not there (ICMP) is ignored.
// RT: opening set-up only; send and receive as Endpoint says. Threads: one at a time.
// Error: one line: bad address, port in use, no permission.
Result<std::unique_ptr<Endpoint>> open_udp_endpoint(std::string_view bind_address, bool filters_floods = false);

}  // namespace hapton
