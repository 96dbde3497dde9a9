#pragma once

#include <cstddef>

namespace hapton {

// Bytes of heap in use by the whole program, with what the allocator keeps beside each block. Differences tell what a structure holds.
std::size_t read_live_heap_bytes();

}  // namespace hapton
