#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "link/relay_endpoint.h"

namespace hapton {

// The relay's counters for each direction: a table for people, and the same as JSON (schema hapton.relay/2). seed: the seed of its random
// losses and delays. seconds: how long it ran. RT: no.
std::string relay_text(const RelayEndpoint& relay, std::uint64_t seed);
std::string relay_json(const RelayEndpoint& relay, std::uint64_t seed, double seconds);
// The counters of one direction, each with the name that both reports give it.
nlohmann::ordered_json relay_counts_json(const RelayCounts& counts);

}  // namespace hapton
