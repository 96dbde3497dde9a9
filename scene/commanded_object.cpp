#include "scene/commanded_object.h"

#include "scene/object_motion.h"
#include "scene/object_reader.h"

namespace hapton {

CommandedObject::CommandedObject(const ObjectSpec& object, const SceneFit& fit, const TriangleMesh& mesh)
    : p_MP_(object.scale * object.motion.p_MP),
      q_SM_(object.q_SM),
      q_SF_(object.q_SF),
      fit_(fit),
      pivot_S_(fit.apply(object.p_SM + object.q_SM * p_MP_)),
      radius_m_(radius_about(pivot_S_, mesh)) {}

Keyframe CommandedObject::place(const std::optional<Vec3>& p_FM, const std::optional<Quat>& q_FM, const Keyframe& now) const noexcept {
  const Quat q = q_FM ? (q_SF_ * *q_FM).normalized() : (now.turn * q_SM_).normalized();
  Keyframe placed;
  placed.p_S = p_FM ? fit_.apply(q_SF_ * *p_FM + q * p_MP_) : now.p_S;
  placed.turn = q_FM ? (q * q_SM_.conjugate()).normalized() : now.turn;
  return placed;
}

bool CommandedObject::operator==(const CommandedObject& other) const noexcept {
  return p_MP_ == other.p_MP_ && q_SM_.coeffs() == other.q_SM_.coeffs() && q_SF_.coeffs() == other.q_SF_.coeffs() &&
         fit_.centre == other.fit_.centre && fit_.scale == other.fit_.scale && pivot_S_ == other.pivot_S_ && radius_m_ == other.radius_m_;
}

ObjectPlace CommandedObject::find_place(const Keyframe& at) const noexcept {
  const Quat q = (at.turn * q_SM_).normalized();
  return {.p_FM = q_SF_.conjugate() * (at.p_S / fit_.scale + fit_.centre - q * p_MP_), .q_FM = (q_SF_.conjugate() * q).normalized()};
}

}  // namespace hapton
