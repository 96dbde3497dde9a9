#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <span>
#include <string>

// FUZZ_TARGET(name) { ... bytes ... }: a function that must bear any bytes. In a fuzzing build it is libFuzzer's entry point, one program a
// target; in every other build it joins the list that fuzz_test replays its corpus with.
namespace hapton::fuzz {

using Target = void (*)(std::span<const std::uint8_t> bytes);

inline std::map<std::string, Target>& targets() {
  static std::map<std::string, Target> all;
  return all;
}

// What must hold of whatever passes: a fuzzer sees an abort as a crash.
inline void require(bool holds) {
  if (!holds) std::abort();
}

}  // namespace hapton::fuzz

#ifdef HAPTON_LIBFUZZER
#define FUZZ_TARGET(name)                                                             \
  static void hapton_fuzz_##name(std::span<const std::uint8_t> bytes);                \
  extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) { \
    hapton_fuzz_##name(std::span(data, size));                                        \
    return 0;                                                                         \
  }                                                                                   \
  static void hapton_fuzz_##name(std::span<const std::uint8_t> bytes)
#else
#define FUZZ_TARGET(name)                                                                                                           \
  static void hapton_fuzz_##name(std::span<const std::uint8_t> bytes);                                                              \
  [[maybe_unused]] static const bool hapton_fuzz_listed_##name = hapton::fuzz::targets().emplace(#name, hapton_fuzz_##name).second; \
  static void hapton_fuzz_##name(std::span<const std::uint8_t> bytes)
#endif
