#pragma once

#include <algorithm>
#include <cstdint>

namespace hapton {

// Whether a plug-in keeps to its time. Each call longer than the budget adds 1 to a count, a call longer than kFarNs adds 6, and each other
// call subtracts 0.01, down to 0; at 10 the budget is exhausted. So 10 overruns in a row exhaust it, or two calls longer than kFarNs, or in
// the long run more than 1 % of overruns; a machine that stands still once does not. RT: all. Threads: one.
class CallBudget {
 public:
  static constexpr std::int64_t kDefaultNs = 100'000;  // a tenth of the period at 1 kHz
  static constexpr std::int64_t kFarNs = 10'000'000;   // half of the time after which the hub releases the force
  static constexpr double kMaxOverruns = 10.0;

  explicit CallBudget(std::int64_t budget_ns = kDefaultNs) : budget_ns_(budget_ns) {}

  // False for the call that exhausts the budget, and for all later ones.
  bool add(std::int64_t spent_ns) noexcept {
    const double cost = spent_ns > kFarNs ? 6.0 : spent_ns > budget_ns_ ? 1.0 : -0.01;
    overruns_ = std::max(0.0, overruns_ + cost);
    is_exhausted_ = is_exhausted_ || overruns_ >= kMaxOverruns;
    return !is_exhausted_;
  }

  std::int64_t budget_ns() const noexcept { return budget_ns_; }

 private:
  std::int64_t budget_ns_;
  double overruns_ = 0.0;
  bool is_exhausted_ = false;
};

}  // namespace hapton
