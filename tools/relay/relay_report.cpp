#include "tools/relay/relay_report.h"

#include <fmt/core.h>

#include <array>

namespace hapton {
namespace {

struct NamedCount {
  const char* name;
  std::uint64_t RelayCounts::*count;
};

constexpr std::array kCounts = {
    NamedCount{"received", &RelayCounts::received},
    NamedCount{"forwarded", &RelayCounts::forwarded},
    NamedCount{"lost", &RelayCounts::lost},
    NamedCount{"lost_in_burst", &RelayCounts::lost_in_burst},
    NamedCount{"partitioned", &RelayCounts::partitioned},
    NamedCount{"held_back", &RelayCounts::held_back},
    NamedCount{"duplicated", &RelayCounts::duplicated},
    NamedCount{"corrupted", &RelayCounts::corrupted},
    NamedCount{"overflowed", &RelayCounts::overflowed},
    NamedCount{"rejected", &RelayCounts::rejected},
    NamedCount{"send_failures", &RelayCounts::send_failures},
};

}  // namespace

nlohmann::ordered_json relay_counts_json(const RelayCounts& counts) {
  nlohmann::ordered_json json;
  for (const NamedCount& named : kCounts) json[named.name] = counts.*named.count;
  return json;
}

std::string relay_text(const RelayEndpoint& relay, std::uint64_t seed) {
  std::string text =
      fmt::format("{} nodes seen, seed {}\n{:<14} {:>12} {:>12}\n", relay.clients(), seed, "datagrams", "to hub", "to nodes");
  for (const NamedCount& named : kCounts) {
    text += fmt::format("{:<14} {:>12} {:>12}\n", named.name, relay.to_hub().*named.count, relay.to_nodes().*named.count);
  }
  return text;
}

std::string relay_json(const RelayEndpoint& relay, std::uint64_t seed, double seconds) {
  const nlohmann::ordered_json json = {{"schema", "hapton.relay/2"},
                                       {"seed", seed},
                                       {"seconds", seconds},
                                       {"nodes_seen", relay.clients()},
                                       {"to_hub", relay_counts_json(relay.to_hub())},
                                       {"to_nodes", relay_counts_json(relay.to_nodes())}};
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace hapton
