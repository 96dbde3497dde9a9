#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace hapton {

struct CurvePoint {
  double age_s = 0.0;
  double value = 0.0;
  friend bool operator==(const CurvePoint&, const CurvePoint&) = default;
};

// The last five seconds of a number: the largest value in each span of kSpanNs, so that no peak is missed however often values come.
// Memory is constant. Times: any one monotonic clock, ns. RT: add yes; points no.
class RecentCurve {
 public:
  static constexpr std::int64_t kSpanNs = 20'000'000;  // length of the span that gives one point; kSpans of them are 5 s
  static constexpr std::size_t kSpans = 250;
  static constexpr double kSeconds = 1e-9 * static_cast<double>(kSpanNs) * kSpans;

  // Adds a value. Left out: a value that is not finite, a time below 0, and a time that is older than the curve.
  void add(std::int64_t now_ns, double value) noexcept;

  // Oldest first; spans without a value have no point. age_s: from that span to the one of now_ns, from 0 to below kSeconds.
  std::vector<CurvePoint> points(std::int64_t now_ns) const;

 private:
  struct Span {
    std::int64_t number = -1;  // number of the span since the clock's zero; -1: none
    double largest = 0.0;
  };
  std::array<Span, kSpans> spans_;
};

}  // namespace hapton
