#include "python/fields.h"

#include <algorithm>

namespace hapton::python {

Vec3 FieldLaw::step(const Vec3& p_WD, double dt_s) noexcept {
  time_s_ += std::max(dt_s, 0.0);
  motion_.add(p_WD, dt_s);
  if (!p_WD.allFinite()) return Vec3::Zero();
  const EffectSample hand{.p_SD = p_WD, .v_SD = motion_.velocity(), .time_s = time_s_};
  Vec3 force_n = Vec3::Zero();
  for (Field& field : fields_) force_n += std::visit([&](auto& law) { return law.force(hand); }, field);
  return force_n;
}

}  // namespace hapton::python
