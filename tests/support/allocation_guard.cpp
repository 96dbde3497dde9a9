#include "tests/support/allocation_guard.h"

#include <cerrno>
#include <cstddef>

#if defined(__has_feature)
#define HAPTON_CLANG_SANITIZER(name) __has_feature(name)
#else
#define HAPTON_CLANG_SANITIZER(name) 0
#endif

namespace {

// Plain data: to count the first allocation of a thread, nothing has to be initialised, which could itself allocate.
thread_local std::uint64_t allocations __attribute__((tls_model("initial-exec"))) = 0;

}  // namespace

#if defined(__SANITIZE_THREAD__) || HAPTON_CLANG_SANITIZER(thread_sanitizer)

constexpr bool kCanCount = false;

#elif defined(__SANITIZE_ADDRESS__) || HAPTON_CLANG_SANITIZER(address_sanitizer)

// The sanitizer replaces malloc; it calls these hooks for each allocation.
constexpr bool kCanCount = true;
extern "C" int __sanitizer_install_malloc_and_free_hooks(void (*on_malloc)(const volatile void*, std::size_t),
                                                         void (*on_free)(const volatile void*));
static const int installed =
    __sanitizer_install_malloc_and_free_hooks([](const volatile void*, std::size_t) { ++allocations; }, [](const volatile void*) {});

#else

// glibc's allocation functions, under their other names. The malloc below replaces glibc's; operator new calls it, too.
constexpr bool kCanCount = true;
extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* old, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);

void* malloc(std::size_t size) {
  ++allocations;
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  ++allocations;
  return __libc_calloc(count, size);
}
void* realloc(void* old, std::size_t size) {
  ++allocations;
  return __libc_realloc(old, size);
}
void* memalign(std::size_t alignment, std::size_t size) {
  ++allocations;
  return __libc_memalign(alignment, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  ++allocations;
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** result, std::size_t alignment, std::size_t size) {
  ++allocations;
  *result = __libc_memalign(alignment, size);
  return *result != nullptr ? 0 : ENOMEM;
}
}

#endif

namespace hapton {

AllocationGuard::AllocationGuard() : start_(allocations) {}

std::uint64_t AllocationGuard::count() const { return allocations - start_; }

bool AllocationGuard::is_available() { return kCanCount; }

}  // namespace hapton
