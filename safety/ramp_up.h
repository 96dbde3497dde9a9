#pragma once

#include <algorithm>
#include <cstdint>

namespace hapton {

// Duration of the ramp up: at 1 kHz 1 % of the force in each step, with a spectrum that ends where a hand begins to feel vibration
// (decision 22).
constexpr std::int64_t kRampNs = 100'000'000;

// A factor that rises linearly from 0 to 1 within kRampNs. RT: yes.
class RampUp {
 public:
  void begin(std::int64_t now_ns) noexcept { begin_ns_ = now_ns; }
  // 0 .. 1. Pre: now_ns not before begin.
  double share(std::int64_t now_ns) const noexcept {
    return std::min(1.0, static_cast<double>(now_ns - begin_ns_) / static_cast<double>(kRampNs));
  }

 private:
  std::int64_t begin_ns_ = 0;
};

}  // namespace hapton
