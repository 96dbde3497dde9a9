#include "core/tool/contact_damping.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Eigenvalues>

#include "core/effects/bounded_force.h"
#include "core/math/cross_matrix.h"

namespace hapton {
namespace {

bool has_damping_on_any(const std::vector<DampingCoefficients>& objects) {
  return std::any_of(objects.begin(), objects.end(), [](const DampingCoefficients& one) { return one.is_on(); });
}

// A part that is no longer touched is dropped when less than this share of its damping is left: too little to be felt.
constexpr double kMinRemaining = 0x1p-16;

// The factor that limits a damping force to its bound.
double share_within(double force_n, double most_n) { return force_n > most_n ? most_n / force_n : 1.0; }

}  // namespace

ContactDamping::ContactDamping(std::vector<std::vector<DampingCoefficients>> damping, double unit_m, double radius)
    : damping_(std::move(damping)), unit_m_(unit_m), radius_(radius), motions_(damping_.size()) {
  update_damping();
}

// For a part without damping no velocity is computed. If such a part gets damping, the velocities of all parts restart.
void ContactDamping::update_damping() noexcept {
  is_on_ = false;
  for (std::size_t p = 0; p < damping_.size(); ++p) {
    const bool had_damping = std::exchange(motions_[p].has_damping, has_damping_on_any(damping_[p]));
    is_on_ = is_on_ || motions_[p].has_damping;
    if (motions_[p].has_damping && !had_damping) reset();
  }
}

void ContactDamping::set_damping(const std::vector<std::vector<DampingCoefficients>>& damping) noexcept {
  damping_ = damping;
  update_damping();
}

void ContactDamping::reset() noexcept {
  for (Motion& motion : motions_) {
    motion.shift.reset();
    motion.turn.reset();
  }
  is_placed_ = false;
  dt_s_ = 0.0;
  touched_parts_.count = 0;
}

void ContactDamping::move(const Placement& device, std::span<const Placement> parts, double dt_s) noexcept {
  const bool is_first = !std::exchange(is_placed_, true);
  const Placement last = std::exchange(device_, device);
  dt_s_ += std::max(0.0, dt_s);
  for (std::size_t p = 0; p < motions_.size(); ++p) {
    Motion& motion = motions_[p];
    if (!motion.has_damping) continue;
    const Placement part = p > 0 && p <= parts.size() ? parts[p - 1] : Placement();
    const bool jumps = is_first || unit_m_ * relative_travel_bound(last, radius_, motion.part, part) > kJumpMPerS * dt_s;
    const Placement from = (jumps ? part : motion.part).inverse() * (is_first ? device : last);
    const Placement to = part.inverse() * device;
    motion.part = part;
    motion.shift.move_last(unit_m_ * from.position);
    motion.shift.add(unit_m_ * to.position, dt_s);
    motion.turn.move_last(Vec3::Zero());
    motion.turn.add(turn_between(from.orientation, to.orientation), dt_s);
  }
}

Vec6 ContactDamping::relative_velocity(int part) const noexcept {
  const Motion& motion = motions_[static_cast<std::size_t>(part)];
  Vec6 velocity;
  velocity << motion.part.orientation * motion.shift.mean(), motion.part.orientation * motion.turn.mean();
  return velocity;
}

DampingCoefficients ContactDamping::damping_of(const Contact& contact) const noexcept {
  const auto part = static_cast<std::size_t>(contact.part);
  if (part >= damping_.size() || contact.object >= damping_[part].size()) return {};
  return damping_[part][contact.object];
}

void ContactDamping::add(const Contact& contact, double normal_load_n, TouchedPart& touched) const noexcept {
  const DampingCoefficients damping = damping_of(contact);
  touched.contact_n += contact.force_n;
  if (!damping.is_on()) return;
  const double weight = contact.force_n / normal_load_n;
  const double larger = std::max(damping.normal_ns_per_m, damping.along_ns_per_m);
  touched.largest = std::max(touched.largest, larger);
  touched.upper_bound += weight * larger;
  const Vec3 arm = unit_m_ * contact.arm;
  Eigen::Matrix<double, 3, 6> jacobian;
  jacobian << Mat3::Identity(), cross_matrix(arm).transpose();  // velocity of the contact's point: shift + turn x arm
  const Vec3 velocity = jacobian * relative_velocity(contact.part);
  const double normal_speed = contact.normal.dot(velocity);
  const Vec6 row = jacobian.transpose() * contact.normal;
  const auto add_to = [&](DampingMatrix& metric, double ns_per_m, double speed, const auto& shape) {
    if (!(ns_per_m > 0.0)) return;
    const double coefficient = weight * ns_per_m * share_within(ns_per_m * std::abs(speed), normal_load_n);
    metric.matrix += coefficient * shape;
    metric.coefficient += coefficient;
  };
  add_to(touched.normal, damping.normal_ns_per_m, normal_speed, Mat6(row * row.transpose()));
  add_to(touched.along, damping.along_ns_per_m, (velocity - normal_speed * contact.normal).norm(),
         Mat6(jacobian.transpose() * jacobian - row * row.transpose()));
}

void ContactDamping::DampingMatrix::scale(double share) noexcept {
  matrix *= share;
  coefficient *= share;
}

void ContactDamping::DampingMatrix::blend(const DampingMatrix& before, double share) noexcept {
  if (!matrix.allFinite()) *this = {};  // otherwise the filter would keep what is not finite
  matrix = before.matrix + share * (matrix - before.matrix);
  coefficient = before.coefficient + share * (coefficient - before.coefficient);
}

// By Cauchy's inequality the sum of the contacts' forces is at most the root of coefficient times power.
Vec6 ContactDamping::DampingMatrix::force(const Vec6& velocity, double most_n) const noexcept {
  if (!(coefficient > 0.0)) return Vec6::Zero();
  const Vec6 drag = matrix * velocity;
  const double sum_n = std::sqrt(coefficient * std::max(0.0, drag.dot(velocity)));
  const Vec6 force = -share_within(sum_n, std::min(most_n, kMaxEffectForceN)) * drag;
  return force.allFinite() ? force : Vec6(Vec6::Zero());
}

const ContactDamping::TouchedPart* ContactDamping::TouchedParts::find(int part) const noexcept {
  const auto end = all.begin() + static_cast<std::ptrdiff_t>(count);
  const auto found = std::find_if(all.begin(), end, [part](const TouchedPart& one) { return one.part == part; });
  return found == end ? nullptr : &*found;
}

ContactDamping::TouchedPart& ContactDamping::TouchedParts::find_or_add(int part) noexcept {
  for (std::size_t i = 0; i < count; ++i) {
    if (all[i].part == part) return all[i];
  }
  TouchedPart& touched = all[count++];
  touched.part = part;
  return touched;
}

// Limits the sum over all contacts to the largest coefficient of a contact: a material that is stable alone stays so. If upper_bound is
// within that limit, as in the common case that one face is touched, no eigenvalues are computed.
void ContactDamping::limit(TouchedParts& touched_now) const noexcept {
  Mat3 sum = Mat3::Zero();
  double most = 0.0;
  double upper_bound = 0.0;
  for (std::size_t i = 0; i < touched_now.count; ++i) {
    const TouchedPart& one = touched_now.all[i];
    most = std::max(most, one.largest);
    upper_bound += one.upper_bound;
    sum += one.normal.matrix.topLeftCorner<3, 3>() + one.along.matrix.topLeftCorner<3, 3>();
  }
  if (upper_bound <= most * (1.0 + 0x1p-40)) return;
  const double largest = Eigen::SelfAdjointEigenSolver<Mat3>(sum, Eigen::EigenvaluesOnly).eigenvalues()[2];
  if (!(largest > most)) return;
  for (std::size_t i = 0; i < touched_now.count; ++i) {
    touched_now.all[i].normal.scale(most / largest);
    touched_now.all[i].along.scale(most / largest);
  }
}

// Low-pass filter: the damping of each touched part approaches its present value, and that of the other parts approaches zero, so the sum
// over all parts is filtered, too.
void ContactDamping::blend(TouchedParts& touched_now, double share) const noexcept {
  const std::size_t touched = touched_now.count;
  for (std::size_t i = 0; i < touched; ++i) {
    TouchedPart& one = touched_now.all[i];
    const TouchedPart* before = touched_parts_.find(one.part);
    one.normal.blend(before != nullptr ? before->normal : DampingMatrix(), share);
    one.along.blend(before != nullptr ? before->along : DampingMatrix(), share);
  }
  for (std::size_t i = 0; i < touched_parts_.count && touched_now.count < touched_now.all.size(); ++i) {
    const TouchedPart& before = touched_parts_.all[i];
    const double remaining = before.remaining * (1.0 - share);
    if (remaining < kMinRemaining || touched_now.find(before.part) != nullptr) continue;
    TouchedPart& one = touched_now.all[touched_now.count++];
    one = before;
    one.remaining = remaining;
    one.contact_n *= 1.0 - share;
    one.normal.scale(1.0 - share);
    one.along.scale(1.0 - share);
  }
}

ContactDamping::Wrench ContactDamping::step(std::span<const Contact> contacts, bool is_held) noexcept {
  contacts = contacts.first(std::min(contacts.size(), kMaxContacts));
  TouchedParts touched_now;
  for (const Contact& contact : contacts) {
    if (!(contact.force_n > 0.0) || !has_damping(contact.part)) continue;
    double normal_load_n = 0.0;
    for (const Contact& other : contacts) normal_load_n += std::max(0.0, other.force_n) * std::max(0.0, contact.normal.dot(other.normal));
    add(contact, std::max(normal_load_n, contact.force_n), touched_now.find_or_add(contact.part));
  }
  const double share = dt_s_ / (kSmoothS + dt_s_);
  dt_s_ = 0.0;
  limit(touched_now);
  if (!is_held) touched_now.count = 0;
  if (is_held) blend(touched_now, share);
  Vec6 sum = Vec6::Zero();
  for (std::size_t i = 0; i < touched_now.count; ++i) {
    TouchedPart& touched = touched_now.all[i];
    const Vec6 velocity = relative_velocity(touched.part);
    touched.force = touched.normal.force(velocity, touched.contact_n) + touched.along.force(velocity, touched.contact_n);
    sum += touched.force;
  }
  touched_parts_ = touched_now;
  return {sum.head<3>(), sum.tail<3>()};
}

ContactDamping::Wrench ContactDamping::wrench_of_part(int part) const noexcept {
  const TouchedPart* touched = touched_parts_.find(part);
  return touched == nullptr ? Wrench() : Wrench{touched->force.head<3>(), touched->force.tail<3>()};
}

}  // namespace hapton
