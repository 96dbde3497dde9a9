#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace hapton {

// Tells whether an item has been visited in the current query. The start of a query changes the stamp, not the items, so it costs nothing.
// Stamp: unsigned; when its values are used up (VisitStamps: once in 2^32 queries), start clears the stamps of all items. RT: start and
// first_visit yes. Threads: one.
template <class Stamp>
class VisitStampsOf {
 public:
  explicit VisitStampsOf(std::size_t items = 0) : item_stamps_(items, 0) {}

  void start() noexcept {
    if (++stamp_ == 0) {
      std::fill(item_stamps_.begin(), item_stamps_.end(), Stamp{0});
      stamp_ = 1;
    }
  }

  // True at the first call for this item since start. Pre: start was called.
  bool first_visit(std::uint32_t item) noexcept {
    if (item_stamps_[item] == stamp_) {
      return false;
    }
    item_stamps_[item] = stamp_;
    return true;
  }

 private:
  std::vector<Stamp> item_stamps_;
  Stamp stamp_ = 0;
};

using VisitStamps = VisitStampsOf<std::uint32_t>;

}  // namespace hapton
