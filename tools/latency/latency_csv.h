#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace hapton {

// The durations of one hop, as counts in buckets [lower, upper), lowest first.
struct HopCounts {
  struct Bucket {
    std::int64_t lower_ns = 0;
    std::int64_t upper_ns = 0;
    std::uint64_t count = 0;
  };

  std::string name;  // lower_snake
  std::vector<Bucket> buckets;

  std::uint64_t total() const;
  // Middle of the bucket in which that share (0 .. 1) of all durations is reached. Pre: total() > 0.
  double quantile_us(double share) const;
};

// The counts between two reports of the same run: the present counts less the earlier ones, by hop and bucket. A new hop or bucket counts
// completely. A hop with fewer durations than before (the run started again) keeps its present counts.
std::vector<HopCounts> subtract_hops(const std::vector<HopCounts>& now, const std::vector<HopCounts>& before);

// The same rows as latency.csv has. RT: no.
std::string to_csv(const std::vector<HopCounts>& hops);

// Reads latency.csv (header hop,lower_ns,upper_ns,count; the rows of a hop are contiguous, ascending). The hops are in the order of the
// file; a hop without durations is left out. Error: one line with the file and the number of the line. RT: set-up only.
Result<std::vector<HopCounts>> read_latency_csv(const std::filesystem::path& path);
Result<std::vector<HopCounts>> parse_latency_csv(std::string_view text, std::string_view name);

}  // namespace hapton
