#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "link/endpoint.h"

namespace hapton {

// Where io_node listens unless told otherwise.
constexpr std::uint16_t kDefaultHubPort = 4950;

// "host:port", "host", "1.2.3.4:port", "[2001:db8::1]:port" or a bare IPv6 address; without a port default_port is meant.
// Host names are resolved, IPv4 first. RT: set-up only. Error: one line that names the text and what is wrong with it.
Result<Address> parse_address(std::string_view text, std::uint16_t default_port = kDefaultHubPort);

// "127.0.0.1:4950" or "[::1]:4950": what parse_address reads back.
std::string to_string(const Address& address);

// A UDP socket bound to `bind_address` ("0.0.0.0:4950", "[::]:4950", "127.0.0.1:0"; port 0 lets the system choose). An IPv6 socket
// speaks to IPv4 peers as well, unless the host forbids it.
// filters_floods: of a hub, whose datagrams are all sealed: FloodFilter keeps unknown peers out in the kernel while they flood it.
// Receiving waits by ppoll to absolute CLOCK_MONOTONIC deadlines; a refusal by a peer that is not there (ICMP) is ignored.
// RT: opening set-up only; send and receive as Endpoint says. Threads: one at a time.
// Error: one line: bad address, port in use, no permission.
Result<std::unique_ptr<Endpoint>> open_udp_endpoint(std::string_view bind_address, bool filters_floods = false);

}  // namespace hapton
