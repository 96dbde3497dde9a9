#include "closed_loop/hand_path.h"

#include <algorithm>
#include <limits>

namespace hapton {

std::ptrdiff_t HandPath::index_at(std::int64_t now_ns) const noexcept {
  const auto after = std::upper_bound(points_.begin(), points_.end(), now_ns,
                                      [](std::int64_t time_ns, const Point& point) { return time_ns < point.time_ns; });
  return after - points_.begin() - 1;
}

Vec3 HandPath::position_m(std::int64_t now_ns) const noexcept {
  if (points_.empty()) return Vec3::Zero();
  const std::ptrdiff_t index = index_at(now_ns);
  if (index < 0) return points_.front().p_WH;
  const Point& point = points_[static_cast<std::size_t>(index)];
  return point.p_WH + 1e-9 * static_cast<double>(now_ns - point.time_ns) * velocity_m_per_s(now_ns);
}

Vec3 HandPath::velocity_m_per_s(std::int64_t now_ns) const noexcept {
  const std::ptrdiff_t index = index_at(now_ns);
  if (index < 0 || index + 1 >= static_cast<std::ptrdiff_t>(points_.size())) return Vec3::Zero();
  const Point& from = points_[static_cast<std::size_t>(index)];
  const Point& to = points_[static_cast<std::size_t>(index) + 1];
  return (to.p_WH - from.p_WH) / (1e-9 * static_cast<double>(to.time_ns - from.time_ns));
}

Vec3 HandPath::push_n(std::int64_t now_ns) const noexcept {
  const std::ptrdiff_t index = index_at(now_ns);
  return index < 0 ? Vec3(Vec3::Zero()) : points_[static_cast<std::size_t>(index)].push_n;
}

std::int64_t HandPath::next_ns(std::int64_t now_ns) const noexcept {
  const std::size_t after = static_cast<std::size_t>(index_at(now_ns) + 1);
  return after < points_.size() ? points_[after].time_ns : std::numeric_limits<std::int64_t>::max();
}

}  // namespace hapton
