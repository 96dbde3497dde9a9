#pragma once

#include <algorithm>
#include <cstdint>

#include "safety/safety_limits.h"

namespace hapton {

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
