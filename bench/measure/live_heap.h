#pragma once

#include <cstddef>

namespace hapton {

// Heap in use by the whole process, bytes, with the allocator's overhead: two readings give the size of what was made in between. RT: no.
std::size_t read_live_heap_bytes();

}  // namespace hapton
