// Round convex edges and vertices: a sphere in contact with one moves along the arc about it.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/force/reference/convex_sweep.h"
#include "core/force/reference/reference_proxy.h"

namespace hapton {
namespace {

// rad. The tangents of an arc of sixty degrees leave it by 15 % of the radius.
constexpr double kLongestRoll = std::numbers::pi / 3.0;
constexpr double kLongestTip = std::numbers::pi / 6.0;
constexpr double kNearBoundary = 1e-3;  // rest offsets: a face contact this near to the boundary may be at the edge

}  // namespace

// A sphere over a single edge or vertex moves round it to the point nearest to the device, at most sixty degrees.
bool ReferenceProxy::roll(const Vec3& device, const Pull& pull) noexcept {
  if (pull.motion.count != 1 || !is_sphere() || has_friction()) return false;
  const Contact& contact = *pull.strongest;
  if (contact.near.feature == TriangleFeature::face || contact.near.distance < rest_offset_ - 2.0 * kTolerance) return false;
  const Vec3 aim = perpendicular_to(contact.face.shape, contact.near.feature, device - pivot_of(contact));
  const Vec3 sideways = aim - aim.dot(contact.near.direction) * contact.near.direction;
  const double side = sideways.norm();
  const double angle = std::min(std::atan2(side, aim.dot(contact.near.direction)), kLongestRoll);
  return side > 0.0 && angle > kMinRoll && go_round(contact, sideways / side, angle);
}

// The proxy has stopped but not at a minimum: on an edge or vertex with the device beyond it, it balances like a ball on a crest. It moves
// round to either side if that is free and nearer to the device. A contact very near the boundary of a face counts as one at the edge.
// Friction would hold the proxy on the crest.
bool ReferenceProxy::tip_over(const Vec3& device, const Pull& pull) noexcept {
  if (has_friction()) return false;
  for (int i = 0; i < pull.motion.count; ++i) {
    Contact contact = state_.contacts[pull.motion.active[i]];
    if (contact.near.distance < rest_offset_ - 2.0 * kTolerance) continue;
    if (contact.near.feature != TriangleFeature::face) {
      if (tip_over(device, contact)) return true;
      continue;
    }
    for (int k = 0; k < 3 && rules_.tips_at_boundaries; ++k) {
      const PreparedTriangle& shape = contact.face.shape;
      if (shape.inward[k].dot(state_.position - shape.corner[k]) > kNearBoundary * rest_offset_ * shape.edge[k].norm()) continue;
      contact.near.feature = edge_feature(k);
      if (tip_over(device, contact)) return true;
    }
  }
  return false;
}

bool ReferenceProxy::tip_over(const Vec3& device, const Contact& contact) noexcept {
  const Vec3& normal = contact.near.direction;
  if ((device - pivot_of(contact)).dot(normal) >= 0.0) return false;
  // Tries the directions along an edge as well, because the edge may end here.
  const TriangleFeature at = contact.near.feature;
  const Vec3 first = is_edge(at) ? Vec3(normal.cross(contact.face.shape.edge[edge_number(at)]).normalized()) : normal.unitOrthogonal();
  const Vec3 second = normal.cross(first);
  const Vec3 start = state_.position;
  const double tip = std::min(
      kLongestTip, std::sqrt(kPointRadius / rest_offset_));  // climbs half a contact offset: it passes no convex edge that holds a sphere
  for (const Vec3& tangent : {first, Vec3(-first), second, Vec3(-second)}) {
    if (!go_round(contact, tangent, tip)) continue;
    if ((device - state_.position).squaredNorm() < (device - start).squaredNorm()) return true;
    state_.position = start;
  }
  return false;
}

// The point the sphere touches.
Vec3 ReferenceProxy::pivot_of(const Contact& contact) const noexcept {
  return state_.position - contact.near.distance * contact.near.direction;
}

// Moves round the touched edge or vertex by an angle, along the tangents at the ends of the arc. Returns false, and moves nothing, if
// something is in the path.
bool ReferenceProxy::go_round(const Contact& contact, const Vec3& tangent, double angle) noexcept {
  const Vec3 start = state_.position;
  const Vec3 pivot = pivot_of(contact);
  const Vec3 normal = contact.near.direction;
  const Vec3 corner = pivot + rest_offset_ * (normal + std::tan(0.5 * angle) * tangent);
  const Vec3 end = pivot + rest_offset_ * (std::cos(angle) * normal + std::sin(angle) * tangent);
  if (advance(corner - start) && advance(end - corner)) return true;
  state_.position = start;
  return false;
}

}  // namespace hapton
