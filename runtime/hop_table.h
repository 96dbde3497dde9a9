#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace hapton {

struct LatencyHop;

// The summary of one hop, in us.
struct HopRow {
  std::string name;
  std::uint64_t n = 0;
  double p50_us = 0.0;
  double p90_us = 0.0;
  double p99_us = 0.0;
  double p99_9_us = 0.0;
  double max_us = 0.0;
};

// RT: no.
HopRow make_hop_row(const LatencyHop& hop);

// A table as text: a heading, and a line for each hop with n > 0. Empty if there is no such hop. RT: no.
std::string make_hop_table(const std::vector<HopRow>& hops);

}  // namespace hapton
