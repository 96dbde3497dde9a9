#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace hapton {

// Hands the newest value from one writing thread to one reading thread; older values that were not read in time are lost.
// Three slots: the writer owns one, the reader one, the third changes hands, so that neither ever waits for the other or sees half a
// value, however large it is. T may own heap memory (it is assigned into a slot, and the reader works in place).
// RT: take yes, wait-free; publish yes if assigning T is real-time safe. Threads: one writer, one reader.
// Source: the triple buffer of graphics hardware, as a lock-free algorithm.
template <class T>
class Mailbox {
 public:
  Mailbox() = default;
  explicit Mailbox(const T& initial) : slots_{Slot{initial}, Slot{initial}, Slot{initial}} {}

  // Writer: makes `value` the newest.
  void publish(const T& value) {
    slots_[writing_].value = value;
    publish_draft();
  }

  // Writer: a slot to fill in place (it holds an older value), then publish_draft().
  T& draft() noexcept { return slots_[writing_].value; }
  void publish_draft() noexcept {
    writing_ = shared_.exchange(static_cast<std::uint8_t>(writing_ | kFresh), std::memory_order_acq_rel) & kIndex;
  }

  // Reader: takes over the newest value; true if one was published since the last call.
  bool take() noexcept {
    if ((shared_.load(std::memory_order_relaxed) & kFresh) == 0) {
      return false;
    }
    reading_ = shared_.exchange(reading_, std::memory_order_acq_rel) & kIndex;
    return true;
  }

  // Reader: the value taken last; before the first take(), the initial value. The writer does not change it before the next take().
  const T& value() const noexcept { return slots_[reading_].value; }
  T& value() noexcept { return slots_[reading_].value; }

 private:
  static constexpr std::uint8_t kFresh = 4;
  static constexpr std::uint8_t kIndex = 3;

  // Slots lie in separate cache lines, so that the two threads do not share one.
  struct alignas(64) Slot {
    T value = {};
  };

  std::array<Slot, 3> slots_ = {};
  alignas(64) std::uint8_t writing_ = 0;
  alignas(64) std::uint8_t reading_ = 1;
  alignas(64) std::atomic<std::uint8_t> shared_{2};
};

}  // namespace hapton
