#include "core/force/sphere/local_minimum.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/math/straight_motion.h"

namespace hapton {
namespace {

constexpr double kShallow = 0x1p-30;  // a barrier of at most this height does not count: the contact offset of the reference

// Returns the contact of a frame that a new contact replaces. The normal of the new one is a linear combination of the frame's. As its
// multiplier grows, theirs change, and that of the replaced contact reaches zero first. from_device: from the device to the centre.
int find_replaced(const ContactFrame& frame, const Vec3& normal, const Vec3& from_device) noexcept {
  int replaced = frame.count - 1;
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < frame.count; ++i) {
    const double share = frame.dual[i].dot(normal);
    const double grown = std::max(0.0, frame.dual[i].dot(from_device)) / share;
    if (!(share > 0.0) || !(grown < least)) continue;
    least = grown;
    replaced = i;
  }
  return replaced;
}

}  // namespace

double LocalMinimum::find_stability(const Vec3& c, const Vec3& device) const noexcept {
  ContactFrame frame;
  return contacts_.find_frame(c, frame) ? find_stability(frame, c, device) : 1.0;
}

double LocalMinimum::find_stability(const ContactFrame& frame, const Vec3& c, const Vec3& device) const noexcept {
  if (contacts_.active_count() == 1) return contacts_[0].is_curved() ? 1.0 - frame.normal[0].dot(c - device) / contacts_.offset() : 1.0;
  double stability = 1.0;
  for (int i = 0; i < contacts_.active_count(); ++i) {
    stability -= std::max(0.0, frame.dual[i].dot(c - device)) * contacts_[i].curvature(frame.along, contacts_.offset());
  }
  return stability;
}

double LocalMinimum::find_turn(const Vec3& displacement) const noexcept {
  double most = 0.0;
  for (int i = 0; i < contacts_.active_count(); ++i) {
    if (!contacts_[i].is_curved()) continue;
    const Vec3& axis = contacts_[i].axis;
    most = std::max(most, (displacement - axis.dot(displacement) * axis).norm());
  }
  return most / contacts_.offset();
}

bool LocalMinimum::solve(const Vec3& device, Vec3& c, int& work) const noexcept {
  constexpr double kMinOff = 0x1p-40;  // local units: nearer to an edge or a vertex, the device has no direction from it
  if (contacts_.active_count() > 1) return contacts_.active_count() == 3 || solve_on_curve(device, c, work);
  const OffsetContact& contact = contacts_[0];
  const OffsetContact::Proximity at = contact.proximity(device);
  if (contact.is_curved() && (!(at.distance > kMinOff) || !(at.normal.dot(contact.proximity(c).normal) > 0.0))) return false;
  c = device + (contacts_.offset() - at.distance) * at.normal;
  return true;
}

bool LocalMinimum::solve_on_curve(const Vec3& device, Vec3& c, int& work) const noexcept {
  constexpr int kMaxRounds = 16;      // rounds of Newton's method; a bound on the work
  constexpr double kMaxSheer = 64.0;  // squared length of a dual vector; with shorter ones, two faces reach their common line in one step
  const bool is_line = contacts_.is_flat();
  Vec3 along = Vec3::Zero();
  for (int round = 0; round < kMaxRounds; ++round) {
    ++work;
    ContactFrame frame;
    if (!contacts_.find_frame(c, frame)) return false;
    // Two offset surfaces can meet in two curves, one on either side of a crest: stay on the same one.
    if (round == 0) along = frame.along;
    if (!(frame.along.dot(along) > 0.0)) return false;
    const double stability = is_line ? 1.0 : find_stability(frame, c, device);
    if (!(stability > kMinStability)) return false;
    const double ahead = frame.along.dot(device - c) / stability;
    if (!is_line && find_turn(ahead * frame.along) > 2.0 * kTurn) return false;
    c += ahead * frame.along + frame.short_by[0] * frame.dual[0] + frame.short_by[1] * frame.dual[1];
    if (is_line && frame.dual[0].squaredNorm() <= kMaxSheer) return true;
    const double step = std::max({std::fabs(ahead), std::fabs(frame.short_by[0]), std::fabs(frame.short_by[1])});
    if (step <= std::max(0x1p-26 * contacts_.offset(), 0x1p-50))
      return step <= contacts_.clearance().tolerance || contacts_.restore(c, work);
  }
  return contacts_.restore(c, work);
}

Vec3 LocalMinimum::find_rate(const Vec3& c, const Vec3& device, const Vec3& motion) const noexcept {
  ContactFrame frame;
  if (!contacts_.find_frame(c, frame)) return Vec3::Zero();
  if (contacts_.active_count() == 2) {
    const double stability = find_stability(frame, c, device);
    return frame.along * (frame.along.dot(motion) / (stability > 0.0 ? std::max(stability, 0x1p-20) : std::min(stability, -0x1p-20)));
  }
  const OffsetContact& contact = contacts_[0];
  const Vec3& normal = frame.normal[0];
  const Vec3 sideways = motion - normal.dot(motion) * normal;
  if (contact.part == Feature::face) return sideways;
  const double near = contacts_.offset() - normal.dot(c - device);
  const double gain = contacts_.offset() / std::max(near, 0x1p-40);
  if (contact.part == Feature::vertex) return gain * sideways;
  const Vec3& axis = contact.axis;
  const double straight = axis.dot(motion);
  return gain * (sideways - straight * axis) + straight * axis;
}

double LocalMinimum::longest_on_curve(const ContactFrame& frame, const Vec3& direction) const noexcept {
  Vec3 bend = Vec3::Zero();
  for (int i = 0; i < 2; ++i) bend += contacts_[i].curvature(direction, contacts_.offset()) * frame.dual[i];
  return kTurn / std::max({find_turn(direction), bend.norm(), 0x1p-10});
}

bool LocalMinimum::is_on_axis(const Vec3& device) const noexcept {
  return contacts_.active_count() == 1 && contacts_[0].is_curved() && contacts_[0].proximity(device).distance <= kAtAxis;
}

double LocalMinimum::time_off_axis(const Vec3& from, const Vec3& to, double time) const noexcept {
  const OffsetContact& contact = contacts_[0];
  const Vec3& axis = contact.axis;
  const auto across = [&](const Vec3& v) { return Vec3(v - axis.dot(v) * axis); };
  const Vec3 off = across(on_path(from, to, time) - contact.origin());
  const Vec3 motion = across(to - from);
  // |off + s motion| = 4 kAtAxis
  const double a = motion.squaredNorm();
  const double b = off.dot(motion);
  const double c = 16.0 * kAtAxis * kAtAxis - off.squaredNorm();
  if (!(a > 0.0)) return 1.0;
  return std::min(1.0, time + c / (b + std::sqrt(b * b + a * c)));
}

// Whether a climb by kShallow leads out of a minimum: over all contacts but one, away from that one, where edges and vertices bend the path
// down. The path begins with the slope a and bends down with the curvature b: it climbs by a^2 / 2b.
bool LocalMinimum::is_shallow(const Vec3& c, const Vec3& device, Vec3& direction) const noexcept {
  ContactFrame frame;
  if (contacts_.count() < 2 || !contacts_.find_frame(c, frame)) return false;
  for (int j = 0; j < contacts_.active_count(); ++j) {
    ContactFrame others;
    std::array<const OffsetContact*, 2> other_contacts{};
    for (int i = 0; i < contacts_.active_count(); ++i) {
      if (i == j) continue;
      other_contacts[others.count] = &contacts_[i];
      others.normal[others.count++] = frame.normal[i];
    }
    if (!others.prepare()) continue;
    const Vec3 off = frame.normal[j] - others.normal[0] * others.normal[0].dot(frame.normal[j]);
    direction = others.count == 1 ? off : Vec3(others.along * (others.along.dot(frame.normal[j]) < 0.0 ? -1.0 : 1.0));
    if (!(direction.norm() > 0.0)) continue;
    direction.normalize();
    const double slope = std::max(0.0, direction.dot(c - device));
    double turn = -1.0;
    for (int i = 0; i < others.count; ++i) {
      turn += std::max(0.0, others.dual[i].dot(c - device)) * other_contacts[i]->curvature(direction, contacts_.offset());
    }
    if (turn > 0.0 && slope * slope <= 2.0 * kShallow * turn) return true;
  }
  return false;
}

void activate_opposing(ContactSet& contacts, const Vec3& c, const Vec3& device, const Vec3& motion) noexcept {
  while (contacts.active_count() < 3 && contacts.active_count() < contacts.count()) {
    const Vec3 rate = LocalMinimum(contacts).find_rate(c, device, motion);
    int opposing = -1;
    double least = 0.0;
    for (int i = contacts.active_count(); i < contacts.count(); ++i) {
      const double leaving_rate = contacts[i].proximity(c).normal.dot(rate);
      if (!(leaving_rate < least)) continue;
      least = leaving_rate;
      opposing = i;
    }
    if (opposing < 0) return;
    contacts.activate(opposing);
    ContactFrame frame;
    if (contacts.find_frame(c, frame)) continue;
    // The new contact depends linearly on the others, and replaces one of them.
    const OffsetContact& added = contacts[contacts.deactivate_last()];
    if (!contacts.find_frame(c, frame)) return;
    contacts[find_replaced(frame, added.proximity(c).normal, c - device)] = added;
    return;
  }
}

}  // namespace hapton
