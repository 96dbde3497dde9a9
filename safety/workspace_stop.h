#pragma once

#include <algorithm>

#include "safety/safety_limits.h"

namespace hapton {

// Soft stop at the end of the workspace: outward force fades to zero over the last kMarginM (or a tenth of the axis, if that is less), for
// each axis, and stays zero beyond the end. It only reduces force: a virtual wall would push a hand that is already outside.
// Frame: W (world); D: the device point. RT: yes.
class WorkspaceStop {
 public:
  // The fade acts like a spring of max_force / kMarginM, 845 N/m for a PHANToM Model A. A much shorter one would be stiffer than the
  // 1000 N/m that this device can render.
  static constexpr double kMarginM = 0.010;

  // Share of a force along +axis (outward 1) or -axis (-1) that remains at p_WD: 1 inside, 0 at the end and beyond.
  static double share(const DeviceLimits& limits, int axis, double outward, const Vec3& p_WD) noexcept {
    const double low = limits.workspace_min_m[axis];
    const double high = limits.workspace_max_m[axis];
    const double left_m = outward > 0.0 ? high - p_WD[axis] : p_WD[axis] - low;
    const double margin_m = std::min(kMarginM, 0.1 * (high - low));
    if (!(left_m > 0.0)) return 0.0;
    return left_m < margin_m ? left_m / margin_m : 1.0;  // the margin of a tiny axis may be zero
  }

  static Vec3 shape(const DeviceLimits& limits, const Vec3& force_n, const Vec3& p_WD) noexcept {
    Vec3 result = force_n;
    for (int axis = 0; axis < 3; ++axis) result[axis] *= share(limits, axis, force_n[axis], p_WD);
    return result;
  }
};

}  // namespace hapton
