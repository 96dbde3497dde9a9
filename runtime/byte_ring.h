#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <vector>

namespace hapton {

// A queue of records of any length from a real-time thread to another thread. A record that does not fit is dropped and counted: the
// writer never waits. RT: push yes, wait-free; construction set-up only (it allocates and touches all memory). Threads: one pushes, one
// drains.
class ByteRing {
 public:
  // Pre: capacity is a power of two, at least 64.
  explicit ByteRing(std::size_t capacity) : bytes_(capacity) {}

  // Appends one record made of two parts. False if it was dropped.
  bool push(std::span<const std::byte> head, std::span<const std::byte> body) noexcept {
    const std::size_t size = head.size() + body.size();
    const std::size_t end = end_.load(std::memory_order_relaxed);
    const std::size_t bytes_to_end = bytes_.size() - offset_of(end);
    // A record is contiguous: one that does not fit before the end of the memory is written at the beginning of the memory.
    const std::size_t skipped = kPrefix + size <= bytes_to_end ? 0 : bytes_to_end;
    const std::size_t record_bytes = skipped + padded(kPrefix + size);
    if (end + record_bytes - known_begin_ > bytes_.size()) known_begin_ = begin_.load(std::memory_order_acquire);
    if (end + record_bytes - known_begin_ > bytes_.size() || size >= kSkip) {
      dropped_.fetch_add(1, std::memory_order_relaxed);
      return false;
    }
    if (skipped > 0) put_size(offset_of(end), kSkip);
    std::byte* to = bytes_.data() + offset_of(end + skipped);
    put_size(offset_of(end + skipped), static_cast<std::uint32_t>(size));
    if (!head.empty()) std::memcpy(to + kPrefix, head.data(), head.size());
    if (!body.empty()) std::memcpy(to + kPrefix + head.size(), body.data(), body.size());
    end_.store(end + record_bytes, std::memory_order_release);
    return true;
  }

  // Calls visit(span) for every record and frees its memory. Returns the number of records. A span is valid during its call only.
  template <class Visit>
  std::size_t drain(Visit&& visit) {
    std::size_t count = 0;
    std::size_t begin = begin_.load(std::memory_order_relaxed);
    const std::size_t end = end_.load(std::memory_order_acquire);
    while (begin != end) {
      std::uint32_t size = 0;
      std::memcpy(&size, bytes_.data() + offset_of(begin), sizeof size);
      if (size == kSkip) {
        begin += bytes_.size() - offset_of(begin);
        continue;
      }
      visit(std::span<const std::byte>(bytes_).subspan(offset_of(begin) + kPrefix, size));
      begin += padded(kPrefix + size);
      begin_.store(begin, std::memory_order_release);
      ++count;
    }
    begin_.store(begin, std::memory_order_release);
    return count;
  }

  std::uint64_t dropped() const noexcept { return dropped_.load(std::memory_order_relaxed); }

 private:
  static constexpr std::size_t kPrefix = 8;  // bytes before a record: its size, padded so that every record begins at a multiple of 8
  static constexpr std::uint32_t kSkip = std::numeric_limits<std::uint32_t>::max();  // as a size: the next record is at the beginning

  static std::size_t padded(std::size_t size) noexcept { return (size + kPrefix - 1) / kPrefix * kPrefix; }
  std::size_t offset_of(std::size_t position) const noexcept { return position & (bytes_.size() - 1); }
  void put_size(std::size_t at, std::uint32_t size) noexcept { std::memcpy(bytes_.data() + at, &size, sizeof size); }

  std::vector<std::byte> bytes_;
  alignas(64) std::atomic<std::size_t> begin_{0};
  alignas(64) std::atomic<std::size_t> end_{0};
  std::size_t known_begin_ = 0;  // the writer's copy of begin_, so that it seldom reads the other thread's cache line
  std::atomic<std::uint64_t> dropped_{0};
};

}  // namespace hapton
