#pragma once

#include <optional>

namespace hapton {

// Seconds since this process was started, to a hundredth: what a person who started it has waited, loading of libraries included. Empty if
// the system does not say. RT: no.
std::optional<double> read_process_age_s();

}  // namespace hapton
