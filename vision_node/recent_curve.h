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

// The last five seconds of a number: of each short span of time its largest value, so that no peak is missed however often it comes.
// Memory is constant. Times: any one monotonic clock, ns. RT: add yes; points no.
class RecentCurve {
 public:
  static constexpr std::int64_t kSpanNs = 20'000'000;  // a point of the curve; with kSpans of them it shows 5 s
  static constexpr std::size_t kSpans = 250;
  static constexpr double kSeconds = 1e-9 * static_cast<double>(kSpanNs) * kSpans;

  // Left out: a value that is not finite, a time before the curve.
  void add(std::int64_t now_ns, double value) noexcept;

  // Oldest first; spans without a value have no point. age_s is that of the span's end, 0 to kSeconds.
  std::vector<CurvePoint> points(std::int64_t now_ns) const;

 private:
  struct Span {
    std::int64_t number = -1;  // since the clock's zero; -1: none
    double largest = 0.0;
  };
  std::array<Span, kSpans> spans_;
};

}  // namespace hapton
