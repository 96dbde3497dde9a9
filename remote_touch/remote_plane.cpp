#include "remote_touch/remote_plane.h"

#include <algorithm>

namespace hapton {

RemoteStep RemotePlane::step(const Vec3& p_WD, std::int64_t now_ns) {
  if (const auto reply = link_.exchange({now_ns, p_WD})) {
    const double depth_m = reply->touch.visual_offset_m.norm();
    const bool is_touched = reply->touch.contact && depth_m > 0.0;
    outward_W_ = is_touched ? Vec3(reply->touch.visual_offset_m / depth_m) : Vec3(Vec3::Zero());
    p_WQ_ = reply->sample.p_WD + reply->touch.visual_offset_m;
    stiffness_n_per_m_ = is_touched ? reply->touch.force_n.norm() / depth_m : 0.0;
  }
  const double depth_m = (p_WQ_ - p_WD).dot(outward_W_);
  return {std::max(depth_m, 0.0) * stiffness_n_per_m_ * outward_W_, now_ns};
}

}  // namespace hapton
