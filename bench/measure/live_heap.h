#pragma once

#include <cstddef>

namespace hapton {

// Bytes of heap in use by the whole program, including the allocator's overhead. Differences give the size of a structure.
std::size_t read_live_heap_bytes();

}  // namespace hapton
