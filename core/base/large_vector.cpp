#include "core/base/large_vector.h"

#include <new>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace hapton {
namespace {

constexpr std::size_t kLargePage = std::size_t{1} << 21;  // x86-64 and aarch64 with pages of 4 KiB
constexpr std::size_t kMinLargeBytes = 2 * kLargePage;    // up to half of a smaller block would stay in small pages

std::align_val_t alignment_of(std::size_t bytes, std::size_t alignment) {
  return std::align_val_t{bytes >= kMinLargeBytes ? kLargePage : alignment};
}

// Fills the pages at once, then sets MADV_NOHUGEPAGE: otherwise khugepaged might collapse small pages later and stall readers.
void use_large_pages(void* memory, std::size_t bytes) {
#if defined(__linux__) && defined(MADV_POPULATE_WRITE)
  if (::madvise(memory, bytes, MADV_HUGEPAGE) != 0) return;
  (void)::madvise(memory, bytes, MADV_POPULATE_WRITE);  // where it fails, pages are filled when they are first written, as small ones
  (void)::madvise(memory, bytes, MADV_NOHUGEPAGE);
#else
  (void)memory;
  (void)bytes;
#endif
}

}  // namespace

void* allocate_large(std::size_t bytes, std::size_t alignment) {
  void* const memory = ::operator new(bytes, alignment_of(bytes, alignment));
  // Whole large pages only: a last, partly used one would waste memory.
  if (bytes >= kMinLargeBytes) use_large_pages(memory, bytes / kLargePage * kLargePage);
  return memory;
}

void free_large(void* memory, std::size_t bytes, std::size_t alignment) noexcept {
  ::operator delete(memory, alignment_of(bytes, alignment));
}

}  // namespace hapton
