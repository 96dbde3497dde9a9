#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace hapton {

// A queue of values of one type from one thread to another, in order. A full ring rejects values: the writer never
// waits. A slot is overwritten with a default value when it is read, so no secret remains. Pre: Item is
// copyable, and its default value contains no secret. RT: push and pop yes, wait-free. Threads: one pushes,
// one pops.
template <class Item, std::size_t kCapacity>
class HandoffRing {
 public:
  // False when it is full.
  bool push(const Item& item) noexcept {
    const std::size_t end = end_.load(std::memory_order_relaxed);
    if (end - begin_.load(std::memory_order_acquire) == kCapacity) return false;
    items_[end % kCapacity] = item;
    end_.store(end + 1, std::memory_order_release);
    return true;
  }

  // False when it is empty.
  bool pop(Item& item) noexcept {
    const std::size_t begin = begin_.load(std::memory_order_relaxed);
    if (begin == end_.load(std::memory_order_acquire)) return false;
    item = items_[begin % kCapacity];
    items_[begin % kCapacity] = Item();
    begin_.store(begin + 1, std::memory_order_release);
    return true;
  }

 private:
  std::array<Item, kCapacity> items_ = {};
  alignas(64) std::atomic<std::size_t> begin_{0};
  alignas(64) std::atomic<std::size_t> end_{0};
};

}  // namespace hapton
