// Frees a point proxy from local minima that exist only because it is a small sphere.
#include <algorithm>
#include <cmath>

#include "core/force/reference/reference_proxy.h"

namespace hapton {
namespace {

constexpr double kEscapeGain = 4.0;       // rest offsets: height of a step that a point would not feel
constexpr double kOpenFaceMargin = 16.0;  // rest offsets: farther than this from its boundary, a face alone holds a point
constexpr double kVertexRadius = 32.0;    // rest offsets: this near to a vertex, a point is at the vertex
constexpr double kMinSlope = 0x1p-30;     // share of the distance to the device: a smaller slope does not lead away from a vertex
constexpr double kFarthestHeld = 64.0;    // rest offsets: farthest that another method's proxy may be off the surface
constexpr double kSameHeight = 0x1p-10;   // relative: heights that differ by less count as equal

}  // namespace

// A point probe is a small sphere, for robustness. Where a concave edge narrows at a vertex, that sphere may stop at a step no higher than
// its radius, which does not stop a point. So a proxy at a minimum is lifted by a few radii and sent in every direction that the vertex
// offers: the pull, its projections onto the nearby faces, and the edges and concave edges that lead towards the device. The result is kept
// if it is nearer to the device by more than such a step; otherwise the proxy is restored.
bool ReferenceProxy::escape(const Vec3& device) noexcept {
  if (rest_offset_ != kPointRadius || has_friction() || state_.contacts.empty() || state_.position == device || is_on_open_face())
    return false;
  const Vec3 start = state_.position;
  const Vec3 pull = device - start;
  const double least_gain = kEscapeGain * rest_offset_;
  contacts_before_ = state_.contacts;
  const auto has_gained = [&] { return (device - state_.position).norm() < pull.norm() - least_gain; };
  update_contacts();
  if (leave_vertex(device, project_pull(pull))) {
    descend(device);
    if (has_gained()) return true;
    state_.position = start;
  }
  for (const double height : {8.0 * rest_offset_, 256.0 * rest_offset_}) {
    if (keeps_to_surface() && height > 8.0 * rest_offset_) continue;
    collect_near(start, 2.0 * height);
    if (!lift(start, height)) continue;
    const Vec3 lifted = state_.position;
    for (const Vec3& direction : directions_out(start, pull, 2.0 * height)) {
      state_.position = lifted;
      state_.contacts.clear();
      advance(direction);
      if ((state_.position - start).norm() < 8.0 * height) continue;
      descend(device);
      if (has_gained()) return true;
    }
    state_.position = start;
  }
  state_.contacts = contacts_before_;
  update_contacts();
  return false;
}

// Whether the proxy touches one face only, away from its boundary: such a minimum is also one for a point.
bool ReferenceProxy::is_on_open_face() const noexcept {
  if (state_.contacts.size() != 1 || state_.contacts[0].near.feature != TriangleFeature::face) return false;
  const PreparedTriangle& shape = state_.contacts[0].face.shape;
  for (int k = 0; k < 3; ++k) {
    if (shape.inward[k].dot(state_.position - shape.corner[k]) <= kOpenFaceMargin * rest_offset_ * shape.edge[k].norm()) return false;
  }
  return true;
}

void ReferenceProxy::collect_near(const Vec3& p, double within) noexcept {
  near_contacts_.clear();
  list_local_faces();
  const bool local = is_local(p, local_half_side_ - within);
  const std::size_t count = local ? local_faces_.size() : faces_.size();
  for (std::size_t k = 0; k < count && near_contacts_.size() < kMaxNear; ++k) {
    const std::size_t i = local ? local_faces_[k] : k;
    const Box& box = boxes_[i];
    if (((p - box.high).cwiseMax(box.low - p).array() > within).any() || !can_touch(faces_[i])) continue;
    const ClosestPoint near = closest_point(faces_[i].shape, p);
    if (near.distance <= within && !near.direction.isZero(0.0)) near_contacts_.push_back({faces_[i], near});
  }
}

// The motion nearest to `goal` after which the proxy is at least `height` above the planes of all nearby faces.
HalfSpaceProjection ReferenceProxy::project_above_near(const Vec3& goal, double height) noexcept {
  half_spaces_.clear();
  for (const Contact& contact : near_contacts_) half_spaces_.push_back({contact.near.direction, height - contact.near.distance});
  return project_onto_half_spaces(goal, half_spaces_, kFeasible);
}

// Moves the proxy by the shortest vector that puts it `height` above the planes of all nearby faces. False if there is none.
bool ReferenceProxy::lift(const Vec3& start, double height) noexcept {
  const HalfSpaceProjection up = project_above_near(Vec3::Zero(), height);
  if (!up.feasible || up.point.norm() > 64.0 * height) return false;
  state_.position = start;
  advance(up.point);
  return true;
}

// Places the proxy without overlaps: a proxy that starts with one may keep it, and would go farther into a slit than its sphere fits.
void ReferenceProxy::place_clear(const Vec3& p) noexcept {
  place_held(p, false);
  if (rest_offset_ != kPointRadius) return;
  collect_near(p, 2.0 * rest_offset_);
  const auto overlaps = [&](const Contact& contact) { return rest_offset_ - contact.near.distance > 2.0 * kTolerance; };
  if (std::none_of(near_contacts_.begin(), near_contacts_.end(), overlaps)) return;
  const HalfSpaceProjection out = project_above_near(Vec3::Zero(), rest_offset_);
  if (out.feasible && out.point.norm() <= rest_offset_) state_.position += out.point;
}

// Puts the proxy into contact with all faces that are as near to p as the nearest one: those on which p lies. It then continues as if it
// had moved there itself. From a position only slightly beside an edge, friction would release it differently.
bool ReferenceProxy::place_on_surface(const Vec3& p, bool sliding) noexcept {
  if (rest_offset_ != kPointRadius || is_frictionless_) return false;
  place_held(p, sliding);
  collect_near(p, kFarthestHeld * rest_offset_);
  double least = kFarthestHeld * rest_offset_;
  for (const Contact& contact : near_contacts_) least = std::min(least, contact.near.distance);
  Vec3 sum = Vec3::Zero();
  for (const Contact& contact : near_contacts_) {
    if (contact.near.distance <= least * (1.0 + kSameHeight)) sum += contact.near.direction;
  }
  if (!(least > 0.5 * rest_offset_) || !(sum.norm() > 0.5)) return false;
  const HalfSpaceProjection down = project_above_near(-4.0 * least * sum.normalized(), rest_offset_);
  if (!down.feasible || down.count == 0 || down.point.norm() > kFarthestHeld * rest_offset_) return false;
  state_.position = p + down.point;
  for (const Contact& contact : near_contacts_) add_contact(contact.face);
  update_contacts();
  return !state_.contacts.empty();
}

bool ReferenceProxy::has_room(const Vec3& p) noexcept {
  const double least = rest_offset_ - 0.25 * kPointRadius;
  collect_near(p, rest_offset_);
  return std::none_of(near_contacts_.begin(), near_contacts_.end(), [&](const Contact& contact) { return contact.near.distance < least; });
}

const std::vector<Vec3>& ReferenceProxy::directions_out(const Vec3& start, const Vec3& pull, double within) noexcept {
  directions_.clear();
  auto add_line = [&](const Vec3& line) {
    const double length2 = line.squaredNorm();
    if (length2 > 0.0) directions_.push_back((line.dot(pull) / length2) * line);
  };
  directions_.push_back(pull);
  for (const Contact& contact : near_contacts_) {
    const PreparedTriangle& shape = contact.face.shape;
    if (shape.has_face) directions_.push_back(pull - pull.dot(shape.normal) * shape.normal);
    for (int k = 0; k < 3; ++k) {
      const double along = std::clamp(shape.edge[k].dot(start - shape.corner[k]) / std::max(shape.edge[k].squaredNorm(), 1e-300), 0.0, 1.0);
      if ((start - shape.corner[k] - along * shape.edge[k]).norm() <= within) add_line(shape.edge[k]);
    }
  }
  // Lines where faces meet that do not share an edge.
  for (std::size_t i = 0; i < near_contacts_.size(); ++i) {
    for (std::size_t j = i + 1; j < near_contacts_.size() && directions_.size() < kMaxDirections; ++j) {
      const Vec3 line = near_contacts_[i].face.shape.normal.cross(near_contacts_[j].face.shape.normal);
      if (line.squaredNorm() > 1e-12) add_line(line);
    }
  }
  return directions_;
}

// The vertex at which a point in contact is; nullptr: it is at none.
const Vec3* ReferenceProxy::find_vertex(const Pull& pull) const noexcept {
  if (rest_offset_ != kPointRadius || pull.strongest == nullptr) return nullptr;
  const Vec3* found = nullptr;
  for (const Vec3& corner : pull.strongest->face.shape.corner) {
    if ((corner - state_.position).norm() <= kVertexRadius * rest_offset_) found = &corner;
  }
  return found;
}

// A point leaves a vertex along the steepest of its faces and edges. A sphere would roll on over whichever it touches first.
bool ReferenceProxy::leave_vertex(const Vec3& device, const Pull& pull) noexcept {
  if (has_friction() || !rules_.keeps_to_surface) return false;
  const Vec3* vertex = find_vertex(pull);
  if (vertex == nullptr) return false;
  const Vec3 descent = find_steepest(*vertex, device - *vertex);
  const double slope = descent.norm();
  const double length = pull.motion.point.norm();
  if (length > kStill && descent.dot(pull.motion.point) >= (1.0 - kMinRoll) * slope * length) return false;
  return leave_along(Vec3(*vertex), descent, device);
}

// Finds the point of a concave edge, formed by two faces, at which a point proxy is. Friction acts through the faces that lead away from
// the edge. The proxy's sphere may have moved slightly up the opposite face and would slip from that face too early.
bool ReferenceProxy::find_concave_edge(const Pull& pull, Vec3& on_edge, std::array<EdgeFace, 2>& sides) noexcept {
  if (rest_offset_ != kPointRadius || pull.strongest == nullptr) return false;
  const PreparedTriangle& shape = pull.strongest->face.shape;
  if (!shape.has_face) return false;
  const double bound = kVertexRadius * rest_offset_;
  int at = -1;
  for (int k = 0; k < 3; ++k) {
    const double along = std::clamp(shape.edge[k].dot(state_.position - shape.corner[k]) / shape.edge[k].squaredNorm(), 0.0, 1.0);
    const Vec3 nearest = shape.corner[k] + along * shape.edge[k];
    if ((state_.position - nearest).norm() > bound) continue;
    if (at >= 0 || !(along > 0.0 && along < 1.0)) return false;  // at a vertex, other edges matter as well
    at = k;
    on_edge = nearest;
  }
  if (at < 0) return false;
  const Vec3& begin = shape.corner[at];
  const Vec3& end = shape.corner[(at + 1) % 3];
  list_local_faces();
  int count = 0;
  const Vec3* opposite = nullptr;
  for (const std::uint32_t i : local_faces_) {
    const PreparedTriangle& other = faces_[i].shape;
    for (int e = 0; e < 3; ++e) {
      const Vec3& from = other.corner[e];
      const Vec3& to = other.corner[(e + 1) % 3];
      if (!(from == begin && to == end) && !(from == end && to == begin)) continue;
      if (count < 2) sides[static_cast<std::size_t>(count)] = {other.normal, other.inward[e]};
      if (faces_[i].triangle != pull.strongest->face.triangle) opposite = &other.corner[(e + 2) % 3];
      ++count;
    }
  }
  if (count != 2 || opposite == nullptr) return false;
  const double side = shape.normal.dot(state_.position - begin) > 0.0 ? 1.0 : -1.0;
  return side * shape.normal.dot(*opposite - begin) > 0.0;
}

// Whether friction holds a point at a concave edge.
bool ReferenceProxy::is_held_at_edge(const Vec3& device, const Pull& pull) noexcept {
  std::array<EdgeFace, 2> sides;
  Vec3 on_edge;
  if (!has_friction() || !find_concave_edge(pull, on_edge, sides)) return false;
  const Vec3 to_device = device - on_edge;
  const Vec3 along = sides[0].normal.cross(sides[0].inward).normalized();
  Vec3 descent = along.dot(to_device) * along;
  for (const EdgeFace& side : sides) {
    const Vec3 over = to_device - side.normal.dot(to_device) * side.normal;
    if (side.inward.dot(to_device) > 0.0 && over.squaredNorm() > descent.squaredNorm()) descent = over;
  }
  return !exceeds_friction(descent.norm(), (to_device - descent).norm(), material_of(pull));
}

// At a vertex, friction too is decided along the steepest descent. The sphere touches only some of the faces at the vertex, so its friction
// cone would be about the normals of these faces only.
ReferenceProxy::AtVertex ReferenceProxy::slip_from_vertex(const Vec3& device, const Pull& pull) noexcept {
  const Vec3* vertex = has_friction() ? find_vertex(pull) : nullptr;
  if (vertex == nullptr) return AtVertex::elsewhere;
  const Vec3 to_device = device - *vertex;
  const Vec3 descent = find_steepest(*vertex, to_device);
  const Material material = material_of(pull);
  if (!exceeds_friction(descent.norm(), (to_device - descent).norm(), material)) return AtVertex::held;
  return leave_along(Vec3(*vertex), descent, device) ? AtVertex::left : AtVertex::elsewhere;
}

bool ReferenceProxy::leave_along(const Vec3& vertex, const Vec3& descent, const Vec3& device) noexcept {
  const Vec3 start = state_.position;
  const double slope = descent.norm();
  const double distance = (device - vertex).norm();
  if (!(slope > kMinSlope * distance)) return false;
  vertex_contacts_ = state_.contacts;
  // In a groove that bends at the vertex a lift may be blocked, from ahead or from behind.
  for (const double height : {8.0 * rest_offset_, 24.0 * rest_offset_}) {
    // Long enough to bring the proxy nearer to the device in spite of the lift.
    const double share = std::max(8.0, 4.0 * distance / slope) * height / slope;
    collect_near(start, 2.0 * kVertexRadius * rest_offset_);
    for (const bool goes_to_vertex : {true, false}) {
      if (share >= 1.0 || !lift(start, height)) continue;
      state_.contacts.clear();
      if (goes_to_vertex) advance(vertex - start);
      advance(share * descent);
      if ((device - state_.position).norm() < (device - start).norm()) {
        update_contacts();
        return true;
      }
    }
  }
  state_.position = start;
  state_.contacts = vertex_contacts_;
  update_contacts();
  return false;
}

void ReferenceProxy::list_faces_at(const Vec3& vertex) noexcept {
  if (has_vertex_ && vertex == vertex_) return;
  has_vertex_ = true;
  vertex_ = vertex;
  faces_at_vertex_.clear();
  for (std::size_t i = 0; i < faces_.size(); ++i) {
    const auto& [a, b, c] = faces_[i].shape.corner;
    if (a == vertex || b == vertex || c == vertex) faces_at_vertex_.push_back(static_cast<std::uint32_t>(i));
  }
}

// The longest vector from the vertex to the point nearest to the device, over all faces and edges at the vertex. Zero: none leads nearer.
Vec3 ReferenceProxy::find_steepest(const Vec3& vertex, const Vec3& to_device) noexcept {
  Vec3 best = Vec3::Zero();
  const auto offer = [&](const Vec3& descent) {
    if (descent.squaredNorm() > best.squaredNorm()) best = descent;
  };
  list_faces_at(vertex);
  for (const std::uint32_t i : faces_at_vertex_) {
    const PreparedTriangle& shape = faces_[i].shape;
    for (int k = 0; k < 3; ++k) {
      if (shape.corner[k] != vertex) continue;
      const Vec3& next = shape.edge[k];
      const Vec3 before = -shape.edge[(k + 2) % 3];
      for (const Vec3* edge : {&next, &before}) {
        const double along = edge->dot(to_device);
        if (along > 0.0) offer((along / edge->squaredNorm()) * *edge);
      }
      if (!shape.has_face) continue;
      const Vec3 descent = to_device - shape.normal.dot(to_device) * shape.normal;
      if (shape.inward[k].dot(descent) > 0.0 && shape.inward[(k + 2) % 3].dot(descent) > 0.0) offer(descent);
    }
  }
  return best;
}

}  // namespace hapton
