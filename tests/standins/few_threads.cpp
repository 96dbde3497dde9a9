// Preloaded into PROGRAM, this library makes pthread_create fail after COUNT threads, if HAPTON_STANDIN_THREADS is "PROGRAM:COUNT".
// The system's own limit (RLIMIT_NPROC) does not help: it also counts the user's other threads, and root is exempt from it.
#include <dlfcn.h>
#include <errno.h>
#include <pthread.h>

#include <atomic>
#include <cstdlib>
#include <string_view>

extern "C" int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*run)(void*), void* argument) noexcept {
  static std::atomic<int> started = 0;
  static const auto create = reinterpret_cast<decltype(&pthread_create)>(::dlsym(RTLD_NEXT, "pthread_create"));
  const char* limit = std::getenv("HAPTON_STANDIN_THREADS");
  const std::string_view text = limit == nullptr ? "" : limit;
  const std::size_t colon = text.find(':');
  if (colon != text.npos && text.substr(0, colon) == program_invocation_short_name) {
    if (started.fetch_add(1) >= std::atoi(limit + colon + 1)) return EAGAIN;
  }
  return create(thread, attributes, run, argument);
}
