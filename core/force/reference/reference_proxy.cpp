#include "core/force/reference/reference_proxy.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/force/reference/convex_sweep.h"

namespace hapton {
namespace {

// In the unit of the reference: the scene's diagonal lies in [1/2, 1).
constexpr double kRounding = 0x1p-48;         // bound on the error of a distance between points within the scene
constexpr double kMaxDistanceLoss = 0x1p-47;  // most that one motion takes from a distance already at its minimum: twice the rounding error
constexpr double kIdleGain = 0x1p-50;         // a motion that comes nearer to the device by less counts as idle
constexpr int kIdleMotions = 8;               // a descent ends after this many idle motions in succession
constexpr int kMaxMotions = 16000;            // most motions of one descent; Counters::unconverged counts the descents that need more
constexpr int kMaxEscapes = 64;               // most escapes in one sub-step
constexpr double kLocalHalfSide = 0x1p-7;     // half side of the cube whose faces are listed: a few hundred faces of a million
constexpr double kCloseReach = 0x1p-20;       // the close faces are this near to the surface of the probe: tens of thousands of creeps
constexpr double kCreep = 0x1p-36;            // a motion that gets no farther creeps, as in a slit that closes
constexpr int kCreepsToList = 4;           // creeps in succession after which the close faces are listed: a list costs as much as a motion
constexpr std::size_t kMaxContacts = 256;  // one more replaces the oldest
constexpr double kMaxLowering = 4.0;  // rest offsets: farther off the surface, in a wedge below 29 degrees, the radius is not subtracted

bool boxes_meet(const Vec3& low_a, const Vec3& high_a, const Vec3& low_b, const Vec3& high_b) {
  return (low_a.array() <= high_b.array()).all() && (low_b.array() <= high_a.array()).all();
}

// False only if the segment stays farther than `reach` from the box; reach includes the rounding of positions along the segment. The
// separating axes are the edges of the box, and the directions perpendicular to one of them and to the segment.
bool comes_near(const Vec3& middle, const Vec3& half, const Vec3& low, const Vec3& high, double reach) {
  const Vec3 off = (0.5 * (low + high) - middle).cwiseAbs();
  const Vec3 side = 0.5 * (high - low) + Vec3::Constant(reach);
  const Vec3 length = half.cwiseAbs();
  if ((off.array() > (side + length).array()).any()) return false;
  const Vec3 across = (0.5 * (low + high) - middle).cross(half).cwiseAbs();
  return across.x() <= side.y() * length.z() + side.z() * length.y() && across.y() <= side.z() * length.x() + side.x() * length.z() &&
         across.z() <= side.x() * length.y() + side.y() * length.x();
}

// Whether the whole motion stays on one side of the triangle's plane, farther from it than `reach`.
bool stays_beside(const PreparedTriangle& triangle, const Vec3& from, const Vec3& motion, double reach) {
  if (!triangle.has_face) return false;
  const double height = triangle.normal.dot(from - triangle.corner[triangle.base]);
  const double height_after = height + triangle.normal.dot(motion);
  return std::min(height, height_after) > reach || std::max(height, height_after) < -reach;
}

}  // namespace

ReferenceProxy::ReferenceProxy(double probe_radius, std::vector<Material> materials, std::size_t most_faces)
    : rest_offset_(std::max(probe_radius, kPointRadius)),
      local_half_side_(kLocalHalfSide + 2.0 * rest_offset_),
      materials_(std::move(materials)),
      state_(make_state()) {
  note_friction();
  faces_.reserve(most_faces);
  boxes_.reserve(most_faces);
  local_faces_.reserve(most_faces);
  close_faces_.reserve(most_faces);
  faces_at_vertex_.reserve(most_faces);
  contacts_before_.reserve(kMaxContacts);
  vertex_contacts_.reserve(kMaxContacts);
  intervals_.reserve(most_faces);
  near_contacts_.reserve(kMaxNear);
  directions_.reserve(kMaxDirections);
  half_spaces_.reserve(kMaxContacts);
}

ReferenceProxy::State ReferenceProxy::make_state() const {
  State state;
  state.contacts.reserve(kMaxContacts);
  return state;
}

void ReferenceProxy::clear_faces() noexcept {
  has_local_faces_ = has_close_faces_ = has_vertex_ = false;
  faces_.clear();
  boxes_.clear();
}

void ReferenceProxy::add_face(const Face& face) noexcept {
  const auto& [a, b, c] = face.shape.corner;
  has_local_faces_ = has_close_faces_ = has_vertex_ = false;
  faces_.push_back(face);
  boxes_.push_back({a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)});
}

void ReferenceProxy::place_free(const Vec3& p) noexcept {
  state_.position = p;
  state_.contacts.clear();
  state_.free = true;
  state_.sliding = false;
}

void ReferenceProxy::place_held(const Vec3& p, bool sliding) noexcept {
  place_free(p);
  state_.free = false;
  state_.sliding = sliding;
}

void ReferenceProxy::follow(const Vec3& device_from, const Vec3& device_to, const Rules& rules) noexcept {
  if (faces_.empty() && state_.contacts.empty()) return place_free(device_to);
  ++counters_.substeps;
  rules_ = rules;
  drag(device_from, device_to);
  descend(device_to);
  const auto is_near_enough = [&] { return (device_to - state_.position).norm() < rules_.near_enough; };
  for (int i = 0; i < kMaxEscapes && !is_near_enough() && escape(device_to); ++i) ++counters_.escapes;
  state_.free = state_.position == device_to && state_.contacts.empty();
  if (state_.free) state_.sliding = false;
}

Vec3 ReferenceProxy::surface_position(const Vec3& device) noexcept {
  const Vec3 position = state_.position;
  if (rest_offset_ != kPointRadius || position == device) return position;
  update_contacts();
  const Pull pull = project_pull(device - position);
  const int n = pull.motion.count;
  if (n == 0 || !pull.motion.feasible) return position;
  // The shortest motion that brings the proxy to zero distance from all active contacts: N (N^T N)^-1 (-distances).
  Mat3 normals = Mat3::Zero();
  Vec3 distances = Vec3::Zero();
  for (int i = 0; i < n; ++i) {
    const Contact& contact = state_.contacts[pull.motion.active[i]];
    normals.col(i) = contact.near.direction;
    distances[i] = contact.near.distance;
  }
  Mat3 gram = normals.transpose() * normals;
  for (int i = n; i < 3; ++i) gram(i, i) = 1.0;
  const Vec3 down = -normals * gram.fullPivLu().solve(distances);
  const bool is_sound =
      down.allFinite() && (normals.transpose() * down + distances).norm() <= kTolerance && down.norm() <= kMaxLowering * rest_offset_;
  const Vec3 onto = is_sound ? Vec3(position + down) : position;
  return (onto - device).dot(position - device) > 0.0 ? onto : device;
}

// Moves the proxy until no straight motion brings it nearer to the device.
void ReferenceProxy::descend(const Vec3& device) noexcept {
  double nearest = std::numeric_limits<double>::infinity();
  int idle_motions = 0;
  int motions = 0;
  for (; motions < kMaxMotions && idle_motions < kIdleMotions; ++motions) {
    update_contacts();
    if (state_.contacts.empty() && cross_free_space(device)) break;
    const double distance = (device - state_.position).norm();
    if (distance < rules_.near_enough) break;
    idle_motions = distance < nearest - kIdleGain ? 0 : idle_motions + 1;
    nearest = std::min(nearest, distance);
    const Pull pull = project_pull(device - state_.position);
    if (pull.strongest != nullptr) {
      state_.material = material_of(pull);
      state_.object = static_cast<int>(pull.strongest->face.object);
    }
    if (pull.motion.count == 0) {
      const bool arrives = (device - state_.position).norm() <= kLongestMotion;
      if (advance(pull.motion.point) && arrives) {
        state_.position = device;
        break;
      }
      continue;
    }
    const AtVertex at_vertex = slip_from_vertex(device, pull);
    if (at_vertex == AtVertex::held) break;
    if (at_vertex == AtVertex::left) continue;
    if (at_vertex == AtVertex::elsewhere && is_held_at_edge(device, pull)) break;
    const Vec3 motion = cut_at_boundary(pull, limit_by_friction(pull));
    if (!(motion.norm() > kStill)) {
      if (tip_over(device, pull)) continue;
      break;
    }
    if (roll(device, pull) || slip(device, pull, motion) || leave_vertex(device, pull)) continue;
    advance(motion);
  }
  update_contacts();
  counters_.motions += static_cast<std::uint64_t>(motions);
  counters_.most_motions = std::max(counters_.most_motions, static_cast<std::uint64_t>(motions));
  if (motions == kMaxMotions) ++counters_.unconverged;
}

// Outside the scene there are no contacts: the proxy goes straight to the device, or to where its path enters the scene's surroundings.
// True if it has arrived.
bool ReferenceProxy::cross_free_space(const Vec3& device) noexcept {
  const double surroundings = 1.0 + 2.0 * rest_offset_;
  if (state_.position.norm() < 1.01 * surroundings) return false;
  const Vec3 path = device - state_.position;
  const double length = path.norm();
  const double closest_at = length > 0.0 ? -state_.position.dot(path) / length : 0.0;
  const double miss = length > 0.0 ? (state_.position + (closest_at / length) * path).norm() : surroundings;
  const double entry = closest_at - std::sqrt(std::max(0.0, (surroundings - miss) * (surroundings + miss)));
  if (miss >= surroundings || entry <= 0.0 || entry >= length) {
    state_.position = device;
    return true;
  }
  state_.position += (entry / length) * path;
  return false;
}

// Recomputes the closest points of all contacts and drops those left behind.
void ReferenceProxy::update_contacts() noexcept {
  for (Contact& contact : state_.contacts) {
    contact.near = closest_point(contact.face.shape, state_.position);
    if (contact.near.distance == 0.0 && contact.near.feature != TriangleFeature::face) contact.near.direction = contact.face.shape.normal;
  }
  std::erase_if(state_.contacts, [&](const Contact& contact) {
    return contact.near.distance > rest_offset_ + kTolerance || contact.near.direction.isZero(0.0);
  });
  forget_boundaries_of_faces();
}

// Drops edge and vertex contacts that belong to a face in contact. Such a contact is within tolerance, just ahead, and its normal leans
// against the motion. At the edge between two coplanar triangles it would hold a proxy whose pull along the plane is smaller than that
// lean, and friction would stop there.
void ReferenceProxy::forget_boundaries_of_faces() noexcept {
  add_face_below();
  const auto is_of_face = [&](const Contact& contact) {
    if (contact.near.feature == TriangleFeature::face) return false;
    return std::any_of(state_.contacts.begin(), state_.contacts.end(), [&](const Contact& other) {
      return other.near.feature == TriangleFeature::face && closest_point(other.face.shape, contact.near.point).distance <= kStill;
    });
  };
  for (std::size_t i = state_.contacts.size(); i-- > 0;) {
    if (is_of_face(state_.contacts[i])) state_.contacts.erase(state_.contacts.begin() + static_cast<std::ptrdiff_t>(i));
  }
}

// Adds the face that lies below a point, within its radius. If that face has stopped no motion, as in a row of coplanar slivers, only the
// boundary of the next face is in contact.
void ReferenceProxy::add_face_below() noexcept {
  const auto is_boundary = [](const Contact& contact) { return contact.near.feature != TriangleFeature::face; };
  if (rest_offset_ != kPointRadius || std::none_of(state_.contacts.begin(), state_.contacts.end(), is_boundary)) return;
  list_local_faces();
  for (const std::uint32_t i : is_close(state_.position) ? close_faces_ : local_faces_) {
    const Box& box = boxes_[i];
    const double bound = rest_offset_ + kTolerance;
    if (((state_.position - box.high).cwiseMax(box.low - state_.position).array() > bound).any() || !can_touch(faces_[i])) continue;
    const ClosestPoint near = closest_point(faces_[i].shape, state_.position);
    if (near.feature == TriangleFeature::face && near.distance <= bound && !near.direction.isZero(0.0)) add_contact(faces_[i]);
  }
}

ReferenceProxy::Pull ReferenceProxy::project_pull(const Vec3& pull) noexcept {
  half_spaces_.clear();
  for (const Contact& contact : state_.contacts) {
    // A proxy slightly too near is moved back to the rest offset. One that starts with an overlap (after a reset inside a surface) is only
    // kept from going deeper.
    const double gap = rest_offset_ - contact.near.distance;
    half_spaces_.push_back({contact.near.direction, gap <= 2.0 * kTolerance ? gap : 0.0});
  }
  Pull result;
  result.motion = project_onto_half_spaces(pull, half_spaces_, kFeasible);
  if (!result.motion.feasible) {
    for (HalfSpace& half_space : half_spaces_) half_space.gap = std::min(half_space.gap, 0.0);
    result.motion = project_onto_half_spaces(pull, half_spaces_, kFeasible);
    if (!result.motion.feasible) {
      ++counters_.infeasible;
      result.motion.point = Vec3::Zero();
    }
  }
  double strongest = -1.0;
  for (int i = 0; i < result.motion.count; ++i) {
    if (result.motion.multiplier[i] > strongest) {
      strongest = result.motion.multiplier[i];
      result.strongest = &state_.contacts[result.motion.active[i]];
    }
  }
  const double length = result.motion.point.norm();
  if (length > kLongestMotion) result.motion.point *= kLongestMotion / length;
  return result;
}

// Where the proxy jumps, its path matters, not only its end: the path must not leave the surface beyond the feature that holds the proxy. A
// point passes the boundary by its radius. A sphere under friction passes it by so little that its path over the edge is that of slip().
Vec3 ReferenceProxy::cut_at_boundary(const Pull& pull, const Vec3& motion) noexcept {
  const double length = motion.norm();
  const double overshoot = has_friction() && is_sphere() ? kShortestSlip * rest_offset_ : rest_offset_;
  if (!keeps_to_surface() || pull.strongest == nullptr || !(length > overshoot)) return motion;
  double until = 1.0;
  for (int i = 0; i < pull.motion.count; ++i) until = std::min(until, share_on_feature(state_.contacts[pull.motion.active[i]], motion));
  return std::min(1.0, until + overshoot / length) * motion;
}

// The share of a motion that stays on the feature in contact.
double ReferenceProxy::share_on_feature(const Contact& contact, const Vec3& motion) noexcept {
  const PreparedTriangle& shape = contact.face.shape;
  if (contact.near.feature == TriangleFeature::face) return share_on_plane(contact, motion);
  // At a vertex slip() follows the sphere about it, unless the sphere overlaps something: then it goes straight, by its radius at most.
  // Without friction, or for a point, only the overshoot is left.
  if (!is_edge(contact.near.feature)) return has_friction() && is_sphere() ? std::min(1.0, rest_offset_ / motion.norm()) : 0.0;
  const int edge = edge_number(contact.near.feature);
  const Vec3 direction = shape.edge[edge].normalized();
  const double along = direction.dot(motion);
  const double sideways = (motion - along * direction).norm();
  const Vec3& end = shape.corner[(edge + (along > 0.0)) % 3];
  const double until = along != 0.0 ? std::max(0.0, direction.dot(end - state_.position) / along) : 1.0;
  return sideways * until > rest_offset_ ? rest_offset_ / sideways : until;
}

// The share of a motion over coplanar nearby faces.
double ReferenceProxy::share_on_plane(const Contact& contact, const Vec3& motion) noexcept {
  const auto interval_over = [&](const PreparedTriangle& shape) {
    FaceInterval interval{0.0, 1.0};
    for (int k = 0; k < 3; ++k) {
      const double inside = shape.inward[k].dot(state_.position - shape.corner[k]);
      const double rate = shape.inward[k].dot(motion);
      if (rate < 0.0) interval.until = std::min(interval.until, std::max(inside, 0.0) / -rate);
      if (inside < 0.0) interval.from = rate > 0.0 ? std::max(interval.from, -inside / rate) : 2.0;
    }
    return interval;
  };
  intervals_.clear();
  list_local_faces();
  for (const std::uint32_t i : local_faces_) {
    const PreparedTriangle& shape = faces_[i].shape;
    if (!shape.has_face || std::abs(shape.normal.dot(contact.near.direction)) < 1.0 - kSamePlane) continue;
    if (std::abs(std::abs(shape.normal.dot(state_.position - shape.corner[shape.base])) - contact.near.distance) > kTolerance) continue;
    const FaceInterval interval = interval_over(shape);
    if (interval.from < interval.until) intervals_.push_back(interval);
  }
  std::sort(intervals_.begin(), intervals_.end(), [](const FaceInterval& a, const FaceInterval& b) { return a.from < b.from; });
  double until = interval_over(contact.face.shape).until;
  const double gap = rest_offset_ / motion.norm();
  for (const FaceInterval& interval : intervals_) {
    if (interval.from > until + gap) break;
    until = std::max(until, interval.until);
  }
  return until;
}

// Lists the faces in a cube about the proxy, in the order of all faces, so that short motions test only those. The list is valid until the
// proxy has left the middle of the cube.
void ReferenceProxy::list_local_faces() noexcept {
  if (is_local(state_.position, 0.5 * local_half_side_)) return;
  local_faces_.clear();
  local_centre_ = state_.position;
  const Vec3 low = local_centre_.array() - local_half_side_;
  const Vec3 high = local_centre_.array() + local_half_side_;
  for (std::size_t i = 0; i < faces_.size(); ++i) {
    if (boxes_meet(boxes_[i].low, boxes_[i].high, low, high)) local_faces_.push_back(static_cast<std::uint32_t>(i));
  }
  has_local_faces_ = true;
}

bool ReferenceProxy::is_local(const Vec3& p, double bound) const noexcept {
  return has_local_faces_ && ((p - local_centre_).cwiseAbs().array() <= bound).all();
}

// Lists the local faces that are close to the probe, in the same order, if its last motions crept. The list is valid until the proxy is
// half of kCloseReach away.
void ReferenceProxy::list_close_faces() noexcept {
  if (creeps_ < kCreepsToList || is_close(state_.position)) return;
  close_faces_.clear();
  close_centre_ = state_.position;
  const double reach = rest_offset_ + kCloseReach;
  for (const std::uint32_t i : local_faces_) {
    const Box& box = boxes_[i];
    if (((close_centre_ - box.high).cwiseMax(box.low - close_centre_).array() > reach).any()) continue;
    if (closest_point(faces_[i].shape, close_centre_).distance <= reach) close_faces_.push_back(i);
  }
  has_close_faces_ = true;
}

bool ReferenceProxy::is_close(const Vec3& p) const noexcept { return has_close_faces_ && (p - close_centre_).norm() <= 0.5 * kCloseReach; }

// The first of `count` faces on the path, and its time.
template <class FaceAt>
ReferenceProxy::FirstHit ReferenceProxy::find_first(const Vec3& motion, std::size_t count, const FaceAt& face_at) const noexcept {
  const Vec3 half = 0.5 * motion;
  const Vec3 middle = state_.position + half;
  // The device may be so far away that this rounding is larger than the other terms of `reach`.
  const double rounding = 0x1p-49 * (1.0 + state_.position.cwiseAbs().sum() + motion.cwiseAbs().sum());
  const double reach = rest_offset_ + 2.0 * kTolerance + rounding;
  FirstHit first;
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t i = face_at(k);
    const Face& face = faces_[i];
    if (!comes_near(middle, half, boxes_[i].low, boxes_[i].high, reach) || !can_touch(face)) continue;
    if (stays_beside(face.shape, state_.position, motion, reach)) continue;
    const double distance = closest_point(face.shape, state_.position).distance;
    // A motion ends at the rest offset less the tolerance. Where the distance is already smaller, a motion may reduce it by one
    // kMaxDistanceLoss more, but never below half, so any number of motions stays on the proxy's side.
    double limit = std::min(rest_offset_ - kTolerance, distance - kMaxDistanceLoss);
    if (distance < 0.5 * rest_offset_) limit = distance;
    const SweepHit found = sweep_point(face.shape, state_.position, motion, first.until, limit, 0.5 * kMaxDistanceLoss, kRounding);
    if (found.hit) first = {found.t, &face};
  }
  return first;
}

// The first face on the path. A hit before the motion leaves the surroundings whose faces are listed is the first hit among all faces.
ReferenceProxy::FirstHit ReferenceProxy::find_first(const Vec3& motion) noexcept {
  list_local_faces();
  list_close_faces();
  FirstHit first;
  if (is_close(state_.position)) {
    first = find_first(motion, close_faces_.size(), [&](std::size_t k) { return std::size_t{close_faces_[k]}; });
    if (is_close(state_.position + first.until * motion)) return first;
  }
  first = find_first(motion, local_faces_.size(), [&](std::size_t k) { return std::size_t{local_faces_[k]}; });
  const double inner = local_half_side_ - (rest_offset_ + 2.0 * kTolerance);
  if (is_local(state_.position + first.until * motion, inner)) return first;
  return find_first(motion, faces_.size(), [](std::size_t k) { return k; });
}

// Moves the proxy along the motion until it hits a triangle, which becomes a contact. True if it hits none.
bool ReferenceProxy::advance(const Vec3& motion) noexcept {
  const FirstHit first = find_first(motion);
  const Vec3 covered = first.face == nullptr ? motion : Vec3(first.until * motion);
  state_.position += covered;
  creeps_ = covered.norm() <= kCreep ? std::min(creeps_ + 1, kCreepsToList) : 0;
  if (first.face != nullptr) add_contact(*first.face);
  return first.face == nullptr;
}

void ReferenceProxy::add_contact(const Face& face) noexcept {
  for (const Contact& known : state_.contacts) {
    if (known.face.triangle == face.triangle) return;
  }
  if (state_.contacts.size() == kMaxContacts) state_.contacts.erase(state_.contacts.begin());
  state_.contacts.push_back({face, closest_point(face.shape, state_.position)});
}

// One-sided surfaces block only from the side that their normals point to.
bool ReferenceProxy::can_touch(const Face& face) const noexcept {
  if (materials_[face.object].two_sided) return true;
  return face.shape.has_face && face.shape.normal.dot(state_.position - face.shape.corner[face.shape.base]) > 0.0;
}

}  // namespace hapton
