#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace hapton {

// Tells whether an item has been visited in the current query. Starting a query changes the stamp, not the items, so it costs nothing. RT:
// start and first_visit yes (once in 2^32 queries start clears all stamps). Threads: one.
class VisitStamps {
 public:
  explicit VisitStamps(std::size_t items = 0, std::uint32_t first_stamp = 0) : seen_(items, 0), stamp_(first_stamp) {}

  void start() noexcept {
    if (++stamp_ == 0) {
      std::fill(seen_.begin(), seen_.end(), 0);
      stamp_ = 1;
    }
  }

  // True at the first call for this item since start.
  bool first_visit(std::uint32_t item) noexcept {
    if (seen_[item] == stamp_) {
      return false;
    }
    seen_[item] = stamp_;
    return true;
  }

 private:
  std::vector<std::uint32_t> seen_;
  std::uint32_t stamp_;
};

}  // namespace hapton
