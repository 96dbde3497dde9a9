#pragma once

#include <memory>
#include <string_view>

#include "core/base/result.h"
#include "link/address.h"
#include "link/endpoint.h"

namespace hapton {

// Opens a UDP socket at `bind_address` ("0.0.0.0:4950", "[::]:4950", "127.0.0.1:0"; port 0 lets the system choose).
// An IPv6 socket also reaches IPv4 peers, unless the host forbids it. filters_floods: for a hub, whose datagrams
// are all sealed: FloodFilter drops datagrams of unknown peers in the kernel during a flood. Receiving waits with
// ppoll until absolute CLOCK_MONOTONIC deadlines; ICMP errors (no peer at the port) are ignored. RT: opening is
// set-up only; send and receive as in Endpoint. Threads: one at a time. Error, one line: bad address, port in use,
// no permission.
Result<std::unique_ptr<Endpoint>> open_udp_endpoint(std::string_view bind_address, bool filters_floods = false);

}  // namespace hapton
