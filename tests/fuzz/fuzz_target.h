#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <map>
#include <span>
#include <string>

#include "tests/fuzz/mutation.h"

// FUZZ_TARGET(name) { ... bytes ... }: a function that must accept any bytes without a crash. In a fuzzing build it is libFuzzer's entry
// point, one program per target; in every other build fuzz_test runs it on its corpus. FUZZ_MUTATOR(name, mutate) and FUZZ_CROSSOVER(name,
// cross) teach the fuzzer of that target a checksum, a seal or a count: without them the target's first check rejects nearly every changed
// input.
namespace hapton::fuzz {

using Target = void (*)(std::span<const std::uint8_t> bytes);

inline std::map<std::string, Target>& targets() {
  static std::map<std::string, Target> all;
  return all;
}

using Mutate = Bytes (*)(std::span<const std::uint8_t> bytes, Mutation& mutation);

inline std::map<std::string, Mutate>& mutators() {
  static std::map<std::string, Mutate> all;
  return all;
}

using Cross = Bytes (*)(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b, Mutation& mutation);

inline std::map<std::string, Cross>& crossovers() {
  static std::map<std::string, Cross> all;
  return all;
}

// Ends the program if a property does not hold: a fuzzer sees an abort as a crash.
inline void require(bool holds) {
  if (!holds) std::abort();
}

// Gives `receive` the bytes after the first, as from a stream: in pieces whose length the first byte sets, until it returns false.
template <class Receive>
void feed_in_pieces(std::span<const std::uint8_t> bytes, Receive&& receive) {
  if (bytes.empty()) return;
  const std::size_t piece = std::size_t{bytes[0]} + 1;
  bool goes_on = true;
  for (auto rest = bytes.subspan(1); goes_on && !rest.empty();) {
    const auto now = rest.first(std::min(piece, rest.size()));
    rest = rest.subspan(now.size());
    goes_on = receive(std::as_bytes(now));
  }
}

// Counts the inputs that pass the check that most random changes fail: a seal, a tag, a checksum, a count.
struct Passage {
  std::uint64_t inputs = 0;
  std::uint64_t passed = 0;
  bool has_passed = false;  // the current input

  void begin() {
    has_passed = false;
    ++inputs;
  }
  void end() { passed += has_passed ? 1 : 0; }
};

inline Passage& passage() {
  static Passage only;
  return only;
}

// Notes that the current input passed that check.
inline void note_passage() { passage().has_passed = true; }

inline void run_counted(Target target, std::span<const std::uint8_t> bytes) {
  passage().begin();
  target(bytes);
  passage().end();
}

// HAPTON_FUZZ_COUNTS=FILE: at its end a fuzzer writes to FILE how many inputs it ran and how many of them passed.
inline void write_passage() {
  if (const char* const path = std::getenv("HAPTON_FUZZ_COUNTS"))
    std::ofstream(path) << passage().inputs << ' ' << passage().passed << '\n';
}

// HAPTON_FUZZ_PLAIN=1: the fuzzer changes bytes without knowledge of checks, for a comparison.
inline bool is_plain() {
  static const bool plain = std::getenv("HAPTON_FUZZ_PLAIN") != nullptr;
  return plain;
}

// One change in eight ignores the checks, so that the checks themselves are tested as well.
inline Bytes mutate_or_break(Mutate mutate, std::span<const std::uint8_t> bytes, Mutation& mutation) {
  Bytes input(bytes.begin(), bytes.end());
  if (is_plain() || mutation.one_in(8)) return mutation.change(std::move(input), mutation.max_size());
  Bytes changed = mutate(bytes, mutation);
  return changed.size() <= mutation.max_size() ? changed : mutation.change(std::move(input), mutation.max_size());
}

}  // namespace hapton::fuzz

#ifdef HAPTON_LIBFUZZER
extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);

#define FUZZ_TARGET(name)                                                             \
  static void hapton_fuzz_##name(std::span<const std::uint8_t> bytes);                \
  extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) { \
    static const int at_exit = std::atexit(hapton::fuzz::write_passage);              \
    (void)at_exit;                                                                    \
    hapton::fuzz::run_counted(hapton_fuzz_##name, std::span(data, size));             \
    return 0;                                                                         \
  }                                                                                   \
  static void hapton_fuzz_##name(std::span<const std::uint8_t> bytes)
#define FUZZ_MUTATOR(name, mutate)                                                                                         \
  extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most, unsigned seed) {  \
    hapton::fuzz::Mutation mutation(seed, most, LLVMFuzzerMutate);                                                         \
    return mutation.put(hapton::fuzz::mutate_or_break(mutate, std::span<const std::uint8_t>(data, size), mutation), data); \
  }
#define FUZZ_CROSSOVER(name, cross)                                                                                                      \
  extern "C" std::size_t LLVMFuzzerCustomCrossOver(const std::uint8_t* a, std::size_t a_size, const std::uint8_t* b, std::size_t b_size, \
                                                   std::uint8_t* out, std::size_t most, unsigned seed) {                                 \
    hapton::fuzz::Mutation mutation(seed, most, LLVMFuzzerMutate);                                                                       \
    return mutation.put(cross(std::span(a, a_size), std::span(b, b_size), mutation), out);                                               \
  }
#else
#define FUZZ_TARGET(name)                                                                                                           \
  static void hapton_fuzz_##name(std::span<const std::uint8_t> bytes);                                                              \
  [[maybe_unused]] static const bool hapton_fuzz_listed_##name = hapton::fuzz::targets().emplace(#name, hapton_fuzz_##name).second; \
  static void hapton_fuzz_##name(std::span<const std::uint8_t> bytes)
#define FUZZ_MUTATOR(name, mutate) \
  [[maybe_unused]] static const bool hapton_fuzz_mutates_##name = hapton::fuzz::mutators().emplace(#name, mutate).second
#define FUZZ_CROSSOVER(name, cross) \
  [[maybe_unused]] static const bool hapton_fuzz_crosses_##name = hapton::fuzz::crossovers().emplace(#name, cross).second
#endif
