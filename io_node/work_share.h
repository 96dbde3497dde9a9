#pragma once

#include <algorithm>
#include <cstdint>

namespace hapton {

// Bounds the time that work takes if another node decides how much work there is: at most this share of the time, and burst_ns more at
// once. A piece of work that has begun is not interrupted: the next piece waits until the excess is made up for. Units: ns of a clock that
// does not go back. RT: yes. Threads: one.
class WorkShare {
 public:
  WorkShare(double share, std::int64_t burst_ns) noexcept
      : share_(share), burst_ns_(static_cast<double>(burst_ns)), budget_ns_(burst_ns_) {}

  bool may_begin(std::int64_t now_ns) noexcept {
    if (last_ns_ != 0) budget_ns_ = std::min(budget_ns_ + share_ * static_cast<double>(now_ns - last_ns_), burst_ns_);
    last_ns_ = now_ns;
    return budget_ns_ > 0.0;
  }
  void note(std::int64_t took_ns) noexcept { budget_ns_ -= static_cast<double>(took_ns); }

 private:
  double share_;
  double burst_ns_;
  double budget_ns_;
  std::int64_t last_ns_ = 0;  // time of the last may_begin; 0: none yet
};

}  // namespace hapton
