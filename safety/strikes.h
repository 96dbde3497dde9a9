#pragma once

#include <cstdint>

namespace hapton {

// When something that may happen once has happened too often: kMost times, of which one is forgotten every kForgetNs. RT: yes.
class Strikes {
 public:
  static constexpr int kMost = 5;
  static constexpr std::int64_t kForgetNs = 100'000'000;

  // Once more; true: too often. Pre: now_ns never goes back.
  bool note(std::int64_t now_ns) noexcept {
    const std::int64_t forgotten = (now_ns - since_ns_) / kForgetNs;
    count_ = forgotten >= count_ ? 0 : count_ - static_cast<int>(forgotten);
    since_ns_ = count_ == 0 ? now_ns : since_ns_ + forgotten * kForgetNs;
    return ++count_ >= kMost;
  }
  void clear() noexcept { count_ = 0; }

 private:
  int count_ = 0;
  std::int64_t since_ns_ = 0;
};

}  // namespace hapton
