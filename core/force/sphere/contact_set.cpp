#include "core/force/sphere/contact_set.h"

#include <algorithm>
#include <cmath>

#include "core/force/contact_qp.h"

namespace hapton {
namespace {

// Length of the device's motion that is added to a pull: where constraints balance, the motion decides.
constexpr double kNudge = 0x1p-42;

}  // namespace

bool ContactSet::add(const OffsetContact& contact) noexcept {
  int at = count_;
  for (int i = 0; i < count_; ++i) {
    if (contacts_[i].triangle == contact.triangle) at = i;
  }
  if (at == kMax) return false;
  contacts_[at] = contact;
  if (at == count_) ++count_;
  return true;
}

void ContactSet::hold_by(std::span<const OffsetContact> contacts) noexcept {
  std::copy(contacts.begin(), contacts.end(), contacts_.begin());
  active_count_ = count_ = static_cast<int>(contacts.size());
}

void ContactSet::keep_only(int i) noexcept {
  std::swap((*this)[0], (*this)[i]);
  active_count_ = count_ = 1;
}

void ContactSet::remove(int i) noexcept {
  for (int k = i + 1; k < count_; ++k) contacts_[k - 1] = contacts_[k];
  --count_;
  active_count_ = std::min(active_count_, count_);
}

bool ContactSet::find_active(const Vec3& c, const Vec3& pull, const Vec3& motion, Vec3& descent) noexcept {
  const double length = motion.norm();
  const Vec3 goal = length > 0.0 ? Vec3(pull + motion * (kNudge / length)) : pull;
  if (count_ == 1) {
    const Vec3 normal = contacts_[0].proximity(c).normal;
    const double height = normal.dot(goal);
    active_count_ = height < 0.0 ? 1 : 0;
    descent = goal - height * normal;
    return true;
  }
  std::array<ContactPlane, kMax> planes;
  for (int i = 0; i < count_; ++i) planes[i] = {contacts_[i].proximity(c).normal, 0.0};
  const ConstrainedMotion constrained = constrain_motion(goal, std::span(planes).first(count_));
  if (!constrained.solved) return false;
  descent = constrained.motion;
  active_count_ = constrained.active_count;
  std::array<int, 3> at = constrained.active;
  for (int i = 0; i < active_count_; ++i) {
    if (at[i] == i) continue;
    std::swap(contacts_[i], contacts_[at[i]]);
    for (int j = i + 1; j < active_count_; ++j) {
      if (at[j] == i) at[j] = at[i];  // that contact was moved to make room
    }
  }
  return true;
}

bool ContactSet::is_held_twice(int i) const noexcept {
  const OffsetContact& own = contacts_[i];
  return std::ranges::any_of(active(), [&](const OffsetContact& other) { return &other != &own && other.is_same_part(own); });
}

bool ContactSet::touches_all(const Vec3& c) const noexcept {
  constexpr double kTouches = 0x1p-36;  // local units: far above rounding, 2^-51, and far below the contact offset, 2^-30
  return std::ranges::all_of(all(), [&](const auto& contact) { return contact.proximity(c).distance <= clearance_.offset + kTouches; });
}

bool ContactSet::find_frame(const Vec3& c, ContactFrame& frame) const noexcept {
  frame.measure(active(), c, clearance_.offset);
  return frame.prepare();
}

void ContactSet::guide(CentrePath& path) const noexcept {
  for (int i = 0; i < active_count_; ++i) path.add_guide(contacts_[i].guide(clearance_.offset));
}

bool ContactSet::restore(Vec3& c, int& work) const noexcept {
  ContactFrame frame;
  bool has_normals = false;
  return restore(c, frame, has_normals, work);
}

bool ContactSet::restore_to_frame(Vec3& c, ContactFrame& frame, int& work) const noexcept {
  bool has_normals = false;
  return restore(c, frame, has_normals, work) && (has_normals ? frame.prepare() : find_frame(c, frame));
}

// `has_normals`: whether the frame's normals are those at the restored c.
bool ContactSet::restore(Vec3& c, ContactFrame& frame, bool& has_normals, int& work) const noexcept {
  constexpr int kMaxRounds = 8;  // rounds of Newton's method; after these the tolerance decides
  for (int round = 0; round < kMaxRounds; ++round) {
    ++work;
    frame.measure(active(), c, clearance_.offset);
    double most = 0.0;
    for (int i = 0; i < active_count_; ++i) most = std::max(most, std::fabs(frame.short_by[i]));
    has_normals = most <= 0x1p-51;
    if (has_normals) return true;
    if (most > clearance_.offset || !frame.prepare()) return false;
    for (int i = 0; i < active_count_; ++i) c += frame.short_by[i] * frame.dual[i];
    if (most <= 0x1p-26 * clearance_.offset && active_count_ == 1) return true;
  }
  return std::ranges::all_of(active(), [&](const OffsetContact& contact) {
    return std::fabs(clearance_.offset - contact.proximity(c).distance) <= clearance_.tolerance;
  });
}

double ContactSet::find_most_opposite(const Vec3& c) const noexcept {
  std::array<Vec3, kMax> normals;
  double least = 4.0;
  for (int i = 0; i < active_count_; ++i) {
    normals[i] = contacts_[i].proximity(c).normal;
    for (int k = 0; k < i; ++k) least = std::min(least, (normals[i] + normals[k]).squaredNorm());
  }
  return least;
}

bool ContactSet::holds_part_of(const ObjectGeometry::Corners& corners, std::uint32_t triangle) const noexcept {
  return std::ranges::any_of(active(), [&](const OffsetContact& contact) {
    return contact.triangle == triangle || contact.is_shared_with(corners.a, corners.b, corners.c);
  });
}

unsigned ContactSet::guiding_corners(const ContactTriangle& shape) const noexcept {
  unsigned guiding = 0;
  for (int i = 0; i < active_count_; ++i) {
    const OffsetContact& contact = contacts_[i];
    if (!contact.is_curved()) continue;
    for (int k = 0; k < 3; ++k) {
      const Vec3& corner = shape.corner(k);
      const bool is_end = contact.part == Feature::edge && corner == contact.end();
      if (is_end || corner == contact.origin()) guiding |= 1U << k;
    }
  }
  return guiding;
}

void ContactSet::note_multipliers(const Vec3& c, const Vec3& device) noexcept {
  ContactFrame frame;
  if (count_ == 0 || !find_frame(c, frame)) return;
  for (int i = 0; i < active_count_; ++i) contacts_[i].multiplier = std::max(0.0, frame.dual[i].dot(c - device));
}

}  // namespace hapton
