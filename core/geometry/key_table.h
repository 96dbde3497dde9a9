#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/math/types.h"

namespace hapton {

// A hash table from keys of a few words to numbers: open addressing, at most half full; nothing is ever removed. RT: set-up only.
template <std::size_t kWords>
class KeyTable {
 public:
  using Key = std::array<std::uint64_t, kWords>;

  // count: the number of keys for which there is room before the table grows.
  explicit KeyTable(std::size_t count) : keys_(std::bit_ceil(2 * count + 2)), numbers_(keys_.size(), kNone) {}

  // The number of the key; a new key is added and gets `number`. Pre: `number` is not 2^32 - 1.
  std::uint32_t find_or_add(const Key& key, std::uint32_t number) {
    std::size_t at = place_of(key);
    if (numbers_[at] != kNone) return numbers_[at];
    if (2 * ++count_ > keys_.size()) {
      grow();
      at = place_of(key);
    }
    keys_[at] = key;
    return numbers_[at] = number;
  }
  bool contains(const Key& key) const { return numbers_[place_of(key)] != kNone; }

 private:
  static constexpr std::uint32_t kNone = 0xFFFFFFFFU;

  static std::uint64_t hash_of(const Key& key) {
    std::uint64_t h = 0x9E3779B97F4A7C15ULL;
    for (const std::uint64_t word : key) {
      h ^= word;
      h *= 0xFF51AFD7ED558CCDULL;
      h ^= h >> 32;
    }
    return h;
  }
  std::size_t place_of(const Key& key) const {
    std::size_t at = hash_of(key) & (keys_.size() - 1);
    while (numbers_[at] != kNone && keys_[at] != key) at = (at + 1) & (keys_.size() - 1);
    return at;
  }
  void grow() {
    const std::vector<Key> keys = std::exchange(keys_, std::vector<Key>(2 * keys_.size()));
    const std::vector<std::uint32_t> numbers = std::exchange(numbers_, std::vector<std::uint32_t>(keys_.size(), kNone));
    for (std::size_t i = 0; i < keys.size(); ++i) {
      if (numbers[i] == kNone) continue;
      const std::size_t at = place_of(keys[i]);
      keys_[at] = keys[i];
      numbers_[at] = numbers[i];
    }
  }

  std::vector<Key> keys_;
  std::vector<std::uint32_t> numbers_;
  std::size_t count_ = 0;
};

// The bits of the three components, the same for 0 and -0. Pre: no component is NaN.
inline std::array<std::uint64_t, 3> words_of(const Vec3& v) {
  return {std::bit_cast<std::uint64_t>(v.x() + 0.0), std::bit_cast<std::uint64_t>(v.y() + 0.0), std::bit_cast<std::uint64_t>(v.z() + 0.0)};
}

}  // namespace hapton
