#pragma once

#include <cstdint>

namespace hapton {

// Counts what the calling thread takes from the heap, by operator new or malloc, from its construction on.
// In thread-sanitized builds it cannot count: is_available() is false, and a test that needs it skips.
class AllocationGuard {
 public:
  AllocationGuard();

  std::uint64_t count() const;

  static bool is_available();

 private:
  std::uint64_t start_;
};

}  // namespace hapton
