#include "core/force/sphere/corner_exit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include "core/force/contact_qp.h"

namespace hapton {
namespace {

constexpr double kApexRadius = 32.0;         // offsets; a corner within this distance of the centre is taken as the apex
constexpr double kMaxApexDistance = 4096.0;  // offsets; so far from its tip a wedge of 0.028 degrees holds the sphere

// The position nearest to the planes, lines and points of contacts on faces, edges and vertices: the sum of the squared distances from them
// is least. False: it is not unique within rounding, or farther than `within` from one of them.
bool find_meeting(std::span<const OffsetContact> contacts, const Vec3& near, double within, Vec3& meeting) {
  constexpr double kMinVolume = 0x1p-44;  // of unit vectors: below it they count as lying in one plane
  Mat3 sum = Mat3::Zero();
  Vec3 right_hand_side = Vec3::Zero();
  for (const OffsetContact& contact : contacts) {
    Mat3 across = Mat3::Identity();
    if (contact.part == Feature::face) across = contact.normal * contact.normal.transpose();
    if (contact.part == Feature::edge) across -= contact.axis * contact.axis.transpose();
    sum += across;
    right_hand_side += across * (contact.origin() - near);
  }
  if (!(sum.determinant() > kMinVolume)) return false;
  const Vec3 off = sum.inverse() * right_hand_side;
  meeting = near + off;
  return std::ranges::all_of(contacts, [&](const auto& contact) { return std::fabs(contact.proximity(meeting).distance) <= within; });
}

}  // namespace

// The vertex near the centre, or the point where three faces that hold the centre meet, or the vertex that three contacts have in common:
// in a narrow corner the centre is far from its apex.
bool CornerExit::find_apex(Vec3& apex) const noexcept {
  double nearest = kApexRadius * contacts_.offset();
  bool any = false;
  for (int i = 0; i < contacts_.count(); ++i) {
    for (int k = 0; k < 3; ++k) {
      const Vec3& corner = contacts_[i].shape.corner(k);
      const double distance = (corner - centre_).norm();
      if (!(distance < nearest)) continue;
      nearest = distance;
      apex = corner;
      any = true;
    }
  }
  if (any) return true;
  ContactFrame frame;
  if (contacts_.active_count() != 3 || !contacts_.find_frame(centre_, frame)) return false;
  if (!contacts_.is_flat()) {
    return find_common_corner(apex) || (find_meeting(contacts_.active(), centre_, 0.5 * kThrough * contacts_.offset(), apex) &&
                                        (apex - centre_).norm() <= kMaxApexDistance * contacts_.offset());
  }
  apex = centre_;
  for (int i = 0; i < 3; ++i) apex -= contacts_.offset() * frame.dual[i];
  return (apex - centre_).norm() <= kMaxApexDistance * contacts_.offset();
}

bool CornerExit::find_common_corner(Vec3& apex) const noexcept {
  for (int k = 0; k < 3; ++k) {
    const Vec3& corner = contacts_[0].shape.corner(k);
    const auto has_it = [&](const OffsetContact& contact) {
      return contact.shape.corner(0) == corner || contact.shape.corner(1) == corner || contact.shape.corner(2) == corner;
    };
    if (!((corner - centre_).norm() <= kMaxApexDistance * contacts_.offset())) continue;
    if (!std::ranges::all_of(contacts_.active(), has_it)) continue;
    apex = corner;
    return true;
  }
  return false;
}

bool CornerExit::find_cone(double moved) noexcept {
  if ((centre_ - memory_.at).norm() <= moved) return memory_.has_cone;
  memory_.at = centre_;
  memory_.has_cone = false;
  Vec3 apex;
  if (!find_apex(apex)) return false;
  const double near = kThrough * contacts_.offset();
  const double radius = near + (apex - centre_).norm();
  if (!near_.reach(centre_, radius, work_)) return false;
  memory_.cone.begin(apex);
  bool fits = true;
  bool is_between = false;
  near_.visit_near(apex, apex, near, [&](int slot) {
    const ContactTriangle& shape = near_.shape(slot);
    if (!(shape.separation(apex).distance <= near) || !near_.can_touch(near_.triangle(slot), shape, centre_)) return;
    fits = fits && memory_.cone.add(shape, near);
    const double above_plane = shape.normal().dot(centre_ - shape.corner(0));
    is_between |= above_plane * shape.normal().dot(centre_ - apex) < 0.0;
    ++work_;
  });
  Vec3 beside = centre_;
  fits = fits && (!is_between || find_beside(apex, beside));
  memory_.has_cone = fits && memory_.cone.find_boundary((beside - apex).normalized());
  return memory_.has_cone;
}

// In the cone the planes of all faces go through the apex. If a face lies beyond the apex, nearer to it than kThrough, the centre may then
// seem to be on the wrong side of the face. Finds the nearest position that is on the same side of these planes as the centre is of the
// faces. The position is in the ball around the centre that no triangle reaches. False: there is none.
bool CornerExit::find_beside(const Vec3& apex, Vec3& beside) noexcept {
  constexpr double kClear = 0x1p-4;  // offsets from a plane
  constexpr int kMaxFaces = 48;      // with more faces none is searched for; a free choice
  const double near = kThrough * contacts_.offset();
  std::array<ContactPlane, kMaxFaces> planes;
  int count = 0;
  bool fits = true;
  bool is_between = false;
  near_.visit_near(apex, apex, near, [&](int slot) {
    const ContactTriangle& shape = near_.shape(slot);
    if (!(shape.separation(apex).distance <= near) || !near_.can_touch(near_.triangle(slot), shape, centre_)) return;
    ++work_;
    const Separation at = shape.separation(centre_);
    if (at.feature != Feature::face) return;
    const double height = at.normal.dot(centre_ - apex);
    is_between |= height < 0.0;
    fits = fits && count < kMaxFaces;
    if (fits) planes[count++] = {at.normal, kClear * contacts_.offset() - height};
  });
  if (!fits || !is_between) return fits;
  const ConstrainedMotion aside = constrain_motion(Vec3::Zero(), std::span(planes).first(count));
  beside = centre_ + aside.motion;
  return aside.solved && aside.motion.norm() < contacts_.offset();
}

double CornerExit::least_exit(const Vec3& pull) const noexcept { return std::sqrt(8.0 * kMinGain * contacts_.offset() * pull.norm()); }

double CornerExit::time_to_exit(const Vec3& from, const Vec3& to, double time) noexcept {
  if (!find_cone(4.0 * contacts_.offset())) return 2.0;
  const Vec3 pull = from - memory_.cone.apex();
  const Vec3 pull_then = to - memory_.cone.apex();
  const double least = 1.0625 * std::max(least_exit(pull), least_exit(pull_then));
  double soonest = 2.0;
  for (const TangentCone::Piece& piece : memory_.cone.boundary()) {
    const double there = piece.to.dot(pull_then) - least;
    if (!(there > 0.0)) continue;
    const double here = std::min(piece.to.dot(pull) - least, 0.0);
    soonest = std::min(soonest, std::max(time, here / (here - there)));
  }
  return soonest;
}

double CornerExit::distance_off_edge(const TangentCone::Steepest& to) const noexcept {
  const TangentCone::Piece& piece = memory_.cone.boundary()[to.piece];
  const double half = to.direction == piece.to ? 0.5 * piece.opening : 0.5 * std::numbers::pi;
  return kAbove * contacts_.offset() / (half < 0.5 * std::numbers::pi ? std::sin(half) : 1.0);
}

std::optional<Vec3> CornerExit::find_past(const TangentCone::Steepest& to, double radius) const noexcept {
  const TangentCone::Piece& piece = memory_.cone.boundary()[to.piece];
  const double half = to.direction == piece.to ? 0.5 * piece.opening : 0.5 * std::numbers::pi;
  const double off = distance_off_edge(to);
  if (!(kMaxOff * off < radius)) return std::nullopt;
  return memory_.cone.apex() + radius * to.direction + off * (std::cos(half) * piece.back + std::sin(half) * piece.normal);
}

bool CornerExit::can_pass(const Vec3& target, double radius) noexcept {
  const Vec3& apex = memory_.cone.apex();
  const double within = 1.25 * radius;
  if (!((centre_ - apex).norm() < radius) || !near_.covers(apex, within) || !memory_.cone.contains((target - apex).normalized()))
    return false;
  bool is_free = true;
  near_.visit_near(apex, apex, within, [&](int slot) {
    ++work_;
    const ContactTriangle& shape = near_.shape(slot);
    const double distance = shape.separation(apex).distance;
    if (!is_free || distance > within || !near_.can_touch(near_.triangle(slot), shape, centre_)) return;
    const Separation at = shape.separation(target);
    is_free = distance <= kThrough * contacts_.offset() && at.distance >= contacts_.offset() &&
              (at.feature != Feature::face || at.normal.dot(target - apex) > 0.0) &&
              (memory_.cone.is_around_start() || near_.geometry().pierce(near_.triangle(slot), centre_, target).time > 1.0);
  });
  return is_free && !is_beyond_surface(target, within);
}

// Where the surface around the corner is closed and oriented, a target is beyond it if the path to the target does not cross it as often
// inwards as outwards. Triangles smaller than the sphere are not sides of the cone, so the cone's boundary may lead through them. False:
// not beyond, or the surface may have an end. Edges without an adjacent triangle that run to and fro, within what counts as a closed crack,
// are not an end: they are left where needles were removed (touch_resolution.h).
bool CornerExit::is_beyond_surface(const Vec3& target, double within) noexcept {
  const Vec3& apex = memory_.cone.apex();
  Vec3 gap = Vec3::Zero();
  Vec3 area = Vec3::Zero();
  bool is_two_sided = true;
  int balance = 0;
  near_.visit_near(apex, apex, within, [&](int slot) {
    const ContactTriangle& shape = near_.shape(slot);
    if (shape.separation(apex).distance > within) return;
    const std::uint32_t id = near_.triangle(slot);
    is_two_sided &= near_.material(id).two_sided;
    for (int k = 0; k < 3; ++k) {
      const TouchGeometry::Adjacent beside = near_.geometry().adjacent(id, k);
      if (beside.exists && !beside.flips) continue;
      const EdgeSpan span = edge_span_within(shape, k, apex, within);
      const Vec3 from = shape.corner(k) - apex + span.begin * shape.edge(k);
      const Vec3 along = (span.end - span.begin) * shape.edge(k);
      gap += along;
      area += 0.5 * from.cross(along);
    }
    const TouchGeometry::Hit hit = near_.geometry().pierce(id, centre_, target);
    if (hit.time <= 1.0) balance += hit.from_back ? 1 : -1;
  });
  const double crack = kThrough * contacts_.offset();
  return balance != 0 && is_two_sided && gap.norm() <= crack && area.norm() <= crack * within;
}

// The shares of edge k between which the edge is nearer to p than `within`; an empty span if it nowhere is.
CornerExit::EdgeSpan CornerExit::edge_span_within(const ContactTriangle& shape, int k, const Vec3& p, double within) {
  const double middle = shape.along(k, p);
  const double squared = within * within - (shape.corner(k) + middle * shape.edge(k) - p).squaredNorm();
  if (!(squared > 0.0) || !(shape.length(k) > 0.0)) return {0.0, 0.0};
  const double half = std::sqrt(squared) / shape.length(k);
  const double begin = std::clamp(middle - half, 0.0, 1.0);
  return {begin, std::max(begin, std::min(1.0, middle + half))};
}

}  // namespace hapton
