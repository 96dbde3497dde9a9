#pragma once

#include <cstdint>
#include <string>

#include "link/relay_endpoint.h"
#include "tools/command_line.h"

namespace hapton {

// hapton relay --hub HOST:PORT [--listen ADDRESS:PORT] [faults | --script FILE]: a bad network between the nodes and their hub.
void add_relay_command(CommandLine app, int& exit_code);

// What the relay has done: a table for people, and the same as JSON (schema hapton.relay/1). RT: no.
std::string relay_text(const RelayEndpoint& relay, std::uint64_t seed);
std::string relay_json(const RelayEndpoint& relay, std::uint64_t seed, double seconds);

}  // namespace hapton
