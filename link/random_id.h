#pragma once

#include <cstdint>

namespace hapton {

// A random number from the system, never 0: Header::sender of a process, Header::session of a hub. RT: set-up only.
std::uint64_t make_random_id();

}  // namespace hapton
