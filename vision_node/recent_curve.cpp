#include "vision_node/recent_curve.h"

#include <algorithm>
#include <cmath>

namespace hapton {

void RecentCurve::add(std::int64_t now_ns, double value) noexcept {
  if (!std::isfinite(value) || now_ns < 0) return;
  const std::int64_t number = now_ns / kSpanNs;
  Span& span = spans_[static_cast<std::size_t>(number) % kSpans];
  if (number < span.number) return;
  span.largest = number == span.number ? std::max(span.largest, value) : value;
  span.number = number;
}

std::vector<CurvePoint> RecentCurve::points(std::int64_t now_ns) const {
  std::vector<CurvePoint> points;
  const std::int64_t newest = now_ns / kSpanNs;
  for (std::int64_t number = std::max<std::int64_t>(0, newest - static_cast<std::int64_t>(kSpans) + 1); number <= newest; ++number) {
    const Span& span = spans_[static_cast<std::size_t>(number) % kSpans];
    if (span.number != number) continue;
    points.push_back({1e-9 * static_cast<double>((newest - number) * kSpanNs), span.largest});
  }
  return points;
}

}  // namespace hapton
