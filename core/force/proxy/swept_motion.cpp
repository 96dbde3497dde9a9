#include "core/force/proxy/swept_motion.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hapton {
namespace {

constexpr double kLongestMotion = 4.0;    // local units: twice the scene's size
constexpr double kFarthestGoal = 0x1p10;  // local units: a device farther out would cost significant digits
constexpr double kFirstPiece = 0x1p-6;    // of a motion
constexpr double kGrowth = 4.0;           // from one piece to the next
constexpr int kMostTests = 128;           // triangles in the box of a piece; if there are more, it is cut

// Limits a motion to the length that crosses the scene.
Vec3 shortened(const Vec3& motion) {
  const double length = motion.norm();
  return length > kLongestMotion ? Vec3(motion * (kLongestMotion / length)) : motion;
}

}  // namespace

// Every motion leads nearer to the device or adds an active constraint.
bool SweptMotion::descend(ProxyState& proxy, const Vec3& device, int most_work) noexcept {
  work_ = 0;
  most_work_ = most_work;
  proxy.active_count = 0;  // until it has settled
  if (is_shrunk()) grow_to_room(proxy.position);
  const double least_motion = keep_.tolerance;  // shorter motions are below the tolerance of the clearance
  constexpr double kRounding = 0x1p-48;         // share of a distance within the scene
  constexpr double kNormalError = 0x1p-24;      // share of the goal: error of an edge's normal at the contact offset (point_triangle.h)
  double nearest = std::numeric_limits<double>::infinity();
  int idle = 0;
  bool has_forgotten = false;
  for (int i = 0; i < kMostMotions && work_ <= most_work_; ++i) {
    work_ += kWorkOfMotion;
    if (proxy.contact_count == 0 && cross_empty_space(proxy, device)) return true;
    Vec3 goal = device - proxy.position;
    const double distance = goal.norm();
    const bool arrives = distance <= kLongestMotion;
    if (distance > kFarthestGoal) goal *= kFarthestGoal / distance;
    idle = distance < nearest - kRounding ? 0 : idle + 1;
    nearest = std::min(nearest, distance);
    if (idle > kMostIdle && proxy.contact_count > 0) {  // moving back and forth within the slop of the clearance
      if (is_too_near(proxy) && shrink_to_room(proxy.position)) {
        idle = 0;
        continue;
      }
      proxy.active_count = 1;
      proxy.multipliers[0] = distance;
      return true;
    }
    if (proxy.contact_count == 0) {
      if (advance(proxy, shortened(goal))) {
        proxy.is_free = false;
      } else if (arrives) {
        proxy.settle_at(device);
        return true;
      }
      continue;
    }
    ++counters_.motions;
    const ConstrainedMotion constrained = next_motion(proxy, goal);
    const Vec3 motion = surfaces_.has_friction() ? apply_friction(proxy, goal, constrained) : constrained.motion;
    if (motion.norm() <= least_motion + kNormalError * distance) {
      if (!has_forgotten && forget_doubtful(proxy, constrained)) {
        has_forgotten = true;
        continue;
      }
      bring_active_first(proxy, constrained);
      return true;
    }
    if (!advance(proxy, shortened(motion)) && constrained.active_count == 0 && arrives) {
      proxy.settle_at(device);
      return true;
    }
  }
  ++counters_.unconverged;
  return false;
}

// Far outside the scene there are no contacts and positions are coarse: the proxy goes straight to the device (true), or to where its path
// enters the scene's surroundings.
bool SweptMotion::cross_empty_space(ProxyState& proxy, const Vec3& device) const noexcept {
  const double surroundings = 2.0 + 2.0 * keep_.offset;
  if (proxy.position.norm() <= 1.01 * surroundings) return false;
  const Vec3 path = device - proxy.position;
  const double length = path.norm();
  const Vec3 direction = length > 0.0 ? Vec3(path / length) : Vec3::Zero();
  const double closest_at = -proxy.position.dot(direction);
  const double miss = (proxy.position + closest_at * direction).norm();
  const double entry = closest_at - std::sqrt(std::max(0.0, (surroundings - miss) * (surroundings + miss)));
  if (miss >= surroundings || entry <= 0.0 || entry >= length) {
    proxy.settle_at(device);
    return true;
  }
  proxy.position += entry * direction;
  return false;
}

// Contacts that are too near lift the proxy. Where they leave no room for that, as in a slit narrower than the probe, it is as small as the
// room. Between walls that are parallel within rounding, planes with no room between them meet far away. And if there are more contacts
// than are kept, those that are left out would stop each motion at once.
ConstrainedMotion SweptMotion::next_motion(const ProxyState& proxy, const Vec3& goal) noexcept {
  constexpr double kFarthestLift = 8.0;  // offsets
  const auto constrain = [&] {
    for (int i = 0; i < proxy.contact_count; ++i) {
      const Separation& s = proxy.contacts[i].separation;
      planes_[i] = {s.normal, keep_.offset - s.distance};
    }
    return constrain_motion(goal, std::span<const ContactPlane>(planes_.data(), static_cast<std::size_t>(proxy.contact_count)));
  };
  const ConstrainedMotion constrained = constrain();
  const bool knows_all = proxy.contact_count < ProxyState::kMostContacts;
  const bool has_room = knows_all && constrained.solved && constrained.motion.norm() <= goal.norm() + kFarthestLift * keep_.offset;
  if (has_room || !is_too_near(proxy) || !shrink_to_room(proxy.position)) return constrained;
  return constrain();
}

bool SweptMotion::is_too_near(const ProxyState& proxy) const noexcept {
  return std::any_of(proxy.contacts.begin(), proxy.contacts.begin() + proxy.contact_count,
                     [&](const ProxyContact& contact) { return keep_.offset - contact.separation.distance > 2.0 * keep_.slop; });
}

double SweptMotion::find_room(const Vec3& p) noexcept {
  double room = clearance_.offset;
  surfaces_.geometry().visit_nearest(p, room * room, [&](std::uint32_t triangle, double) {
    ++work_;
    if (surfaces_.can_touch(triangle, p)) room = std::min(room, surfaces_.geometry().separation(triangle, p).distance);
    return room * room;
  });
  return room;
}

// False: the centre is on a surface, or the proxy is as small already.
bool SweptMotion::shrink_to_room(const Vec3& p) noexcept {
  const double room = find_room(p);
  if (room <= 2.0 * keep_.slop || room >= keep_.offset) return false;
  keep_.offset = room;
  return true;
}

// It never pushes the proxy: where a surface holds it, there is no more room. In a passage of changing width a sphere as large as the room
// would stop at each narrower place.
void SweptMotion::grow_to_room(const Vec3& p) noexcept {
  constexpr double kShare = 0.5;
  const double room = find_room(p);
  keep_.offset = room >= clearance_.offset - clearance_.slop ? clearance_.offset : std::max(keep_.offset, kShare * room);
}

// Coulomb friction: the frictionless goal is `depth` above the device; the proxy may stay up to mu * depth short of the goal.
Vec3 SweptMotion::apply_friction(ProxyState& proxy, const Vec3& goal, const ConstrainedMotion& constrained) const noexcept {
  const Vec3& motion = constrained.motion;
  const Material material = material_of(proxy, constrained);
  const double depth = (goal - motion).norm();
  const double length = motion.norm();
  const double hold = (proxy.slides ? material.friction_dynamic : material.friction_static) * depth;
  if (length <= hold + keep_.slop) {
    if (length < 0.5 * material.friction_dynamic * depth) proxy.slides = false;
    return Vec3::Zero();
  }
  proxy.slides = true;
  return motion * (1.0 - material.friction_dynamic * depth / length);
}

Material SweptMotion::material_of(const ProxyState& proxy, const ConstrainedMotion& held) const noexcept {
  if (held.active_count == 0) return surfaces_.mean_material(proxy);
  ContactMaterial material;
  for (int i = 0; i < held.active_count; ++i)
    material.add(surfaces_.material_of(proxy.contacts[held.active[i]].triangle), held.multipliers[i]);
  return material.mean();
}

// An edge or vertex contact of a point probe may exist by rounding only: drops such contacts, so that the next sweep shows whether they
// block. Returns false if there are none.
bool SweptMotion::forget_doubtful(ProxyState& proxy, const ConstrainedMotion& held) const noexcept {
  if (!is_point_) return false;
  bool any = false;
  for (int i = 0; i < held.active_count; ++i) any |= proxy.contacts[held.active[i]].separation.feature != Feature::face;
  if (!any) return false;
  const auto end = std::remove_if(proxy.contacts.begin(), proxy.contacts.begin() + proxy.contact_count,
                                  [](const ProxyContact& contact) { return contact.separation.feature != Feature::face; });
  proxy.contact_count = static_cast<int>(end - proxy.contacts.begin());
  return true;
}

void SweptMotion::bring_active_first(ProxyState& proxy, const ConstrainedMotion& held) noexcept {
  std::array<int, 3> at = held.active;
  for (int i = 0; i < held.active_count; ++i) {
    if (at[i] == i) continue;
    std::swap(proxy.contacts[i], proxy.contacts[at[i]]);
    for (int j = i + 1; j < held.active_count; ++j) {
      if (at[j] == i) at[j] = at[i];  // swapped away above
    }
  }
  proxy.multipliers = held.multipliers;
  proxy.active_count = held.active_count;
}

// Moves the proxy along `motion` until something blocks it; returns true if blocked. contacts then has what it touches.
bool SweptMotion::advance(ProxyState& proxy, const Vec3& motion) noexcept {
  const double t = sweep(proxy, motion);
  const bool blocked = t <= 1.0;
  proxy.position += (blocked ? t : 1.0) * motion;
  update_contacts(proxy, blocked ? Vec3((1.0 - t) * motion) : Vec3::Zero());
  return blocked;
}

// The first time at which the moving proxy must stop; above 1: never. A long path is searched in growing pieces, because a blocker is
// mostly near the start; a piece whose box holds many triangles is cut, because most of them are far from the path, or because the probe
// reaches as many at the start. Out of work, the proxy stops at the end of a piece.
double SweptMotion::sweep(ProxyState& proxy, const Vec3& motion) noexcept {
  constexpr int kFewTests = 16;
  constexpr int kMostCuts = 4;
  ++counters_.sweeps;
  blocker_count_ = 0;
  const Vec3 from = proxy.position;
  double done = 0.0;
  double piece = kFirstPiece;
  for (int cuts = 0; done < 1.0;) {
    const double end = std::min(1.0, done + piece);
    const int most_tests = cuts < kMostCuts ? kMostTests : std::numeric_limits<int>::max();
    int tests = most_tests;
    const double first = find_blockers(proxy, from, motion, done, end, tests);
    if (first <= end && tests >= 0) return first;
    blocker_count_ = 0;
    if (tests < 0) {
      const double crowded = cuts == 0 ? find_crowded_piece(from, motion, done) : 0.0;
      cuts = crowded > 0.0 ? kMostCuts : cuts + 1;
      piece = crowded > 0.0 ? crowded : (end - done) / kGrowth;
      continue;
    }
    done = end;
    if (work_ > most_work_ && done < 1.0) return done;
    if (cuts == 0 || most_tests - tests <= kFewTests) piece *= kGrowth;
  }
  return kNever;
}

// Where the probe reaches more than kMostTests triangles without moving, short pieces hold no fewer: the longest piece that holds few
// others. 0: it does not.
double SweptMotion::find_crowded_piece(const Vec3& from, const Vec3& motion, double begin) const noexcept {
  constexpr double kFewOthers = 1.25;
  const auto count_until = [&](double end, int most) {
    int count = 0;
    const Box path = Box::around(from + begin * motion, from + end * motion).inflated(keep_.offset);
    surfaces_.geometry().for_each_overlapping(path, [&](std::uint32_t) { return ++count <= most; });
    return count;
  };
  const int here = count_until(begin, std::numeric_limits<int>::max());
  if (here <= kMostTests) return 0.0;
  const int most = static_cast<int>(kFewOthers * here);
  for (double piece = 1.0 - begin; piece > kFirstPiece / kGrowth; piece /= kGrowth) {
    if (count_until(begin + piece, most) <= most) return piece;
  }
  return 0.0;
}

// The first block on a piece of the motion, and what blocks there. `tests`: loses the number of triangles tested; negative: there were
// more, and the result says nothing.
double SweptMotion::find_blockers(ProxyState& proxy, const Vec3& from, const Vec3& motion, double begin, double end, int& tests) noexcept {
  const TouchGeometry& geometry = surfaces_.geometry();
  const Box path = Box::around(from + begin * motion, from + end * motion).inflated(keep_.offset);
  double first = kNever;
  geometry.for_each_overlapping(path, [&](std::uint32_t triangle) {
    if (--tests < 0) return false;
    const TriangleView shape{geometry, triangle};
    ++counters_.tests;
    ++work_;
    if (!is_point_) note_grazed(proxy, shape.separation(from), triangle);
    const double t = time_to_block(shape, from, motion, std::min(end, first), keep_);
    if (t > 1.0 || !surfaces_.can_touch(triangle, from)) return true;
    first = std::min(first, t);
    note_blocker(triangle, t);
    return true;
  });
  return first;
}

// A sphere on a face is also in contact with coplanar neighbours, although they never block its path.
void SweptMotion::note_grazed(ProxyState& proxy, const Separation& at, std::uint32_t triangle) const noexcept {
  if (at.distance > keep_.offset + 2.0 * keep_.tolerance || proxy.contact_count == ProxyState::kMostContacts) return;
  for (int i = 0; i < proxy.contact_count; ++i) {
    if (proxy.contacts[i].triangle == triangle) return;
  }
  proxy.contacts[proxy.contact_count++] = {.triangle = triangle, .shape = surfaces_.shape_of(triangle), .separation = at};
}

void SweptMotion::note_blocker(std::uint32_t triangle, double t) noexcept {
  int at = blocker_count_;
  if (at == ProxyState::kMostContacts) {  // full: replace the latest
    const auto latest =
        std::max_element(blockers_.begin(), blockers_.end(), [](const Blocker& a, const Blocker& b) { return a.time < b.time; });
    if (t >= latest->time) return;
    at = static_cast<int>(latest - blockers_.begin());
  } else {
    ++blocker_count_;
  }
  blockers_[at] = {triangle, t};
}

// After a motion: keeps the contacts that still touch and adds the blockers.
void SweptMotion::update_contacts(ProxyState& proxy, const Vec3& blocked_motion) const noexcept {
  const double bound = keep_.offset + 2.0 * keep_.tolerance;
  const auto blockers_end = blockers_.begin() + blocker_count_;
  int kept = 0;
  for (int i = 0; i < proxy.contact_count; ++i) {
    ProxyContact& contact = proxy.contacts[i];
    if (std::any_of(blockers_.begin(), blockers_end, [&](const Blocker& b) { return b.triangle == contact.triangle; })) continue;
    contact.separation = contact.shape.separation(proxy.position);
    if (contact.separation.distance > bound) continue;
    if (kept != i) proxy.contacts[kept] = contact;
    ++kept;
  }
  for (int b = 0; b < blocker_count_ && kept < ProxyState::kMostContacts; ++b) {
    ProxyContact& contact = proxy.contacts[kept];
    contact.triangle = blockers_[b].triangle;
    contact.shape = surfaces_.shape_of(contact.triangle);
    contact.separation = blocking_separation(contact.shape, proxy.position, blocked_motion, keep_);
    if (contact.separation.distance <= bound) ++kept;
  }
  proxy.contact_count = kept;
}

}  // namespace hapton
