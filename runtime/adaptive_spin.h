#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>

namespace hapton {

// How long before a deadline a loop ends its sleep and spins, so that it is on time although wake-ups are late. The margin adapts to every
// wake-up: it grows by kShareOnTime kStepNs if the wake-up was later than the margin, and otherwise shrinks by (1 - kShareOnTime) kStepNs,
// so it converges to the lateness that one wake-up in a hundred exceeds. margin_ns() is at most a share of the period. Source: stochastic
// approximation of a quantile, Robbins & Monro 1951. Units: ns. RT: yes. Threads: that of the loop; set_limit, limit, spun_ns from any.
class AdaptiveSpin {
 public:
  static constexpr double kShareOnTime = 0.99;  // share of the wake-ups that are on time
  static constexpr double kStepNs = 2000.0;     // larger: faster adaptation, but a margin that varies more

  // limit: the largest margin, as a share of a period: 0 (never spins) to 1.
  explicit AdaptiveSpin(double limit = 0.0) noexcept : limit_(limit) {}
  // Adaptation begins from this margin.
  void set_margin_ns(std::int64_t margin_ns) noexcept { margin_ = static_cast<double>(margin_ns); }

  void set_limit(double share) noexcept { limit_.store(share, std::memory_order_relaxed); }
  double limit() const noexcept { return limit_.load(std::memory_order_relaxed); }

  // How long before the deadline the sleep is to end.
  std::int64_t margin_ns(std::int64_t period_ns) const noexcept {
    return std::min(static_cast<std::int64_t>(margin_), static_cast<std::int64_t>(limit() * static_cast<double>(period_ns)));
  }

  // late_ns: how much later than margin_ns() before the deadline the sleep ended.
  void note_wake_up(std::int64_t late_ns) noexcept {
    const bool is_on_time = static_cast<double>(late_ns) <= margin_;
    margin_ = std::max(0.0, margin_ + kStepNs * (is_on_time ? kShareOnTime - 1.0 : kShareOnTime));
  }

  void note_spun(std::int64_t ns) noexcept { spun_ns_.store(spun_ns_.load(std::memory_order_relaxed) + ns, std::memory_order_relaxed); }
  // Total time spent spinning.
  std::int64_t spun_ns() const noexcept { return spun_ns_.load(std::memory_order_relaxed); }

 private:
  double margin_ = 0.0;
  std::atomic<double> limit_;
  std::atomic<std::int64_t> spun_ns_{0};
};

}  // namespace hapton
