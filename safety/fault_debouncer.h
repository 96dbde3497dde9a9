#pragma once

#include <cstdint>

namespace hapton {

// Leaky counter: tolerates an occasional error and reports a repeated one. It trips at kMax errors and loses one every kForgetNs. RT: yes.
class FaultDebouncer {
 public:
  // A choice: errors that come ten times a second or less never trip it, one in each cycle trips it within five cycles.
  static constexpr int kMax = 5;
  static constexpr std::int64_t kForgetNs = 100'000'000;

  // Counts one more error; true: the counter trips. Pre: now_ns never decreases.
  bool note(std::int64_t now_ns) noexcept {
    const std::int64_t forgotten = (now_ns - since_ns_) / kForgetNs;
    count_ = forgotten >= count_ ? 0 : count_ - static_cast<int>(forgotten);
    since_ns_ = count_ == 0 ? now_ns : since_ns_ + forgotten * kForgetNs;
    return ++count_ >= kMax;
  }
  void clear() noexcept { count_ = 0; }

 private:
  int count_ = 0;
  std::int64_t since_ns_ = 0;
};

}  // namespace hapton
