#pragma once

#include <cstddef>

namespace hapton {

// Heap in use by the whole process, bytes, including the allocator's overhead. Two readings give the size of what was made between. RT: no.
std::size_t read_live_heap_bytes();

}  // namespace hapton
