#pragma once

#include <cstdint>
#include <string>
#include <utility>

namespace hapton {

// A line that the picture shows for kShownNs, long enough to read a path, unless a newer one replaces it. Times: any monotonic clock, ns.
// RT: no.
class ShownNotice {
 public:
  static constexpr std::int64_t kShownNs = 10'000'000'000;  // 10 s to read it; a free choice

  // newest: a new line; empty: there is none. True: line() has changed.
  bool update(std::string newest, std::int64_t now_ns) {
    if (newest.empty() && (end_ns_ == 0 || now_ns < end_ns_)) return false;
    end_ns_ = newest.empty() ? 0 : now_ns + kShownNs;
    line_ = std::move(newest);
    return true;
  }
  // The line to show; empty: none.
  const std::string& line() const { return line_; }

 private:
  std::string line_;
  std::int64_t end_ns_ = 0;  // 0: none is shown
};

}  // namespace hapton
