#pragma once

#include <cstdint>
#include <string>
#include <utility>

namespace hapton {

// A line that the picture shows for as long as it takes to read a path, unless another one replaces it. Times: any monotonic clock, ns. RT:
// no.
class ShownNotice {
 public:
  static constexpr std::int64_t kShownNs = 10'000'000'000;  // 10 s to read it; a free choice

  // newest: empty if there is none. True: line() is another one.
  bool update(std::string newest, std::int64_t now_ns) {
    if (newest.empty() && (end_ns_ == 0 || now_ns < end_ns_)) return false;
    end_ns_ = newest.empty() ? 0 : now_ns + kShownNs;
    line_ = std::move(newest);
    return true;
  }
  // Empty: none is shown.
  const std::string& line() const { return line_; }

 private:
  std::string line_;
  std::int64_t end_ns_ = 0;  // 0: none is shown
};

}  // namespace hapton
