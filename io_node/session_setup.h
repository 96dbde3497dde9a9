#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "io_node/io_options.h"
#include "link/session_entry.h"
#include "runtime/clock.h"
#include "watchdog/heartbeat_page.h"

namespace hapton {

// Makes the header of a recording with these options. RT: set-up only.
SessionHeader make_session_header(const IoOptions& options, std::uint64_t session, const Clock& clock);

// The folder of flight records: --flight, otherwise OUT/flight, otherwise the state folder; with several devices a folder for each in it.
// Empty: none. RT: set-up only.
std::filesystem::path find_flight_folder(const IoOptions& options);

// The warning for a device whose force the watchdog process cannot release, as its page names no means to do so; empty if the page names
// one, or if the device has no motors. RT: no.
std::string describe_missing_means(const HeartbeatPage& page, std::string_view device);

// The warning after a recording in which this many samples of the device are missing; empty if none is. RT: no.
std::string describe_lost_samples(const IoOptions& options, std::uint64_t lost);

}  // namespace hapton
