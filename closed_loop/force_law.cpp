#include "closed_loop/force_law.h"

#include <algorithm>

namespace hapton {

Vec3 WallLaw::step(const Vec3& p_WD, double dt_s) noexcept {
  const double x_m = p_WD.x();
  const double velocity = dt_s > 0.0 ? (x_m - previous_m_) / dt_s : 0.0;
  previous_m_ = x_m;
  if (!wall_.two_sided && x_m >= 0.0) return Vec3::Zero();
  const double force_n = -wall_.stiffness_n_per_m * x_m - wall_.damping_ns_per_m * velocity;
  return {wall_.two_sided ? force_n : std::max(force_n, 0.0), 0.0, 0.0};
}

}  // namespace hapton
