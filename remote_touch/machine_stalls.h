#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <random>

namespace hapton {

// Random stalls of the device's whole machine. Gaps and stalls have exponentially distributed lengths; a stall is at most kMaxOverMean
// times the mean. One row is one period. RT: no. Threads: one.
class MachineStalls {
 public:
  static constexpr double kGapS = 0.2;         // mean gap between two stalls
  static constexpr double kMaxOverMean = 5.0;  // longest stall, as a multiple of the mean one

  // mean_s: mean length of a stall; 0: no stalls.
  MachineStalls(double mean_s, double period_s, std::uint64_t seed)
      : mean_stall_rows_(mean_s / period_s), mean_gap_rows_(kGapS / period_s), random_(seed) {
    next_stall_row_ = mean_s > 0.0 ? draw(mean_gap_rows_) : std::numeric_limits<double>::infinity();
  }

  // Number of rows that are missed in a stall before the next row. row: number of the row that would be next.
  std::size_t missed_before(std::size_t row) {
    if (static_cast<double>(row) < next_stall_row_) return 0;
    const double missed = std::floor(std::min(draw(mean_stall_rows_), kMaxOverMean * mean_stall_rows_));
    next_stall_row_ = static_cast<double>(row) + missed + 1.0 + draw(mean_gap_rows_);
    return static_cast<std::size_t>(missed);
  }

 private:
  double draw(double mean) { return std::exponential_distribution<double>(1.0 / mean)(random_); }

  double mean_stall_rows_;
  double mean_gap_rows_;
  std::mt19937_64 random_;
  double next_stall_row_ = 0.0;
};

}  // namespace hapton
