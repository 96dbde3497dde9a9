#include "core/tool/contact_cones.h"

#include <algorithm>
#include <cmath>

namespace hapton {
namespace {

// A round of the iteration corrects the forces of each contact once. The iteration ends after a round in which no correction is larger than
// this share of the distance between device and tool.
constexpr double kMaxCorrectionShare = 0x1p-20;
// A contact counts as the same as in the last step if its point and its normal, taken together, have moved by less than this times the
// lever of the tool: the root of the coupling's rotational stiffness divided by its linear stiffness.
constexpr double kMaxSameContactDistance = 0.25;
// Share of the largest normal force: a contact that pushes with less does not count when the slip of the tool is measured.
constexpr double kMinForceShare = 0x1p-10;

Vec6 wrench(const Vec3& force, const Vec3& arm) {
  Vec6 all;
  all << force, arm.cross(force);
  return all;
}

}  // namespace

bool ContactCones::has(int index) const noexcept {
  return std::any_of(contacts_.begin(), contacts_.begin() + static_cast<std::ptrdiff_t>(count_),
                     [index](const Contact& contact) { return contact.index == index; });
}

void ContactCones::add(const LocalContacts& local, const Vec6& slip_start, bool is_static, int index, double normal,
                       const Vec3& tangential) noexcept {
  if (count_ == kMax || has(index)) return;
  const auto i = static_cast<std::size_t>(index);
  const MotionBound& bound = local.bounds[i];
  const LocalContact& found = local.contacts[i];
  const Vec6 scale = local.plain_inverse_root;
  Contact& contact = contacts_[count_++];
  contact.index = index;
  contact.least = bound.least;
  contact.coefficient = is_static ? found.friction.friction_static : found.friction.friction_dynamic;
  contact.normal_row = scale.cwiseProduct(bound.row);
  contact.normal_compliance = contact.normal_row.squaredNorm();
  const Vec3 direction = bound.row.head<3>().normalized();
  contact.tangents[0] = direction.unitOrthogonal();
  contact.tangents[1] = direction.cross(contact.tangents[0]);
  for (std::size_t k = 0; k < 2; ++k) {
    const Vec6 row = wrench(contact.tangents[k], found.arm);
    contact.tangent_rows[k] = scale.cwiseProduct(row);
    contact.slip_start[k] = row.dot(slip_start);
  }
  const auto& [a, b] = contact.tangent_rows;
  contact.tangent_compliance = std::max(a.squaredNorm(), b.squaredNorm()) + std::abs(a.dot(b));
  contact.normal = normal;
  const double length = tangential.norm();
  const double share = length > 0.0 ? std::min(1.0, contact.coefficient * normal / length) : 0.0;
  scaled_motion_ += normal * contact.normal_row;
  for (std::size_t k = 0; k < 2; ++k) {
    contact.tangential[k] = share * tangential.dot(contact.tangents[k]);
    scaled_motion_ += contact.tangential[k] * contact.tangent_rows[k];
  }
}

void ContactCones::add_previous(const LocalContacts& local, const Vec6& slip_start, bool is_static) noexcept {
  const double lever_squared = local.stiffness[3];
  for (std::size_t k = 0; k < previous_count_; ++k) {
    const PreviousContact& previous = previous_[k];
    int nearest = -1;
    double least_squared = kMaxSameContactDistance * kMaxSameContactDistance * lever_squared;
    for (std::size_t i = 0; i < local.count; ++i) {
      const double distance_squared = (local.contacts[i].arm - previous.arm).squaredNorm() +
                                      lever_squared * (local.bounds[i].row.head<3>().normalized() - previous.direction).squaredNorm();
      if (distance_squared >= least_squared) continue;
      least_squared = distance_squared;
      nearest = static_cast<int>(i);
    }
    if (nearest >= 0) add(local, slip_start, is_static, nearest, previous.normal, previous.tangential);
  }
}

// Corrects the forces of a contact. Returns how far that moves the tool, in scaled coordinates.
double ContactCones::correct(Contact& contact) noexcept {
  const double normal =
      std::max(0.0, contact.normal + (contact.least - contact.normal_row.dot(scaled_motion_)) / contact.normal_compliance);
  double moved_squared = (normal - contact.normal) * (normal - contact.normal) * contact.normal_compliance;
  scaled_motion_ += (normal - contact.normal) * contact.normal_row;
  contact.normal = normal;
  std::array<double, 2> unlimited;
  for (std::size_t k = 0; k < 2; ++k) {
    const double slip = contact.tangent_rows[k].dot(scaled_motion_) - contact.slip_start[k];
    unlimited[k] = contact.tangential[k] - slip / contact.tangent_compliance;
  }
  const double length = std::sqrt(unlimited[0] * unlimited[0] + unlimited[1] * unlimited[1]);
  const double max_tangential = contact.coefficient * normal;
  const double share = length > max_tangential ? max_tangential / length : 1.0;
  for (std::size_t k = 0; k < 2; ++k) {
    const double change = share * unlimited[k] - contact.tangential[k];
    moved_squared += change * change * contact.tangent_compliance;
    scaled_motion_ += change * contact.tangent_rows[k];
    contact.tangential[k] += change;
  }
  return std::sqrt(moved_squared);
}

void ContactCones::iterate(const Vec6& goal) noexcept {
  while (rounds_ < kMaxRounds) {
    double longest_correction = 0.0;
    for (std::size_t i = 0; i < count_; ++i) longest_correction = std::max(longest_correction, correct(contacts_[i]));
    ++rounds_;
    if (longest_correction <= kMaxCorrectionShare * (scaled_motion_ - goal).norm()) return;
  }
}

// Adds the contact whose bound is violated most. False: no bound is violated, or there is no room for another contact.
bool ContactCones::add_violated(const LocalContacts& local, const Vec6& slip_start, bool is_static) noexcept {
  int worst = -1;
  double most = local.tolerance;
  for (std::size_t i = 0; i < local.count; ++i) {
    const double below = local.bounds[i].least - local.bounds[i].row.dot(motion_);
    if (!(below > most) || has(static_cast<int>(i))) continue;
    most = below;
    worst = static_cast<int>(i);
  }
  if (worst < 0 || count_ == kMax) return false;
  add(local, slip_start, is_static, worst, 0.0, Vec3::Zero());
  return true;
}

void ContactCones::store_results(const LocalContacts& local) noexcept {
  previous_count_ = 0;
  slip_ = 0.0;
  double largest = 0.0;
  for (std::size_t i = 0; i < count_; ++i) largest = std::max(largest, contacts_[i].normal);
  for (std::size_t i = 0; i < count_; ++i) {
    const Contact& contact = contacts_[i];
    if (!(contact.normal > 0.0)) continue;
    const auto n = static_cast<std::size_t>(contact.index);
    const Vec3 tangential = contact.tangential[0] * contact.tangents[0] + contact.tangential[1] * contact.tangents[1];
    previous_[previous_count_++] = {local.contacts[n].arm, local.bounds[n].row.head<3>().normalized(), contact.normal, tangential};
    if (contact.normal < kMinForceShare * largest) continue;
    slip_ = std::max(slip_, std::hypot(contact.tangent_rows[0].dot(scaled_motion_) - contact.slip_start[0],
                                       contact.tangent_rows[1].dot(scaled_motion_) - contact.slip_start[1]));
  }
}

std::size_t ContactCones::list_forces(const LocalContacts& local, std::span<ContactForce, kMax> forces) const noexcept {
  std::size_t count = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    const Contact& contact = contacts_[i];
    if (!(contact.normal > 0.0)) continue;
    const auto n = static_cast<std::size_t>(contact.index);
    const Vec3 tangential = contact.tangential[0] * contact.tangents[0] + contact.tangential[1] * contact.tangents[1];
    forces[count++] = {contact.index, contact.normal * local.bounds[n].row + wrench(tangential, local.contacts[n].arm), contact.normal};
  }
  return count;
}

void ContactCones::solve(const LocalContacts& local, const Vec6& wanted, const Vec6& slip_start,
                         const LocalContacts::Solution& frictionless, bool is_static) noexcept {
  const Vec6 goal = wanted.cwiseQuotient(local.plain_inverse_root);
  scaled_motion_ = goal;
  count_ = 0;
  rounds_ = 0;
  add_previous(local, slip_start, is_static);
  for (std::size_t k = 0; k < static_cast<std::size_t>(frictionless.active_count); ++k) {
    add(local, slip_start, is_static, frictionless.active[k], 0.0, Vec3::Zero());
  }
  for (std::size_t set = 0; set < kMaxSets; ++set) {
    iterate(goal);
    motion_ = local.plain_inverse_root.cwiseProduct(scaled_motion_);
    if (rounds_ == kMaxRounds || !add_violated(local, slip_start, is_static)) break;
  }
  store_results(local);
}

}  // namespace hapton
