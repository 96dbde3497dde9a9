#pragma once

#include "core/math/types.h"
#include "scene/object_reader.h"

namespace hapton {

// What a pose and a scale do to points: p + q * (scale * point). RT: yes.
struct Similarity {
  double scale = 1.0;
  Quat q = Quat::Identity();
  Vec3 p = Vec3::Zero();

  Vec3 apply(const Vec3& point) const { return p + q * (scale * point); }
  // inner first.
  Similarity then(const Similarity& inner) const { return {scale * inner.scale, q * inner.q, apply(inner.p)}; }
  Similarity inverse() const { return {1.0 / scale, q.conjugate(), q.conjugate() * (-p / scale)}; }
};

Similarity pose_of(const ObjectSpec& object);

// Moves an object with its keyframes: all of its poses X become by * X. RT: set-up only.
void move_by(const Similarity& by, ObjectSpec& object);

}  // namespace hapton
