#pragma once

#include <vector>

#include "core/math/types.h"

namespace hapton {

// Makes a polyline with few vertices from the points that a pen passes, point by point: every added point is within bound_m of the
// polyline, and the first vertex is the first point. The last segment grows until a point that it stands for would be farther than half the
// bound from it. Points within half the bound of the last vertex are ignored, so that a pen at rest adds nothing. Work for a point: at most
// kMaxWindow distances. Any frame, metres. RT: no.
// Source: the opening-window algorithm of Keogh et al., An online algorithm for segmenting time series (2001); in addition, the window
// (the points of the last segment) is bounded.
class StrokeThinner {
 public:
  static constexpr std::size_t kMaxWindow = 256;  // points; bounds the work for each new one. A free choice

  // Pre: bound_m is finite and above 0.
  explicit StrokeThinner(double bound_m) : bound_m_(bound_m) {}

  // Adds a point. Pre: p is finite. True if the polyline has changed.
  bool add(const Vec3& p);

  // Keeps the last vertex: the next point begins a new segment.
  void keep_last() { is_last_kept_ = true; }

  // The vertices so far; a later point may replace the last one.
  const std::vector<Vec3>& points() const { return points_; }

 private:
  bool covers_window(const Vec3& from, const Vec3& to) const;

  double bound_m_;
  std::vector<Vec3> points_;
  std::vector<Vec3> window_;  // the points that the last segment stands for
  bool is_last_kept_ = false;
};

}  // namespace hapton
