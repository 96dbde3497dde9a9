#pragma once

#include <cmath>
#include <cstdint>

namespace hapton {

// Converts a time as people give it on a command line, rounded to a whole ns.
inline std::int64_t ms_to_ns(double ms) { return std::llround(1e6 * ms); }

}  // namespace hapton
