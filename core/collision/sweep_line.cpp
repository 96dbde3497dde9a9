#include "core/collision/sweep_line.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hapton {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

}  // namespace

SweepOutcome compute_collision(const SweepLine& line, const TrianglePlane& plane, SweepCollision& collision) noexcept {
  const Vec3 from = line.last - plane.origin;
  const Vec3 to = line.current - plane.origin;
  const double height_from = plane.normal.dot(from);
  const double height_to = plane.normal.dot(to);
  const double drop = height_from - height_to;
  if (drop == 0.0) {
    return SweepOutcome::parallel;
  }
  const bool starts_above = height_from >= 0.0;
  const bool ends_above = height_to >= 0.0;
  if (starts_above == ends_above) {
    return SweepOutcome::out_of_length;
  }

  const double t = height_from / drop;
  const Vec3 along = to - from;
  const Vec3 crossing = from + t * along;
  // Rounding: a height is a sum of three products, with an error of at most 4 epsilon times its terms. So the error of t is that of the
  // heights divided by the drop; the error of the point is this share of the line, plus 4 epsilon times the point's own terms.
  const double scale = plane.extent + from.cwiseAbs().sum() + to.cwiseAbs().sum();
  const double rounding = 8.0 * kEpsilon * scale;
  const double along_error = std::min(1.0, rounding / std::abs(drop));
  if (!plane.contains(crossing[plane.u_axis], crossing[plane.v_axis], rounding, along_error * along[plane.u_axis],
                      along_error * along[plane.v_axis])) {
    return SweepOutcome::out_of_triangle;
  }

  collision.t = t;
  collision.point = line.last + t * (line.current - line.last);
  collision.normal = starts_above ? plane.normal : Vec3(-plane.normal);
  collision.depth = std::abs(height_to);
  collision.from_behind = !starts_above;
  return SweepOutcome::collision;
}

}  // namespace hapton
