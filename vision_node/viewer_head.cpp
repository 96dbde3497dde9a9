#include "vision_node/viewer_head.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace hapton {
namespace {

Head move_by(const Head& head, const Vec3& by_m) { return {head.p_RH + by_m, head.q_RH}; }

}  // namespace

void ViewerHead::move(const Vec3& by_m) {
  if (is_possible(move_by(tracked_head_, key_motion_m_ + by_m), ipd_m_)) key_motion_m_ += by_m;
}

// Leaves out the moves while the tracked head is so near the screen that they would lead through it.
Head ViewerHead::head() const {
  const Head moved = move_by(tracked_head_, key_motion_m_);
  return is_possible(moved, ipd_m_) ? moved : tracked_head_;
}

double compute_eye_motion_m(const Head& from, const Head& to, double ipd_m) {
  const Vec3 middle = to.p_RH - from.p_RH;
  const Vec3 turned = 0.5 * ipd_m * (to.q_RH * Vec3::UnitX() - from.q_RH * Vec3::UnitX());
  return std::max((middle + turned).norm(), (middle - turned).norm());
}

std::string describe_head(const Head& head, const Head& home) {
  constexpr double kShownM = 0.01;  // unit of the shown position; less than half of it is not shown
  if ((head.p_RH - home.p_RH).norm() < 0.5 * kShownM) return {};
  // Adding 0.0 turns -0 into 0, which is shown without a sign.
  const auto cm = [](double length_m) { return std::round(100.0 * length_m) + 0.0; };
  return fmt::format("head {:.0f} {:.0f} {:.0f} cm", cm(head.p_RH.x()), cm(head.p_RH.y()), cm(head.p_RH.z()));
}

}  // namespace hapton
