#pragma once

#include <cstdint>

namespace hapton {

// Identifies a CLOCK_MONOTONIC: the same number in every process that reads this clock, a different one after a reboot and on every other
// host. Computed from the kernel's boot id and the time namespace; a random number if the boot id cannot be read. RT: set-up only.
std::uint64_t find_host_id();

}  // namespace hapton
