#include "core/tool/local_contacts.h"

#include <algorithm>
#include <span>

namespace hapton {
namespace {

// The motion of least energy from the proxy towards a wanted one; false: the bounds contradict each other.
bool find_motion(const LocalContacts& local, const Vec6& wanted, const Mat6& inverse_root, RigidMotion& motion, int& active) noexcept {
  std::array<MotionBound, LocalContacts::kMost> scaled;
  const std::span<MotionBound> bounds(scaled.data(), local.count);
  for (std::size_t i = 0; i < local.count; ++i) {
    scaled[i] = {inverse_root.transpose() * local.bounds[i].row, local.bounds[i].least};
  }
  const Vec6 goal = inverse_root.transpose() * local.stiffness.cwiseProduct(wanted);
  LeastMotion least = find_least_motion(goal, bounds, local.tolerance);
  if (!least.solved) {
    // A pair below its offset asks for more than the others leave: no motion at all is always allowed then.
    for (MotionBound& bound : bounds) bound.least = std::min(bound.least, 0.0);
    least = find_least_motion(goal, bounds, local.tolerance);
  }
  const Vec6 y = inverse_root * least.y;
  motion = {local.proxy, y.head<3>(), y.tail<3>()};
  active = least.active_count;
  return least.solved;
}

}  // namespace

void LocalContacts::add(const MotionBound& bound) noexcept {
  if (count < kMost) {
    bounds[count++] = bound;
    return;
  }
  const auto farthest =
      std::min_element(bounds.begin(), bounds.end(), [](const MotionBound& a, const MotionBound& b) { return a.least < b.least; });
  if (bound.least > farthest->least) *farthest = bound;
}

Placement LocalContacts::constrain(const Placement& device) const noexcept {
  if (is_blocked) return device;
  if (is_held) return proxy;
  Vec6 wanted;
  wanted << device.position - proxy.position, turn_between(proxy.orientation, device.orientation);
  const bool is_free = std::all_of(bounds.begin(), bounds.begin() + static_cast<std::ptrdiff_t>(count),
                                   [&](const MotionBound& bound) { return bound.row.dot(wanted) >= bound.least - tolerance; });
  if (is_free) return device;
  RigidMotion motion;
  int active = 0;
  if (!find_motion(*this, wanted, inverse_root, motion, active)) return proxy;
  // In the curved metric the bounds may let go of a motion that they would hold in the plain one.
  if (active == 0 && !find_motion(*this, wanted, plain_inverse_root.asDiagonal(), motion, active)) return proxy;
  return motion.at(1.0);
}

}  // namespace hapton
