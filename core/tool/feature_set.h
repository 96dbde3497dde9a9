#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/tool/feature_pair.h"

namespace hapton {

// A set of pairs of features, identified by their numbers. Open addressing; clear takes constant time. RT: all but construction.
class FeatureSet {
 public:
  // Pre: no more than `most` are inserted between two clears.
  explicit FeatureSet(std::size_t most) : slots_(std::bit_ceil(2 * most)) {}

  void clear() noexcept { ++stamp_; }
  // False if the pair was already in the set.
  bool insert(const FeaturePair& pair) noexcept;
  bool has(const FeaturePair& pair) const noexcept { return slots_[find(key_of(pair))].stamp == stamp_; }

 private:
  struct Key {
    std::uint32_t tool;
    std::uint32_t scene;
    std::uint32_t features;
    bool operator==(const Key&) const = default;
  };
  struct Slot {
    Key key{};
    std::uint64_t stamp = 0;
  };

  static Key key_of(const FeaturePair& pair) noexcept {
    const auto part = [](auto x) { return static_cast<std::uint32_t>(x); };
    return {pair.tool_triangle, pair.scene_triangle, part(pair.kind) << 8 | part(pair.tool_corner) << 4 | part(pair.scene_corner)};
  }
  // The slot that holds the key, or a free one.
  std::size_t find(const Key& key) const noexcept;

  std::vector<Slot> slots_;
  std::uint64_t stamp_ = 1;
};

inline std::size_t FeatureSet::find(const Key& key) const noexcept {
  std::uint64_t hash = (std::uint64_t{key.tool} << 32 | key.scene) * 0x9E3779B97F4A7C15U;
  hash = (hash ^ hash >> 29 ^ key.features) * 0xBF58476D1CE4E5B9U;
  const std::size_t mask = slots_.size() - 1;
  std::size_t at = (hash >> 32) & mask;
  while (slots_[at].stamp == stamp_ && !(slots_[at].key == key)) at = (at + 1) & mask;
  return at;
}

inline bool FeatureSet::insert(const FeaturePair& pair) noexcept {
  const Key key = key_of(pair);
  Slot& slot = slots_[find(key)];
  if (slot.stamp == stamp_) return false;
  slot = {key, stamp_};
  return true;
}

}  // namespace hapton
