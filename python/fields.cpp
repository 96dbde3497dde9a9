#include "python/fields.h"

#include <utility>

namespace hapton::python {

Vec3 FieldLaw::step(const Vec3& p_WD, double dt_s) noexcept {
  time_s_ += dt_s;
  unmoved_s_ += dt_s;
  if (!p_WD.allFinite()) return Vec3::Zero();
  velocity_.add(p_WD, std::exchange(unmoved_s_, 0.0));
  const EffectSample hand{.p_SD = p_WD, .v_SD = velocity_.mean(), .time_s = time_s_};
  Vec3 force_n = Vec3::Zero();
  for (Field& field : fields_) force_n += std::visit([&](auto& law) { return law.force(hand); }, field);
  return force_n;
}

}  // namespace hapton::python
