#include "bench/measure/live_heap.h"

#include <malloc.h>

namespace hapton {

std::size_t read_live_heap_bytes() {
  const struct mallinfo2 heap = mallinfo2();
  return heap.uordblks + heap.hblkhd;
}

}  // namespace hapton
