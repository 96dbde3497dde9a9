#pragma once

#include <vector>

#include "core/math/types.h"

namespace hapton {

// Makes a polyline of the points that a pen passes, as they come, with few vertices: every point given is within bound_m of it, and its
// first vertex is the first point. A piece grows until it would miss one of the points that it passes over by half the bound; points closer
// than half the bound to the last one are passed over at once, so that a pen at rest adds nothing. Work of a point: at most kMaxWindow
// distances. Any frame, metres. RT: no.
// Source: the opening-window algorithm of Keogh et al., An online algorithm for segmenting time series (2001); we differ in the bound on
// the window.
class StrokeThinner {
 public:
  static constexpr std::size_t kMaxWindow = 256;  // points; bounds the work for each new one. A free choice

  // Pre: above 0, finite.
  explicit StrokeThinner(double bound_m) : bound_m_(bound_m) {}

  // Pre: finite. True if the polyline has changed.
  bool add(const Vec3& p);

  // The last point stays a vertex, and what follows is another piece.
  void keep() { is_kept_ = true; }

  // So far; the last one may be replaced by a later point.
  const std::vector<Vec3>& points() const { return points_; }

 private:
  bool covers_window(const Vec3& from, const Vec3& to) const;

  double bound_m_;
  std::vector<Vec3> points_;
  std::vector<Vec3> window_;  // what the last piece passes over
  bool is_kept_ = false;
};

}  // namespace hapton
