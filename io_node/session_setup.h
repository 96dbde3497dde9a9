#pragma once

#include <cstdint>
#include <filesystem>

#include "core/base/result.h"
#include "io_node/io_options.h"
#include "link/session_entry.h"
#include "runtime/clock.h"

namespace hapton {

// What stands in front of a recording made with these options. RT: set-up only.
SessionHeader make_session_header(const IoOptions& options, std::uint64_t session, const Clock& clock);

// Where flight records go: what --flight says, else OUT/flight, else the state folder; of one of several devices a folder of its own there.
// Empty: nowhere. RT: set-up only.
std::filesystem::path find_flight_folder(const IoOptions& options);

}  // namespace hapton
