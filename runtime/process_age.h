#pragma once

#include <optional>
#include <string>

namespace hapton {

// Seconds since this process was started, to a hundredth: how long the person who started it has waited, loading of libraries included.
// Empty if the system does not provide it. stat_file: the file that provides it, in the format of proc(5). RT: no.
std::optional<double> read_process_age_s(const std::string& stat_file = "/proc/self/stat");

}  // namespace hapton
