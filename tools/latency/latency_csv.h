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

  std::string name;  // in lower case with underscores: "round_trip"
  std::vector<Bucket> buckets;

  std::uint64_t total() const;
  // The middle of the bucket up to which this share (0 to 1) of all durations lies. Pre: total() > 0.
  double quantile_us(double share) const;
};

// The counts between two reports of the same run: for each hop and bucket the counts `now` minus those `before`. A new hop or bucket counts
// completely. A hop with fewer durations than before (the run started again) keeps all its counts. Hops without counts are left out.
std::vector<HopCounts> subtract_hops(const std::vector<HopCounts>& now, const std::vector<HopCounts>& before);

// The text of a latency.csv with these counts. RT: no.
std::string to_csv(const std::vector<HopCounts>& hops);

// Reads latency.csv (header hop,lower_ns,upper_ns,count; the rows of a hop are contiguous, ascending). The hops are in the order of the
// file; hops without durations are left out. Error, one line: no file, an invalid row (with its number), no durations. RT: set-up only.
Result<std::vector<HopCounts>> read_latency_csv(const std::filesystem::path& path);
Result<std::vector<HopCounts>> parse_latency_csv(std::string_view text, std::string_view name);

}  // namespace hapton
