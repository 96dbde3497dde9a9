#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <random>
#include <span>
#include <utility>
#include <vector>

namespace hapton::fuzz {

using Bytes = std::vector<std::uint8_t>;

// One change of an input: the random choices for it, and the plain changes of bytes that it is made of (libFuzzer's own in a fuzzer). The
// same seed and plain changes give the same input.
class Mutation {
 public:
  // Changes `size` bytes, with room for `most` of them, and returns their new number: LLVMFuzzerMutate, or its stand-in in tests.
  using ChangeBytes = std::function<std::size_t(std::uint8_t* data, std::size_t size, std::size_t most)>;

  Mutation(std::uint64_t seed, std::size_t most, ChangeBytes change_bytes)
      : random_(seed), max_size_(most), change_bytes_(std::move(change_bytes)) {}

  // The largest size that an input may have, in bytes.
  std::size_t max_size() const { return max_size_; }
  // 0 .. n - 1. Pre: n > 0.
  std::size_t below(std::size_t n) { return random_() % n; }
  bool one_in(std::size_t n) { return below(n) == 0; }
  std::uint64_t number() { return random_(); }

  Bytes change(Bytes bytes, std::size_t most) {
    const std::size_t size = bytes.size();
    bytes.resize(std::max(most, size));
    bytes.resize(change_bytes_(bytes.data(), size, bytes.size()));
    return bytes;
  }

  // Changes the bytes, but not their number.
  Bytes change_in_place(Bytes bytes) {
    const std::size_t size = bytes.size();
    if (size == 0) return bytes;
    bytes = change(std::move(bytes), size);
    bytes.resize(size);
    return bytes;
  }

  // A number near a limit, which readers may handle wrongly, or any random number.
  std::uint64_t odd_number() {
    const std::uint64_t ones = ~std::uint64_t{0};
    switch (below(6)) {
      case 0:
        return below(8);
      case 1:
        return ones - below(8);
      case 2:
        return (std::uint64_t{1} << below(64)) - below(2);
      case 3:
        return ones >> below(64);
      default:
        return random_();
    }
  }

  // The bits of a double that readers may handle wrongly (zero, infinity, NaN, subnormal, huge, one), or any random bits.
  std::uint64_t odd_double_bits() {
    constexpr std::uint64_t kOddBits[] = {0,
                                          0x8000000000000000,
                                          0x7FF0000000000000,
                                          0xFFF0000000000000,
                                          0x7FF8000000000001,
                                          1,
                                          0x7FEFFFFFFFFFFFFF,
                                          0x41CDCD6500000000,  // 1e9: the largest that the link accepts
                                          0x41CDCD6500000001,
                                          0x3FF0000000000000,
                                          0xBFF0000000000000};
    return one_in(3) ? random_() : kOddBits[below(std::size(kOddBits))];
  }

  // Removes one item, repeats one, or swaps two. Pre: `items` is not empty.
  template <class Item>
  void change_order(std::vector<Item>& items) {
    const std::size_t at = below(items.size());
    const std::size_t to = below(items.size());
    switch (below(3)) {
      case 0:
        items.erase(items.begin() + static_cast<std::ptrdiff_t>(at));
        return;
      case 1: {
        Item copy = items[at];
        items.insert(items.begin() + static_cast<std::ptrdiff_t>(to), std::move(copy));
        return;
      }
      default:
        std::swap(items[at], items[to]);
    }
  }

  // The beginning of one list and the end of the other.
  template <class Item>
  std::vector<Item> cross(const std::vector<Item>& a, const std::vector<Item>& b) {
    const auto until = static_cast<std::ptrdiff_t>(below(a.size() + 1));
    std::vector<Item> both(a.begin(), a.begin() + until);
    both.insert(both.end(), b.begin() + static_cast<std::ptrdiff_t>(below(b.size() + 1)), b.end());
    return both;
  }

  // Copies the input to where libFuzzer expects it, and returns its size. Pre: `into` has room for max_size().
  std::size_t put(const Bytes& bytes, std::uint8_t* into) const {
    const std::size_t size = std::min(bytes.size(), max_size_);
    std::copy_n(bytes.begin(), size, into);
    return size;
  }

 private:
  std::mt19937_64 random_;
  std::size_t max_size_;
  ChangeBytes change_bytes_;
};

}  // namespace hapton::fuzz
