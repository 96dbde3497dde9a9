#include "core/force/proxy/surface_point.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/force/contact_qp.h"
#include "core/math/side_sign.h"

namespace hapton {

bool SurfacePoint::can_hold(std::uint32_t triangle, bool back) const noexcept {
  return geometry_.is_walkable(triangle) && !(back && !materials_[geometry_.mesh_of(triangle)].two_sided);
}

void SurfacePoint::load(std::uint32_t id, bool back, Facet& facet) const noexcept {
  const ObjectGeometry::Corners corners = geometry_.corners(id);
  facet.id = id;
  facet.side = back ? -1.0 : 1.0;
  facet.shape = ContactTriangle(corners.a, corners.b, corners.c);
}

bool SurfacePoint::load_adjacent(int k) noexcept {
  edge_ = k;
  const TouchGeometry::Adjacent adjacent = geometry_.adjacent(a().id, k);
  const bool back = a().is_back() != adjacent.flips;
  if (!adjacent.exists || !can_hold(adjacent.id, back)) return false;
  for (const int onward : {(adjacent.edge + 1) % 3, (adjacent.edge + 2) % 3}) geometry_.prefetch_across(adjacent.id, onward);
  load(adjacent.id, back, facets_[1 - first_]);
  other_edge_ = adjacent.edge;
  return true;
}

bool SurfacePoint::land(std::uint32_t triangle, bool back, const Vec3& p) noexcept {
  if (!can_hold(triangle, back)) return false;
  load(triangle, back, face_a());
  is_on_surface_ = true;
  move_on_face(p);
  return true;
}

bool SurfacePoint::land_on_edge(std::uint32_t triangle, bool back, int k, const Vec3& p) noexcept {
  const TouchGeometry::Adjacent adjacent = geometry_.adjacent(triangle, k);
  if (!adjacent.exists || !can_hold(adjacent.id, back != adjacent.flips) || !land(triangle, back, p)) return false;
  load_adjacent(k);
  on_ = On::edge;
  has_left_a_ = false;
  return true;
}

void SurfacePoint::move_on_face(const Vec3& p) noexcept {
  on_ = On::face;
  corner_ = -1;
  entry_edge_ = -1;
  p_ = p;
}

bool SurfacePoint::reach_edge(int k, const Vec3& p) noexcept {
  const ContactTriangle& face = a().shape;
  const double along = std::clamp(face.along(k, p), 0.0, 1.0);
  const double length_squared = face.edge(k).squaredNorm();
  if (along * along * length_squared <= kSnap * kSnap) return reach_vertex(k);
  if ((1.0 - along) * (1.0 - along) * length_squared <= kSnap * kSnap) return reach_vertex((k + 1) % 3);
  move_on_face(face.corner(k) + along * face.edge(k));
  if (!load_adjacent(k)) return false;
  on_ = On::edge;
  has_left_a_ = true;
  return true;
}

bool SurfacePoint::reach_vertex(int corner) noexcept {
  move_on_face(a().shape.corner(corner));
  corner_ = corner;
  if (!collect_fan()) {
    corner_ = -1;
    return false;
  }
  on_ = On::vertex;
  return true;
}

void SurfacePoint::move_on_edge(double along) noexcept {
  on_ = On::edge;
  p_ = a().shape.corner(edge_) + along * a().shape.edge(edge_);
}

void SurfacePoint::cross_edge() noexcept {
  first_ = 1 - first_;
  move_on_face(p_);
  entry_edge_ = other_edge_;
  for (const int onward : {(entry_edge_ + 1) % 3, (entry_edge_ + 2) % 3}) geometry_.prefetch_opposite(a().id, onward);
}

void SurfacePoint::return_from_edge() noexcept {
  move_on_face(p_);
  entry_edge_ = edge_;
}

void SurfacePoint::turn_to(const FanFacet& facet) noexcept {
  vertex_lift_.height = 0.0;
  load(facet.id, facet.back, face_a());
  corner_ = facet.corner;
}

bool SurfacePoint::enter_edge(const FanFacet& facet) noexcept {
  turn_to(facet);
  if (!load_adjacent(facet.next)) return false;
  on_ = On::edge;
  has_left_a_ = false;
  corner_ = -1;
  return true;
}

bool SurfacePoint::is_convex() const noexcept {
  if (a().id == b().id) return true;
  const ContactTriangle& beyond = b().shape;
  return b().side * side_sign(beyond.corner(0), beyond.corner(1), beyond.corner(2), a().shape.corner((edge_ + 2) % 3)) < 0.0;
}

bool SurfacePoint::is_free_over_edge(const Vec3& device) const noexcept {
  const bool before_a = a().height(device) > kClear;
  const bool before_b = b().height(device) > kClear;
  return before_a && before_b ? true : before_a || before_b ? is_convex() : false;
}

// Collects all triangle sides at the vertex, in order. False unless all are walkable.
bool SurfacePoint::collect_fan() noexcept {
  fan_count_ = 0;
  vertex_lift_.height = 0.0;
  std::uint32_t id = a().id;
  bool back = a().is_back();
  int corner = corner_;
  int next = corner_;
  do {
    if (fan_count_ == kMaxFan || !can_hold(id, back)) return false;
    const ObjectGeometry::Corners corners = geometry_.corners(id);
    const std::array<const Vec3*, 3> at = {&corners.a, &corners.b, &corners.c};
    const Vec3& vertex = *at[corner];
    const Vec3 out = *at[(corner + 1) % 3] - vertex;
    const Vec3 in = vertex - *at[(corner + 2) % 3];
    const Vec3 normal = accurate_cross(out, -in).normalized();
    FanFacet& facet = fan_[fan_count_++];
    facet = {.id = id,
             .back = back,
             .corner = corner,
             .next = next,
             .normal = back ? Vec3(-normal) : normal,
             .inward = {normal.cross(out), normal.cross(in)},
             .direction = next == corner ? Vec3(out.normalized()) : Vec3(-in.normalized())};
    const TouchGeometry::Adjacent adjacent = geometry_.adjacent(id, next);
    if (!adjacent.exists) return false;
    const std::uint32_t number = corners.vertices[corner];
    id = adjacent.id;
    back = back != adjacent.flips;
    const Triangle& vertices = geometry_.corners(id).vertices;
    if (vertices[adjacent.edge] == number) {
      corner = adjacent.edge;
      next = (adjacent.edge + 2) % 3;
    } else {
      corner = (adjacent.edge + 1) % 3;
      next = corner;
    }
  } while (id != a().id || back != a().is_back());
  return true;
}

// Sum of the face normals, weighted by angle (Baerentzen & Aanaes 2005): tells on which side a point is whose closest point is the vertex.
Vec3 SurfacePoint::vertex_normal() const noexcept {
  Vec3 sum = Vec3::Zero();
  for (int i = 0; i < fan_count_; ++i) {
    const Vec3& first = fan_[(i + fan_count_ - 1) % fan_count_].direction;
    const Vec3& last = fan_[i].direction;
    sum += std::atan2(first.cross(last).norm(), first.dot(last)) * fan_[i].normal;
  }
  return sum;
}

// Pre: the vertex is the point of its faces closest to the device.
bool SurfacePoint::is_free_at_vertex(const Vec3& to_device) const noexcept {
  constexpr double kTell = 16.0;  // times the least descent: a nearer device may also pull over the faces, by less than counts
  if (!(to_device.norm() > kTell * kMinPull)) return false;
  if (is_at_boundary()) return true;  // the fan contains both sides of the sheet: nothing lies behind it
  if (std::none_of(fan().begin(), fan().end(), [&](const FanFacet& facet) { return facet.normal.dot(to_device) > 0.0; })) return false;
  return vertex_normal().dot(to_device) > 0.0;
}

bool SurfacePoint::is_at_boundary() const noexcept {
  for (int i = 0; i < fan_count_; ++i) {
    if (fan_[i].id == fan_[(i + 1) % fan_count_].id) return true;
  }
  return false;
}

bool SurfacePoint::is_before(const FanFacet& facet, const Vec3& p) const noexcept {
  const ObjectGeometry::Corners at = geometry_.corners(facet.id);
  return (side_sign(at.a, at.b, at.c, p) > 0.0) != facet.back;
}

// The closest feature of the fan decides: a face, an edge between two faces, or the vertex by its normal. Between two equally close
// features the choice may be due to rounding; the signs are exact.
bool SurfacePoint::is_before_fan(const Vec3& p) const noexcept {
  if (is_at_boundary()) return true;
  const Vec3 off = p == p_ ? kShift : Vec3(p - p_);
  double nearest = off.squaredNorm();
  const FanFacet* face = nullptr;
  const FanFacet* beyond = nullptr;  // the face beyond the edge
  for (int i = 0; i < fan_count_; ++i) {
    const FanFacet& facet = fan_[i];
    const double height = facet.normal.dot(off);
    if (facet.inward[0].dot(off) > 0.0 && facet.inward[1].dot(off) > 0.0 && height * height < nearest) {
      nearest = height * height;
      face = &facet;
      beyond = nullptr;
    }
    const double along = facet.direction.dot(off);
    const double aside = (off - along * facet.direction).squaredNorm();
    if (along > 0.0 && aside < nearest) {
      nearest = aside;
      face = &facet;
      beyond = &fan_[(i + 1) % fan_count_];
    }
  }
  if (face == nullptr) return vertex_normal().dot(off) > 0.0;
  if (beyond == nullptr) return is_before(*face, p);
  const ObjectGeometry::Corners at = geometry_.corners(face->id);
  const Vec3* const corners[3] = {&at.a, &at.b, &at.c};
  const bool is_concave = is_before(*beyond, *corners[(face->next + 2) % 3]);
  return is_concave ? is_before(*face, p) && is_before(*beyond, p) : is_before(*face, p) || is_before(*beyond, p);
}

SurfacePoint::Exit SurfacePoint::find_exit(const Vec3& goal) const noexcept {
  Exit exit;
  for (int k = 0; k < 3; ++k) {
    if (corner_ >= 0 && k != (corner_ + 1) % 3) continue;  // the other two edges meet at the start
    if (inside_by(-kOnEdge, a(), k, goal) > 0.0) continue;
    const double here = a().shape.inside(k, p_);
    const double t = here > 0.0 ? std::clamp(here / (here - a().shape.inside(k, goal)), 0.0, 1.0) : 0.0;
    if (t < exit.time) exit = {k, t};
  }
  return exit;
}

SurfacePoint::Descent SurfacePoint::find_steepest(const Vec3& to_device, double least) const noexcept {
  Descent best{nullptr, false, least};
  for (const FanFacet& facet : fan()) {
    const double slope = facet.direction.dot(to_device);
    if (slope > best.length) best = {&facet, false, slope};
    if (facet.inward[0].dot(to_device) > 0.0 && facet.inward[1].dot(to_device) > 0.0) {
      const double length = (to_device - facet.normal.dot(to_device) * facet.normal).norm();
      if (length >= best.length) best = {&facet, true, length};
    }
  }
  return best;
}

bool SurfacePoint::is_free_along(const Descent& descent, const Vec3& to_device) const noexcept {
  const FanFacet& facet = *descent.facet;
  const bool is_before = facet.normal.dot(to_device) > kClear;
  if (descent.over_face) return is_before;
  const auto index = static_cast<int>(&facet - fan_.data());
  const FanFacet& across = fan_[static_cast<std::size_t>((index + 1) % fan_count_)];
  const bool is_before_across = across.normal.dot(to_device) > kClear;
  if (is_before == is_before_across) return is_before;
  return across.id == facet.id || facet.normal.dot(across.direction) < 0.0;  // over a boundary or a convex edge
}

SurfaceNext SurfacePoint::descend_along(const Descent& descent, const Vec3& device) noexcept {
  const FanFacet facet = *descent.facet;
  if (descent.over_face) {
    turn_to(facet);
    if (a().height(device) > kClear) return SurfaceNext::airborne;  // the point leaves the surface at the vertex
    move_on_face(p_);
    corner_ = facet.corner;
    return SurfaceNext::again;
  }
  if (!enter_edge(facet)) return SurfaceNext::unwalkable;
  return is_free_over_edge(device) ? SurfaceNext::airborne : SurfaceNext::again;
}

// The device comes out through the face. Near an edge it may continue behind the adjacent face: then the point is not released.
SurfaceNext SurfacePoint::release(const Vec3& device, const Vec3& to) noexcept {
  const ContactTriangle& face = a().shape;
  move_on_face(device - a().height(device) * a().normal());
  for (int k = 0; k < 3; ++k) {
    const double inside = face.inside(k, p_);
    const double length_squared = face.edge(k).squaredNorm();
    if (inside * std::fabs(inside) > kSnap * kSnap * length_squared) continue;
    if (!reach_edge(k, p_)) return SurfaceNext::unwalkable;
    if (on_ != On::edge) return SurfaceNext::descend;
    if (is_free_over_edge(to)) return SurfaceNext::released;
    has_left_a_ = false;
    return SurfaceNext::again;
  }
  return SurfaceNext::released;
}

Vec3 SurfacePoint::inside(double off_edges) const noexcept {
  const ContactTriangle& face = a().shape;
  const Vec3 to_middle = (face.corner(0) + face.corner(1) + face.corner(2)) / 3.0 - p_;
  const double length = to_middle.norm();
  const double share = length > 2.0 * off_edges ? off_edges / length : 0.5;
  return p_ + share * to_middle;
}

Vec3 SurfacePoint::lifted(double height) const noexcept {
  if (on_ == On::vertex && fan_count_ > kMaxPlanes) return lifted_over_fan(height);
  if (on_ == On::vertex || is_near_edges(kMaxLift * height)) return lifted_over_all(height);
  return p_ + (on_ == On::edge ? lift_between(a().normal(), b().normal(), height) : Vec3(height * a().normal()));
}

Vec3 SurfacePoint::lifted_again(double height) noexcept {
  if (on_ != On::vertex) return lifted(height);
  if (vertex_lift_.height != height) vertex_lift_ = {height, lifted(height)};
  return vertex_lift_.point;
}

// Whether the point is near an edge or vertex other than the one it is on.
bool SurfacePoint::is_near_edges(double within) const noexcept {
  for (int k = 0; k < 3; ++k) {
    const bool stands_on = on_ == On::edge && k == edge_;
    if (!stands_on && is_near_edge(a(), k, within)) return true;
    if (on_ == On::edge && k != other_edge_ && is_near_edge(b(), k, within)) return true;
  }
  return false;
}

// A function of its own, because lifted() runs in every step and setting up these planes costs more than the rest of lifted().
Vec3 SurfacePoint::lifted_over_all(double height) const noexcept {
  std::array<ContactPlane, kMaxPlanes> planes;
  Vec3 sum = Vec3::Zero();
  int count = 0;
  const auto add = [&](const Vec3& normal, double over) {
    planes[count++] = {normal, height - over};
    sum += normal;
  };
  if (on_ == On::vertex) {
    for (int i = 0; i < fan_count_; ++i) add(fan_[i].normal, 0.0);
  } else {
    add_near_planes(height, add);
    if (count == 0) return p_ + (on_ == On::edge ? lift_between(a().normal(), b().normal(), height) : Vec3(height * a().normal()));
    add(a().normal(), 0.0);
    if (on_ == On::edge) add(b().normal(), 0.0);
  }
  const ConstrainedMotion up = constrain_motion(Vec3::Zero(), std::span(planes).first(static_cast<std::size_t>(count)));
  if (up.solved && up.motion.norm() <= kMaxLift * height) return p_ + up.motion;
  if (on_ == On::edge) return p_ + lift_between(a().normal(), b().normal(), height);
  if (on_ == On::vertex) return p_ + over_widest_face(height);
  return p_ + height * (sum.norm() > 0.5 ? Vec3(sum.normalized()) : a().normal());
}

// At the boundary of a sheet, or at an equally sharp edge, no direction leads away from both faces. The point is then moved outwards in
// the face's plane: a path that starts above the face and goes round the boundary would pass through the face within rounding.
Vec3 SurfacePoint::lifted_towards(const Vec3& device, double height) const noexcept {
  if (on_ == On::vertex) {
    const Vec3 to_device = device - p_;
    const double length = to_device.norm();
    double clearance = 1.0;
    for (int i = 0; i < fan_count_ && length > 0.0; ++i) clearance = std::min(clearance, distance_from_facet(i, to_device / length));
    if (clearance * kMaxLift > 1.0 && clearance * length > 2.0 * height) return p_ + (height / (clearance * length)) * to_device;
  }
  if (on_ == On::edge && (a().normal() + b().normal()).squaredNorm() * kMaxLift * kMaxLift <= 4.0 && is_convex()) {
    return p_ - height * a().shape.normal().cross(a().shape.edge(edge_)).normalized();
  }
  return lifted(height);
}

const Vec3& SurfacePoint::edge_before(int i) const noexcept { return fan_[(i + fan_count_ - 1) % fan_count_].direction; }

// At a vertex: distance of p, relative to the vertex, from face i of the fan, extended to infinity.
double SurfacePoint::distance_from_facet(int i, const Vec3& p) const noexcept {
  if (fan_[i].inward[0].dot(p) > 0.0 && fan_[i].inward[1].dot(p) > 0.0) return std::fabs(fan_[i].normal.dot(p));
  const auto to_ray = [&](const Vec3& ray) { return (p - std::max(0.0, ray.dot(p)) * ray).norm(); };
  return std::min(to_ray(edge_before(i)), to_ray(fan_[i].direction));
}

// At a vertex where no direction leads away from all faces: over the middle of the face that is farthest from the others. A ball about that
// middle which no other face enters is cut by this face alone, so half of it is free.
Vec3 SurfacePoint::over_widest_face(double height) const noexcept {
  double widest = 1.0 / kMaxLift;
  Vec3 up = 0.5 * widest * a().normal();
  for (int i = 0; i < fan_count_; i += 1 + fan_count_ / kMaxTriedFacets) {
    const Vec3 middle = (edge_before(i) + fan_[i].direction).normalized();
    double clearance = 1.0;
    for (int k = 0; k < fan_count_; ++k) {
      if (fan_[k].id != fan_[i].id) clearance = std::min(clearance, distance_from_facet(k, middle));
    }
    if (clearance <= widest) continue;
    widest = clearance;
    up = middle + 0.5 * clearance * fan_[i].normal;
  }
  return (2.0 * height / widest) * up;
}

// At a vertex with too many facets for an exact lift: along the mean normal.
Vec3 SurfacePoint::lifted_over_fan(double height) const noexcept {
  const Vec3 up = vertex_normal().normalized();
  double least = 1.0;
  for (const FanFacet& facet : fan()) least = std::min(least, facet.normal.dot(up));
  return least * kMaxLift > 1.0 ? Vec3(p_ + (height / least) * up) : Vec3(p_ + over_widest_face(height));
}

// The shortest vector that ends `height` above two planes through zero.
Vec3 SurfacePoint::lift_between(const Vec3& normal_a, const Vec3& normal_b, double height) noexcept {
  const Vec3 sum = normal_a + normal_b;
  const double squared = sum.squaredNorm();
  return squared * kMaxLift * kMaxLift > 4.0 ? Vec3(sum * (2.0 * height / squared)) : Vec3(height * normal_a);
}

bool SurfacePoint::is_near_edge(const Facet& facet, int k, double within) const noexcept {
  const double inside = facet.shape.inside(k, p_);
  const double length_squared = facet.shape.edge(k).squaredNorm();
  if (inside > 0.0 && inside * inside > within * within * length_squared) return false;
  const double along = std::clamp(facet.shape.along(k, p_), 0.0, 1.0);
  return (p_ - facet.shape.corner(k) - along * facet.shape.edge(k)).squaredNorm() <= within * within;
}

// Adds the planes of nearby faces that a lift must clear: those beyond concave edges near the point. The search crosses concave and nearly
// flat edges and goes on from the faces beyond them; near a vertex it may find several.
template <class Add>
void SurfacePoint::add_near_planes(double height, Add&& add) const noexcept {
  std::array<std::pair<std::uint32_t, bool>, kMaxNear> faces;
  int count = 0;
  faces[count++] = {a().id, a().is_back()};
  if (on_ == On::edge) faces[count++] = {b().id, b().is_back()};
  for (int i = 0; i < count; ++i) {
    Facet loaded;
    const bool is_own = i == 0 || (i == 1 && on_ == On::edge);
    if (!is_own) load(faces[i].first, faces[i].second, loaded);
    const Facet& at = i == 0 ? a() : is_own ? b() : loaded;
    for (int k = 0; k < 3; ++k) {
      if (on_ == On::edge && is_own && k == (i == 0 ? edge_ : other_edge_)) continue;
      if (!is_near_edge(at, k, kMaxLift * height)) continue;
      const TouchGeometry::Adjacent adjacent = geometry_.adjacent(at.id, k);
      if (!adjacent.exists || adjacent.id == at.id) continue;
      const std::pair<std::uint32_t, bool> next{adjacent.id, at.is_back() != adjacent.flips};
      if (std::find(faces.begin(), faces.begin() + count, next) != faces.begin() + count) continue;
      Facet beyond;
      load(next.first, next.second, beyond);
      const bool is_concave = beyond.height(at.shape.corner((k + 2) % 3)) > 0.0;
      if (!is_concave && beyond.normal().dot(at.normal()) < kAllButFlat) continue;
      if (is_concave) add(beyond.normal(), beyond.height(p_));
      if (count == kMaxNear) return;
      faces[count++] = next;
    }
  }
}

int SurfacePoint::find_contacts(const Vec3& device, std::array<Contact, 3>& contacts) const noexcept {
  const Vec3 to_device = device - p_;
  if (on_ == On::face) {
    contacts[0] = {a().id, a().normal(), -a().normal().dot(to_device)};
    return 1;
  }
  if (on_ == On::edge) {
    const double cosine = a().normal().dot(b().normal());
    const double at_a = -a().normal().dot(to_device);
    const double at_b = -b().normal().dot(to_device);
    const double determinant = 1.0 - cosine * cosine;
    const double of_a = determinant > 0.0 ? std::max(0.0, (at_a - cosine * at_b) / determinant) : at_a;
    const double of_b = determinant > 0.0 ? std::max(0.0, (at_b - cosine * at_a) / determinant) : 0.0;
    contacts[0] = {a().id, a().normal(), of_a};
    contacts[1] = {b().id, b().normal(), of_b};
    return 2;
  }
  if (fan_count_ > kMaxPlanes) {
    const auto deepest = std::min_element(fan().begin(), fan().end(), [&](const FanFacet& one, const FanFacet& other) {
      return one.normal.dot(to_device) < other.normal.dot(to_device);
    });
    contacts[0] = {deepest->id, deepest->normal, std::max(0.0, -deepest->normal.dot(to_device))};
    return 1;
  }
  std::array<ContactPlane, kMaxPlanes> planes;
  for (int i = 0; i < fan_count_; ++i) planes[i] = {fan_[i].normal, 0.0};
  const ConstrainedMotion held = constrain_motion(to_device, std::span(planes).first(static_cast<std::size_t>(fan_count_)));
  for (int i = 0; i < held.active_count; ++i) {
    const FanFacet& facet = fan_[held.active[i]];
    contacts[i] = {facet.id, facet.normal, held.multipliers[i]};
  }
  return held.active_count;
}

}  // namespace hapton
