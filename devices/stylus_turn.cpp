#include "devices/stylus_turn.h"

#include "core/math/rotation_vector.h"

namespace hapton {

void StylusTurn::advance(std::int64_t from_ns, std::int64_t to_ns, const Quat& q_WH, const Vec3& torque_nm) noexcept {
  constexpr double kStepS = 1e-9 * static_cast<double>(kStepNs);
  for (std::int64_t step = from_ns / kStepNs; step < to_ns / kStepNs; ++step) {
    const Vec3 all_nm = kHandNmPerRad * turn_between(q_WT_, q_WH) - kHandNmSPerRad * w_rad_per_s_ + torque_nm;
    w_rad_per_s_ += (kStepS / kInertiaKgM2) * all_nm;
    q_WT_ = (turn_by(kStepS * w_rad_per_s_) * q_WT_).normalized();
  }
}

}  // namespace hapton
