#pragma once

#include <cstdint>

namespace hapton {

// Names a CLOCK_MONOTONIC: the same number in every process that reads this clock, another one after a restart of the host and on every
// other host. From the kernel's boot identity and the time namespace; a random number where neither can be read. RT: set-up only.
std::uint64_t find_host_id();

}  // namespace hapton
