#pragma once

#include <cstdint>
#include <vector>

#include "core/math/types.h"

namespace hapton {

// The intended position of the hand, and an additional push, over time. The position moves in straight lines between points and rests
// before the first and after the last. Frame W, SI, ns. RT: no heap in the queries.
class HandPath {
 public:
  struct Point {
    std::int64_t time_ns = 0;
    Vec3 p_WH = Vec3::Zero();
    Vec3 push_n = Vec3::Zero();  // push from this point on, constant until the next point
  };

  HandPath() = default;
  // Pre: each time is later than the one before.
  explicit HandPath(std::vector<Point> points) : points_(std::move(points)) {}

  Vec3 position_m(std::int64_t now_ns) const noexcept;
  Vec3 velocity_m_per_s(std::int64_t now_ns) const noexcept;
  Vec3 push_n(std::int64_t now_ns) const noexcept;
  // The time of the first point after now_ns; INT64_MAX if there is none.
  std::int64_t next_ns(std::int64_t now_ns) const noexcept;
  std::int64_t end_ns() const noexcept { return points_.empty() ? 0 : points_.back().time_ns; }

 private:
  // The index of the last point at or before now_ns; negative if there is none.
  std::ptrdiff_t index_at(std::int64_t now_ns) const noexcept;

  std::vector<Point> points_;
};

}  // namespace hapton
