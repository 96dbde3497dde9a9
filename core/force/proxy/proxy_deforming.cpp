// A surface that deforms takes the probe along.
#include <algorithm>
#include <cmath>

#include "core/force/proxy/proxy_method.h"
#include "core/math/side_sign.h"

namespace hapton {
namespace {

// Local units: farther from an edge than a point that counts as on the edge, far below what can be felt.
constexpr double kOffEdges = 0x1p-42;
// How far a flight to the nearest place goes beyond it, in local units: kBeyond times the distance, plus kMinBeyond.
constexpr double kBeyond = 0x1p-20;
constexpr double kMinBeyond = 0x1p-40;

Vec3 weights_on(const ContactTriangle& shape, const Vec3& p) {
  Vec3 weights;
  for (int k = 0; k < 3; ++k) weights[(k + 2) % 3] = std::max(0.0, shape.inside(k, p));
  const double sum = weights.sum();
  return sum > 0.0 ? Vec3(weights / sum) : Vec3(Vec3::Constant(1.0 / 3.0));
}

}  // namespace

// Finds the nearest triangle; at an edge or vertex, of several that are equally near, the one that faces p most.
std::optional<std::uint32_t> ProxyMethod::find_nearest(const Vec3& p, double reach, Separation& at) const noexcept {
  // Distances to triangles that share the closest point differ by their rounding, 2^-50.
  constexpr double kSame = 1.0 + 0x1p-40;
  std::optional<std::uint32_t> found;
  double best_facing = 0.0;
  geometry_.visit_nearest(p, reach * reach, [&](std::uint32_t id, double bound) {
    const ContactTriangle shape = surfaces_.shape_of(id);
    const Separation here = shape.separation(p);
    if (here.distance > reach) return bound;
    const double facing = std::fabs(shape.normal().dot(here.normal));
    const bool is_nearer = !found || here.distance * kSame < at.distance;
    if (is_nearer || (here.distance <= at.distance * kSame && facing > best_facing)) {
      found = id;
      at = here;
      best_facing = facing;
    }
    const double farthest = at.distance * kSame;
    return std::min(bound, farthest * farthest * kSame);
  });
  return found;
}

ProxyMethod::Anchor ProxyMethod::anchor(double reach_m) noexcept {
  leave_ball();
  Anchor anchor{.distance = reach_m / geometry_.unit_m()};
  if (!has_sample_) return anchor;
  // A probe that ran out of work on its way through free space has no contact either.
  const bool is_floating = proxy_.is_free || (!surface_.is_on_surface() && proxy_.contact_count == 0);
  const double reach = is_floating ? anchor.distance : kEdgeReach * kContactOffset;
  if (!proxy_.is_free) anchor.distance = 0.0;
  if (!surface_.is_on_surface()) {
    const Vec3 p = proxy_.position;
    Separation nearest;
    const std::optional<std::uint32_t> id = find_nearest(p, reach, nearest);
    if (!id) return anchor;
    if (proxy_.is_free) anchor.distance = nearest.distance;
    const Vec3 towards = nearest.nearest - p;
    const double length = towards.norm();
    double time = 1.0;
    const Vec3 beyond = length > 0.0 ? Vec3(nearest.nearest + (kBeyond + kMinBeyond / length) * towards) : p;
    // A flight is exact at edges and vertices. It may miss the surface beside the boundary of an open one.
    if (length > 0.0 && flight_.fly(p, beyond, proxy_.slides, surface_, time) != FreeFlight::Met::walkable) surface_.leave();
    if (!surface_.is_on_surface()) {
      const ContactTriangle shape = surfaces_.shape_of(*id);
      anchor.exists = true;
      anchor.triangle = *id;
      anchor.back = side_sign(shape.corner(0), shape.corner(1), shape.corner(2), p) < 0.0;
      anchor.weights = weights_on(shape, nearest.nearest);
      anchor.point = nearest.nearest;
      return anchor;
    }
  }
  anchor.exists = true;
  anchor.triangle = surface_.at().a().id;
  anchor.back = surface_.at().a().is_back();
  anchor.point = surface_.point();
  anchor.weights = weights_on(surface_.at().a().shape, anchor.point);
  if (is_floating) surface_.leave();
  return anchor;
}

std::optional<ProxyMethod::HeldPlace> ProxyMethod::find_held_place() const noexcept {
  if (proxy_.is_free || ball_.exists() || proxy_.contact_count == 0) return std::nullopt;
  const std::uint32_t triangle = proxy_.strongest_triangle();
  const ContactTriangle shape = surfaces_.shape_of(triangle);
  return HeldPlace{triangle, weights_on(shape, shape.separation(proxy_.position).nearest)};
}

void ProxyMethod::move_with_surface(const Anchor& anchor) noexcept {
  swept_.drop_motion();
  sphere_.forget_near();
  if (!anchor.exists) return;
  const bool slides = proxy_.slides;
  const ContactTriangle shape = surfaces_.shape_of(anchor.triangle);
  Vec3 place = Vec3::Zero();
  for (int k = 0; k < 3; ++k) place += anchor.weights[k] * shape.corner(k);
  const Vec3 moved = place - anchor.point;
  const Vec3 to_middle = (shape.corner(0) + shape.corner(1) + shape.corner(2)) / 3.0 - place;
  const double length = to_middle.norm();
  if (length > 0.0) place += std::min(0.5, kOffEdges / length) * to_middle;
  place -= shape.normal().dot(place - shape.corner(0)) * shape.normal();
  surface_.leave();
  sphere_.stop_tracking();
  swept_.forget();
  // A side that holds nothing lets the probe through.
  if (!surface_.land(anchor.triangle, anchor.back, place, slides)) return;
  proxy_.settle_at(place);
  proxy_.is_free = false;
  proxy_.slides = slides;
  last_device_ += moved;
  if (carried_from_) *carried_from_ += moved;
  is_unconverged_ = true;
}

}  // namespace hapton
