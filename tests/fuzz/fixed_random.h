#pragma once

#include <sodium.h>

#include <algorithm>
#include <cstdint>

#include "link/key_schedule.h"

namespace hapton::fuzz {

// Replaces libsodium's random numbers by a fixed sequence, the same in every run and after every restart(): a crash can be repeated.
class FixedRandom {
 public:
  // False when the system lacks what libsodium needs.
  static bool install() {
    static const bool is_installed = [] {
      static randombytes_implementation fixed = {[] { return "fuzz"; }, next, nullptr, nullptr, fill, nullptr};
      randombytes_set_implementation(&fixed);
      return seal::start_crypto().has_value();
    }();
    return is_installed;
  }
  static void restart() { state() = 1; }

 private:
  static std::uint64_t& state() {
    static std::uint64_t only = 1;
    return only;
  }
  static std::uint32_t next() {
    state() = state() * 6364136223846793005U + 1442695040888963407U;
    return static_cast<std::uint32_t>(state() >> 32);
  }
  static void fill(void* into, std::size_t size) {
    auto* const out = static_cast<std::uint8_t*>(into);
    std::generate(out, out + size, [] { return static_cast<std::uint8_t>(next()); });
  }
};

}  // namespace hapton::fuzz
