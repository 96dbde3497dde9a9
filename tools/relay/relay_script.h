#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "link/fault_schedule.h"

namespace hapton {

// The content of a relay script.
struct RelayScript {
  FaultSchedule schedule;
  std::optional<std::uint64_t> seed;
};

// Reads a script for `hapton relay` (TOML; docs/faults.md has the keys): consecutive [[phase]] tables, each with its seconds and its
// faults, in both directions unless [phase.to_hub] or [phase.to_nodes] differs; `seed` and `repeat` at the top. Error: one line with file
// and line: not TOML, an unknown key, a value out of range, no phase (without a line). RT: set-up only.
Result<RelayScript> read_relay_script(const std::filesystem::path& path);
Result<RelayScript> parse_relay_script(std::string_view text, const std::string& name);

}  // namespace hapton
