#pragma once

#include <cmath>
#include <cstdint>

namespace hapton {

// As people give times on a command line.
inline std::int64_t ms_to_ns(double ms) { return std::llround(1e6 * ms); }

}  // namespace hapton
