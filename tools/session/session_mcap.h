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
  std::uint64_t messages = 0;  // these and all others
};

// Writes a recording as MCAP to its end, or to the damage: reader.problem() says which. Topics, each with the Protobuf schema of our own
// messages: /hapton/cycle (every sample), state, force, probe, view, setup, move (of objects that programs move), shape (of objects that
// programs deform), event (faults, markers, what was not recorded). log_time is the time since 1970 at which the hub recorded it,
// publish_time of cycles and states the time of the sample. names: of the scene's objects. RT: no. Error: one line with the path.
Result<McapCounts> write_mcap(SessionReader& reader, const std::filesystem::path& path, std::span<const ObjectName> names = {});

}  // namespace hapton
