#include "core/tool/local_contacts.h"

#include <algorithm>
#include <span>

namespace hapton {
namespace {

// Finds the motion of least energy from the proxy towards a wanted one within the bounds. False: the bounds contradict each other.
bool find_motion(const LocalContacts& local, const Vec6& wanted, const Mat6& inverse_root, LocalContacts::Solution& solution) noexcept {
  std::array<MotionBound, LocalContacts::kMax> scaled;
  const std::span<MotionBound> bounds(scaled.data(), local.count);
  for (std::size_t i = 0; i < local.count; ++i) {
    scaled[i] = {inverse_root.transpose() * local.bounds[i].row, local.bounds[i].least};
  }
  const Vec6 goal = inverse_root.transpose() * local.stiffness.cwiseProduct(wanted);
  LeastMotion least = find_least_motion(goal, bounds, local.tolerance);
  if (!least.solved) {
    // A pair below its offset may require a motion that the others forbid: then all bounds are relaxed so that zero motion satisfies them.
    for (MotionBound& bound : bounds) bound.least = std::min(bound.least, 0.0);
    least = find_least_motion(goal, bounds, local.tolerance);
  }
  solution.motion = inverse_root * least.y;
  solution.active = least.active;
  solution.multipliers = least.multipliers;
  solution.active_count = least.active_count;
  return least.solved;
}

}  // namespace

void LocalContacts::add(const MotionBound& bound, const LocalContact& contact) noexcept {
  if (count < kMax) {
    bounds[count] = bound;
    contacts[count++] = contact;
    return;
  }
  const auto farthest =
      std::min_element(bounds.begin(), bounds.end(), [](const MotionBound& a, const MotionBound& b) { return a.least < b.least; });
  if (!(bound.least > farthest->least)) return;
  contacts[static_cast<std::size_t>(farthest - bounds.begin())] = contact;
  *farthest = bound;
}

double moved_least(const MotionBound& bound, const LocalContact& contact, std::span<const Placement> parts) noexcept {
  if (contact.part <= 0 || static_cast<std::size_t>(contact.part) > parts.size()) return bound.least;
  const Vec3 moved = parts[static_cast<std::size_t>(contact.part) - 1].at(contact.anchor) - contact.point;
  return contact.found_least + bound.row.head<3>().dot(moved);
}

void LocalContacts::follow(std::span<const Placement> parts) noexcept {
  if (parts.empty()) return;
  for (std::size_t i = 0; i < count; ++i) bounds[i].least = moved_least(bounds[i], contacts[i], parts);
}

bool LocalContacts::allows(const Vec6& motion) const noexcept {
  return std::all_of(bounds.begin(), bounds.begin() + static_cast<std::ptrdiff_t>(count),
                     [&](const MotionBound& bound) { return bound.row.dot(motion) >= bound.least - tolerance; });
}

Vec6 LocalContacts::project(const Vec6& motion) const noexcept {
  if (allows(motion)) return motion;
  Solution solution;
  return find_motion(*this, motion, plain_inverse_root.asDiagonal(), solution) ? solution.motion : Vec6(Vec6::Zero());
}

LocalContacts::Solution LocalContacts::solve(const Placement& device) const noexcept {
  Solution solution;
  solution.at = is_blocked ? device : proxy;
  if (is_blocked || is_held) return solution;
  const Vec6 wanted = motion_between(proxy, device).shift_and_turn();
  if (allows(wanted)) {
    solution.at = device;
    solution.motion = wanted;
    return solution;
  }
  Solution found = solution;
  bool is_found = find_motion(*this, wanted, inverse_root, found);
  // In the curved metric the bounds may allow a motion that they would forbid in the plain one.
  if (is_found && found.active_count == 0) is_found = find_motion(*this, wanted, plain_inverse_root.asDiagonal(), found);
  if (!is_found) return solution;
  found.at = RigidMotion{proxy, found.motion.head<3>(), found.motion.tail<3>()}.at(1.0);
  return found;
}

}  // namespace hapton
