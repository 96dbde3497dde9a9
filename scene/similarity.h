#pragma once

#include "core/math/types.h"
#include "scene/object_reader.h"

namespace hapton {

// The transform by a pose and a scale: a point p' becomes p + q * (scale * p'). RT: yes.
struct Similarity {
  double scale = 1.0;
  Quat q = Quat::Identity();
  Vec3 p = Vec3::Zero();

  Vec3 apply(const Vec3& point) const { return p + q * (scale * point); }
  // The transform that applies `inner` first, then this one.
  Similarity then(const Similarity& inner) const { return {scale * inner.scale, q * inner.q, apply(inner.p)}; }
  Similarity inverse() const { return {1.0 / scale, q.conjugate(), q.conjugate() * (-p / scale)}; }
};

Similarity pose_of(const ObjectSpec& object);  // from the object's mesh to S

// Applies the transform to an object and its keyframes, after the pose that each of them has. The object's scale is multiplied by that of
// the transform. RT: set-up only.
void move_by(const Similarity& transform, ObjectSpec& object);

}  // namespace hapton
