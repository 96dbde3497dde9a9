#include "scene/similarity.h"

namespace hapton {

Similarity pose_of(const ObjectSpec& object) { return {object.scale, object.q_SM, object.p_SM}; }

void move_by(const Similarity& transform, ObjectSpec& object) {
  const Similarity moved = transform.then(pose_of(object));
  object.scale = moved.scale;
  object.q_SM = moved.q;
  object.p_SM = moved.p;
  for (KeyframeSpec& one : object.motion.keyframes) {
    if (one.p_SM) one.p_SM = transform.apply(*one.p_SM);
    if (one.q_SM) one.q_SM = transform.q * *one.q_SM;
  }
}

}  // namespace hapton
