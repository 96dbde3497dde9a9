#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "core/base/result.h"
#include "link/session_reader.h"
#include "scene/object_names.h"

namespace hapton {

struct McapCounts {
  std::uint64_t cycles = 0;
  std::uint64_t messages = 0;  // of all topics, /hapton/cycle included
};

// Writes a recording as MCAP up to its end or the damage; reader.problem() says which. Topics, each with its schema in Protobuf:
// /hapton/cycle (every sample), state, force, probe, view, setup, move and shape (of objects that programs move or deform), carve,
// object_pose, material, event (faults, markers, what was lost or not recorded). log_time is the time since 1970 at which the hub recorded
// it; publish_time that of the sample for cycle, state and probe, otherwise the same. names: of the objects. RT: no. Error: one line.
Result<McapCounts> write_mcap(SessionReader& reader, const std::filesystem::path& path, std::span<const ObjectName> names = {});

}  // namespace hapton
