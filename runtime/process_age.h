#pragma once

#include <optional>
#include <string>

namespace hapton {

// Seconds since this process was started, to a hundredth: what a person who started it has waited, loading of libraries included. Empty if
// the system does not say. stat_file: where it does, as proc(5) says. RT: no.
std::optional<double> read_process_age_s(const std::string& stat_file = "/proc/self/stat");

}  // namespace hapton
