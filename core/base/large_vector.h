#pragma once

#include <cstddef>
#include <vector>

namespace hapton {

// Allocates memory for an array. A large array lies in large pages where the system has them (Linux: transparent huge pages): random
// accesses miss the TLB less often, and filling the array takes fewer page faults. RT: set-up only. Error: std::bad_alloc.
void* allocate_large(std::size_t bytes, std::size_t alignment);
void free_large(void* memory, std::size_t bytes, std::size_t alignment) noexcept;

template <class T>
struct LargePageAllocator {
  using value_type = T;

  LargePageAllocator() = default;
  template <class Other>
  LargePageAllocator(const LargePageAllocator<Other>&) noexcept {}

  T* allocate(std::size_t count) { return static_cast<T*>(allocate_large(count * sizeof(T), alignof(T))); }
  void deallocate(T* memory, std::size_t count) noexcept { free_large(memory, count * sizeof(T), alignof(T)); }
  friend bool operator==(const LargePageAllocator&, const LargePageAllocator&) { return true; }
};

// For the arrays of meshes and trees, which may have millions of entries.
template <class T>
using LargeVector = std::vector<T, LargePageAllocator<T>>;

}  // namespace hapton
