#include "core/force/reference_method.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "core/force/contact_material.h"
#include "core/force/convex_sweep.h"

namespace hapton {
namespace {

// All of these are in local units, where the scene's diagonal lies in (1/2, 1].
const double kHover = std::ldexp(1.0, -32);     // a point probe's radius: 2^16 times what a distance errs by
const double kSkin = std::ldexp(1.0, -38);      // hover / 64: far above rounding, far below hover
const double kRounding = std::ldexp(1.0, -48);  // bound on the error of a distance between points within the scene
const double kErosion = std::ldexp(1.0, -47);   // what one motion may take off a distance that is already at its least
const double kStill = std::ldexp(1.0, -46);     // a motion shorter than this is none
const double kIdleGain = std::ldexp(1.0, -50);  // coming nearer to the device by less than this is none
const double kFeasible = std::ldexp(1.0, -44);  // play of half-spaces in the projection
constexpr double kLongestMotion = 4.0;          // a device far away must not cost the digits of what is near
constexpr double kFarthest = 1e12;              // a device farther out is taken to be there: its square must stay finite
constexpr double kLeastRoll = 1e-10;            // rad
constexpr double kLongestRoll = std::numbers::pi / 3.0;
constexpr double kLongestTip = std::numbers::pi / 6.0;
constexpr double kBorder = 1e-3;    // of the rest distance: a face's contact this near to its border may stand on the edge
constexpr double kOpenFace = 16.0;  // rest distances from its border a point on a face has nothing else to be held by
constexpr int kIdleMotions = 8;
constexpr int kMostMotions = 4000;
constexpr std::size_t kMostTouched = 256;
constexpr int kMostEscapes = 64;
constexpr double kEscapeGain = 4.0;  // hovers: the height of a step a point would not feel
constexpr std::size_t kMostNear = 48;
constexpr std::size_t kMostDirections = 1536;

float float_below(double x) { return std::nextafter(static_cast<float>(x), -std::numeric_limits<float>::infinity()); }
float float_above(double x) { return std::nextafter(static_cast<float>(x), std::numeric_limits<float>::infinity()); }

bool boxes_meet(const Vec3& low_a, const Vec3& high_a, const Vec3& low_b, const Vec3& high_b) {
  return (low_a.array() <= high_b.array()).all() && (low_b.array() <= high_a.array()).all();
}

double power_of_two_above(double length) {
  int exponent = 0;
  std::frexp(length, &exponent);
  return std::ldexp(1.0, exponent);
}

}  // namespace

Result<std::unique_ptr<ForceMethod>> ReferenceMethod::make(const MethodSettings& settings, const TouchScene& scene) {
  return make_reference(settings, scene);
}

Result<std::unique_ptr<ReferenceMethod>> ReferenceMethod::make_reference(const MethodSettings& settings, const TouchScene& scene,
                                                                         bool prefilter) {
  if (settings.reference_substeps < 1 || settings.reference_substeps > 1000000) {
    return fail("method reference: {} sub-steps a step; give 1 to 1000000", settings.reference_substeps);
  }
  if (!(settings.probe_radius_m >= 0.0) || !std::isfinite(settings.probe_radius_m)) {
    return fail("method reference: probe radius {} m; give zero or more", settings.probe_radius_m);
  }
  std::size_t triangles = 0;
  for (const TouchObject& object : scene.objects) {
    triangles += object.mesh->triangles.size();
    for (const Triangle& triangle : object.mesh->triangles) {
      for (const std::uint32_t index : triangle) {
        if (index >= object.mesh->vertices.size())
          return fail("method reference: a triangle names vertex {}, the mesh has {}", index, object.mesh->vertices.size());
        if (!object.mesh->vertices[index].allFinite()) return fail("method reference: vertex {} is not finite", index);
      }
    }
  }
  if (triangles == 0) return fail("method reference: the scene has no triangles; add a mesh to touch");
  return std::unique_ptr<ReferenceMethod>(new ReferenceMethod(settings, scene, prefilter));
}

ReferenceMethod::ReferenceMethod(const MethodSettings& settings, const TouchScene& scene, bool prefilter)
    : substeps_(settings.reference_substeps), prefilter_(prefilter) {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = -low;
  for (const TouchObject& object : scene.objects) {
    for (const Triangle& triangle : object.mesh->triangles) {
      for (const std::uint32_t index : triangle) {
        low = low.cwiseMin(object.mesh->vertices[index]);
        high = high.cwiseMax(object.mesh->vertices[index]);
      }
    }
  }
  centre_ = 0.5 * low + 0.5 * high;
  const double diagonal = (high - low).norm();
  const double size = std::max(diagonal, settings.probe_radius_m);
  unit_m_ = size > 0.0 ? power_of_two_above(size) : 1.0;
  rest_ = std::max(settings.probe_radius_m / unit_m_, kHover);
  skin_ = kSkin;
  for (const TouchObject& object : scene.objects) {
    const auto shift = static_cast<std::uint32_t>(vertices_.size());
    const auto number = static_cast<std::uint32_t>(materials_.size());
    materials_.push_back(object.material);
    frictionless_ = frictionless_ && !(object.material.friction_static > 0.0);
    for (const Vec3& vertex : object.mesh->vertices) vertices_.push_back(to_local(vertex));
    for (const auto& [a, b, c] : object.mesh->triangles) {
      triangles_.push_back({a + shift, b + shift, c + shift});
      object_of_.push_back(number);
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    low_[axis].reserve(triangles_.size());
    high_[axis].reserve(triangles_.size());
    for (const auto& [a, b, c] : triangles_) {
      const auto [least, most] = std::minmax({vertices_[a][axis], vertices_[b][axis], vertices_[c][axis]});
      low_[axis].push_back(float_below(least));
      high_[axis].push_back(float_above(most));
    }
  }
  in_reach_.resize(triangles_.size());
  candidates_.reserve(triangles_.size());
  candidate_boxes_.reserve(triangles_.size());
  touched_.reserve(kMostTouched);
  touched_before_.reserve(kMostTouched);
  near_.reserve(kMostNear);
  directions_.reserve(kMostDirections);
  half_spaces_.reserve(kMostTouched);
}

// Far away the direction is kept and the distance cut, before anything can overflow.
Vec3 ReferenceMethod::device_to_local(const Vec3& p_S) const noexcept {
  const Vec3 p = p_S - centre_;
  const double most = p.cwiseAbs().maxCoeff();
  const double farthest = kFarthest * unit_m_;
  return (most > farthest ? Vec3(p * (farthest / most)) : p) / unit_m_;
}

PreparedTriangle ReferenceMethod::prepare_triangle(std::uint32_t triangle) const {
  const auto& [a, b, c] = triangles_[triangle];
  return {vertices_[a], vertices_[b], vertices_[c]};
}

// All triangles whose boxes come within reach of the device point; every one without the prefilter.
void ReferenceMethod::gather(const Vec3& device, double reach) noexcept {
  candidates_.clear();
  candidate_boxes_.clear();
  const float centre[3] = {static_cast<float>(device.x()), static_cast<float>(device.y()), static_cast<float>(device.z())};
  // What single precision may lose: the rounding of the centre and of three differences, squares and a sum.
  const double loss = 1e-6 * (1.0 + device.norm() + reach);
  const float limit = float_above((reach + loss) * (reach + loss) * (1.0 + 1e-6));
  const std::size_t n = triangles_.size();
  for (std::size_t i = 0; i < n; ++i) {
    float distance2 = 0.0F;
    for (int axis = 0; axis < 3; ++axis) {
      const float below = low_[axis][i] - centre[axis];
      const float above = centre[axis] - high_[axis][i];
      const float out = std::max(std::max(below, above), 0.0F);
      distance2 += out * out;
    }
    in_reach_[i] = distance2 <= limit;
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (prefilter_ && !in_reach_[i]) continue;
    const auto triangle = static_cast<std::uint32_t>(i);
    const Face face{prepare_triangle(triangle), triangle, object_of_[i]};
    const auto& [a, b, c] = face.shape.corner;
    candidates_.push_back(face);
    candidate_boxes_.push_back({a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)});
  }
  counters_.candidates += candidates_.size();
}

MethodOutput ReferenceMethod::step(const MethodInput& input) noexcept {
  if (!input.p_SD.allFinite()) return {.force_n = Vec3::Zero(), .p_SP = placed_ ? to_scene(proxy_) : Vec3(Vec3::Zero()), .contact = false};
  if (!placed_) reset(input.p_SD);
  ++counters_.steps;
  const Vec3 from = device_;
  const Vec3 to = device_to_local(input.p_SD);
  const Vec3 way = to - from;
  gather(to, (proxy_ - from).norm() + way.norm() + 4.0 * rest_);
  if (candidates_.empty() && free_) {
    proxy_ = to;
  } else {
    for (int i = 1; i <= substeps_; ++i) {
      settle(i == substeps_ ? to : Vec3(from + (double(i) / substeps_) * way));
    }
  }
  device_ = to;
  const Vec3 velocity = input.dt_s > 0.0 && std::isfinite(input.dt_s) ? Vec3(way * (unit_m_ / input.dt_s)) : Vec3(Vec3::Zero());
  return felt(input.p_SD, velocity);
}

void ReferenceMethod::reset(const Vec3& p_SD) noexcept {
  counters_ = {};
  touched_.clear();
  free_ = true;
  sliding_ = false;
  placed_ = p_SD.allFinite();
  if (!placed_) return;
  device_ = device_to_local(p_SD);
  proxy_ = device_;
}

MethodOutput ReferenceMethod::settle_from(const Vec3& p_SP, const Vec3& p_SD) noexcept {
  proxy_ = to_local(p_SP);
  device_ = device_to_local(p_SD);
  placed_ = true;
  free_ = false;
  touched_.clear();
  friction_off_ = true;
  tips_borders_ = false;
  gather(device_, (proxy_ - device_).norm() + 4.0 * rest_);
  settle(device_);
  friction_off_ = false;
  tips_borders_ = true;
  return felt(p_SD, Vec3::Zero());
}

void ReferenceMethod::settle(const Vec3& device) noexcept {
  if (candidates_.empty() && touched_.empty()) {
    proxy_ = device;
    free_ = true;
    return;
  }
  ++counters_.settles;
  const Vec3 start = proxy_;
  descend(device);
  for (int i = 0; i < kMostEscapes && escape(device); ++i) ++counters_.escapes;
  free_ = proxy_ == device && touched_.empty();
  if (!free_ && (proxy_ - start).norm() <= kStill) sliding_ = false;
}

// From where the proxy is to where no straight motion brings it nearer to the device.
void ReferenceMethod::descend(const Vec3& device) noexcept {
  double nearest = std::numeric_limits<double>::infinity();
  int idle = 0;
  int motions = 0;
  for (; motions < kMostMotions && idle < kIdleMotions; ++motions) {
    look_at_touched();
    if (touched_.empty() && cross_emptiness(device)) break;
    const double distance = (device - proxy_).norm();
    idle = distance < nearest - kIdleGain ? 0 : idle + 1;
    nearest = std::min(nearest, distance);
    const Wish wish = project_wish(device - proxy_);
    if (wish.strongest != nullptr) felt_material_ = material_of(wish);
    if (wish.motion.count == 0) {
      const bool arrives = (device - proxy_).norm() <= kLongestMotion;
      if (advance(wish.motion.point) && arrives) {
        proxy_ = device;
        break;
      }
      continue;
    }
    const Vec3 motion = hold_back(wish);
    if (!(motion.norm() > kStill)) {
      if (tip_over(device, wish)) continue;
      break;
    }
    if (roll(device, wish)) continue;
    advance(motion);
  }
  look_at_touched();
  counters_.motions += static_cast<std::uint64_t>(motions);
  counters_.most_motions = std::max(counters_.most_motions, static_cast<std::uint64_t>(motions));
  if (motions == kMostMotions) ++counters_.unsettled;
}

// A point probe is a sphere only for the sake of safety, and where a fold narrows at a corner the sphere may rest against a step no higher
// than its own radius that is no obstacle to a point. So at rest the proxy is lifted by a few radii and sent along every direction the
// corner offers: the wish, its projections onto the faces near, and the edges and folds that lead towards the device. It stays where that
// ends nearer to the device by more than such a step; else it is put back.
bool ReferenceMethod::escape(const Vec3& device) noexcept {
  if (rest_ != kHover || has_friction() || touched_.empty() || proxy_ == device || is_on_open_face()) return false;
  const Vec3 start = proxy_;
  const Vec3 wish = device - start;
  const double least_gain = kEscapeGain * rest_;
  touched_before_ = touched_;
  for (const double height : {8.0 * rest_, 256.0 * rest_}) {
    collect_near(start, 2.0 * height);
    if (!lift(start, height)) continue;
    const Vec3 lifted = proxy_;
    for (const Vec3& direction : directions_out(start, wish, 2.0 * height)) {
      proxy_ = lifted;
      touched_.clear();
      advance(direction);
      if ((proxy_ - start).norm() < 8.0 * height) continue;
      descend(device);
      if ((device - proxy_).norm() < wish.norm() - least_gain) return true;
    }
    proxy_ = start;
  }
  proxy_ = start;
  touched_ = touched_before_;
  look_at_touched();
  return false;
}

// On one face alone and not at its border: there a rest is one for a point as well.
bool ReferenceMethod::is_on_open_face() const noexcept {
  if (touched_.size() != 1 || touched_[0].near.feature != TriangleFeature::kFace) return false;
  const PreparedTriangle& shape = touched_[0].face.shape;
  for (int k = 0; k < 3; ++k) {
    if (shape.inward[k].dot(proxy_ - shape.corner[k]) <= kOpenFace * rest_ * shape.edge[k].norm()) return false;
  }
  return true;
}

void ReferenceMethod::collect_near(const Vec3& p, double within) noexcept {
  near_.clear();
  for (std::size_t i = 0; i < candidates_.size() && near_.size() < kMostNear; ++i) {
    const Box& box = candidate_boxes_[i];
    if (!boxes_meet(box.low, box.high, p.array() - within, p.array() + within) || !can_touch(candidates_[i])) continue;
    const ClosestPoint near = closest_point(candidates_[i].shape, p);
    if (near.distance <= within && !near.direction.isZero(0.0)) near_.push_back({candidates_[i], near});
  }
}

// Moves the proxy by the shortest way to where it is `height` above the planes of all that is near. False when there is no such place.
bool ReferenceMethod::lift(const Vec3& start, double height) noexcept {
  half_spaces_.clear();
  for (const Touch& touch : near_) half_spaces_.push_back({touch.near.direction, height - touch.near.distance});
  const HalfSpaceProjection way = project_onto_half_spaces(Vec3::Zero(), half_spaces_, kFeasible);
  if (!way.feasible || way.point.norm() > 64.0 * height) return false;
  proxy_ = start;
  advance(way.point);
  return true;
}

const std::vector<Vec3>& ReferenceMethod::directions_out(const Vec3& start, const Vec3& wish, double within) noexcept {
  directions_.clear();
  auto add_line = [&](const Vec3& line) {
    const double length2 = line.squaredNorm();
    if (length2 > 0.0) directions_.push_back((line.dot(wish) / length2) * line);
  };
  directions_.push_back(wish);
  for (const Touch& touch : near_) {
    const PreparedTriangle& shape = touch.face.shape;
    if (shape.has_face) directions_.push_back(wish - wish.dot(shape.normal) * shape.normal);
    for (int k = 0; k < 3; ++k) {
      const double along = std::clamp(shape.edge[k].dot(start - shape.corner[k]) / std::max(shape.edge[k].squaredNorm(), 1e-300), 0.0, 1.0);
      if ((start - shape.corner[k] - along * shape.edge[k]).norm() <= within) add_line(shape.edge[k]);
    }
  }
  // Folds between faces that do not share an edge.
  for (std::size_t i = 0; i < near_.size(); ++i) {
    for (std::size_t j = i + 1; j < near_.size() && directions_.size() < kMostDirections; ++j) {
      const Vec3 fold = near_[i].face.shape.normal.cross(near_[j].face.shape.normal);
      if (fold.squaredNorm() > 1e-12) add_line(fold);
    }
  }
  return directions_;
}

// Far outside the scene there is nothing to meet: the proxy goes straight to the device, or to where its way enters the surroundings of the
// scene. True when it has arrived.
bool ReferenceMethod::cross_emptiness(const Vec3& device) noexcept {
  const double surroundings = 1.0 + 2.0 * rest_;
  if (proxy_.norm() < 1.01 * surroundings) return false;
  const Vec3 way = device - proxy_;
  const double length = way.norm();
  const double foot = length > 0.0 ? -proxy_.dot(way) / length : 0.0;
  const double miss = length > 0.0 ? (proxy_ + (foot / length) * way).norm() : surroundings;
  const double entry = foot - std::sqrt(std::max(0.0, (surroundings - miss) * (surroundings + miss)));
  if (miss >= surroundings || entry <= 0.0 || entry >= length) {
    proxy_ = device;
    return true;
  }
  proxy_ += (entry / length) * way;
  return false;
}

// Where the touched triangles are nearest now; those left behind are dropped.
void ReferenceMethod::look_at_touched() noexcept {
  for (Touch& touch : touched_) {
    touch.near = closest_point(touch.face.shape, proxy_);
    if (touch.near.distance == 0.0 && touch.near.feature != TriangleFeature::kFace) touch.near.direction = touch.face.shape.normal;
  }
  std::erase_if(touched_, [&](const Touch& touch) { return touch.near.distance > rest_ + skin_ || touch.near.direction.isZero(0.0); });
}

ReferenceMethod::Wish ReferenceMethod::project_wish(const Vec3& wish) noexcept {
  half_spaces_.clear();
  for (const Touch& touch : touched_) {
    // A proxy a little too near is led back to rest; one that starts overlapping (a reset in the surface) only may not go deeper.
    const double gap = rest_ - touch.near.distance;
    half_spaces_.push_back({touch.near.direction, gap <= 2.0 * skin_ ? gap : 0.0});
  }
  Wish result;
  result.motion = project_onto_half_spaces(wish, half_spaces_, kFeasible);
  if (!result.motion.feasible) {
    for (HalfSpace& half_space : half_spaces_) half_space.gap = std::min(half_space.gap, 0.0);
    result.motion = project_onto_half_spaces(wish, half_spaces_, kFeasible);
    if (!result.motion.feasible) {
      ++counters_.infeasible;
      result.motion.point = Vec3::Zero();
    }
  }
  double strongest = -1.0;
  for (int i = 0; i < result.motion.count; ++i) {
    if (result.motion.multiplier[i] > strongest) {
      strongest = result.motion.multiplier[i];
      result.strongest = &touched_[result.motion.active[i]];
    }
  }
  const double length = result.motion.point.norm();
  if (length > kLongestMotion) result.motion.point *= kLongestMotion / length;
  return result;
}

Material ReferenceMethod::material_of(const Wish& wish) const noexcept {
  ContactMaterial material;
  for (int i = 0; i < wish.motion.count; ++i) {
    material.add(materials_[touched_[wish.motion.active[i]].face.object], wish.motion.multiplier[i]);
  }
  return material.mean();
}

// Coulomb friction: the part of the frictionless motion that the cone leaves.
Vec3 ReferenceMethod::hold_back(const Wish& wish) noexcept {
  const Vec3& motion = wish.motion.point;
  if (!has_friction() || wish.strongest == nullptr) return motion;
  Vec3 push = Vec3::Zero();
  for (int i = 0; i < wish.motion.count; ++i) push += wish.motion.multiplier[i] * half_spaces_[wish.motion.active[i]].normal;
  const Material material = material_of(wish);
  const double way = motion.norm();
  const double held = (sliding_ ? material.friction_dynamic : material.friction_static) * push.norm();
  if (way <= held + kStill) return Vec3::Zero();
  sliding_ = true;
  const double least = material.friction_dynamic * push.norm();
  return motion * ((way - least) / way);
}

// A sphere over a single edge or corner goes round it to the point nearest to the device, or sixty degrees on.
bool ReferenceMethod::roll(const Vec3& device, const Wish& wish) noexcept {
  if (wish.motion.count != 1 || rest_ <= 16.0 * kHover || has_friction()) return false;
  const Touch& touch = *wish.strongest;
  if (touch.near.feature == TriangleFeature::kFace || touch.near.distance < rest_ - 2.0 * skin_) return false;
  const Vec3 aim = across_feature(touch, device - pivot_of(touch));
  const Vec3 sideways = aim - aim.dot(touch.near.direction) * touch.near.direction;
  const double side = sideways.norm();
  const double angle = std::min(std::atan2(side, aim.dot(touch.near.direction)), kLongestRoll);
  return side > 0.0 && angle > kLeastRoll && go_round(touch, sideways / side, angle);
}

// At rest, yet not at a minimum: on an edge or a corner with the device beyond it the proxy stands like a ball on a ridge. It goes round to
// either side if that is free and nearer to the device. The very border of a face is an edge, too. Friction would hold it there.
bool ReferenceMethod::tip_over(const Vec3& device, const Wish& wish) noexcept {
  if (has_friction()) return false;
  for (int i = 0; i < wish.motion.count; ++i) {
    Touch touch = touched_[wish.motion.active[i]];
    if (touch.near.distance < rest_ - 2.0 * skin_) continue;
    if (touch.near.feature != TriangleFeature::kFace) {
      if (tip_over(device, touch)) return true;
      continue;
    }
    for (int k = 0; k < 3 && tips_borders_; ++k) {
      const PreparedTriangle& shape = touch.face.shape;
      if (shape.inward[k].dot(proxy_ - shape.corner[k]) > kBorder * rest_ * shape.edge[k].norm()) continue;
      touch.near.feature = static_cast<TriangleFeature>(static_cast<int>(TriangleFeature::kEdge0) + k);
      if (tip_over(device, touch)) return true;
    }
  }
  return false;
}

bool ReferenceMethod::tip_over(const Vec3& device, const Touch& touch) noexcept {
  const Vec3& normal = touch.near.direction;
  if ((device - pivot_of(touch)).dot(normal) >= 0.0) return false;
  // Along an edge as well: it may end right here.
  const Vec3 first = is_edge(touch.near.feature) ? Vec3(normal.cross(edge_of(touch)).normalized()) : normal.unitOrthogonal();
  const Vec3 second = normal.cross(first);
  const Vec3 start = proxy_;
  const double tip = std::min(kLongestTip, std::sqrt(kHover / rest_));  // climbs half a hover: over no ridge that holds a sphere
  for (const Vec3& tangent : {first, Vec3(-first), second, Vec3(-second)}) {
    if (!go_round(touch, tangent, tip)) continue;
    if ((device - proxy_).squaredNorm() < (device - start).squaredNorm()) return true;
    proxy_ = start;
  }
  return false;
}

// The point the sphere touches.
Vec3 ReferenceMethod::pivot_of(const Touch& touch) const noexcept { return proxy_ - touch.near.distance * touch.near.direction; }

Vec3 ReferenceMethod::edge_of(const Touch& touch) noexcept {
  return touch.face.shape.edge[static_cast<int>(touch.near.feature) - static_cast<int>(TriangleFeature::kEdge0)];
}

Vec3 ReferenceMethod::across_feature(const Touch& touch, const Vec3& v) noexcept {
  if (!is_edge(touch.near.feature)) return v;
  const Vec3 edge = edge_of(touch);
  return v - (v.dot(edge) / edge.squaredNorm()) * edge;
}

// Round the touched edge or corner by an angle, on the two tangents at the ends of the arc. False, and nothing moved, when something is in
// the way.
bool ReferenceMethod::go_round(const Touch& touch, const Vec3& tangent, double angle) noexcept {
  const Vec3 start = proxy_;
  const Vec3 pivot = pivot_of(touch);
  const Vec3 normal = touch.near.direction;
  const Vec3 corner = pivot + rest_ * (normal + std::tan(0.5 * angle) * tangent);
  const Vec3 end = pivot + rest_ * (std::cos(angle) * normal + std::sin(angle) * tangent);
  if (advance(corner - start) && advance(end - corner)) return true;
  proxy_ = start;
  return false;
}

// Moves the proxy along the motion until it meets a triangle, which is then touched. True when it met none.
bool ReferenceMethod::advance(const Vec3& motion) noexcept {
  const Vec3 end = proxy_ + motion;
  const Vec3 low = proxy_.cwiseMin(end).array() - (rest_ + 2.0 * skin_);
  const Vec3 high = proxy_.cwiseMax(end).array() + (rest_ + 2.0 * skin_);
  double until = 1.0;
  const Face* met = nullptr;
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    const Face& face = candidates_[i];
    if (!boxes_meet(candidate_boxes_[i].low, candidate_boxes_[i].high, low, high) || !can_touch(face)) continue;
    const double distance = closest_point(face.shape, proxy_).distance;
    // At rest less the skin the motion ends. Where that is already used up a motion may take one erosion more, but
    // never below half, so the sum over any number of motions stays on the proxy's side.
    double limit = std::min(rest_ - skin_, distance - kErosion);
    if (distance < 0.5 * rest_) limit = distance;
    const SweepHit found = sweep_point(face.shape, proxy_, motion, until, limit, 0.5 * kErosion, kRounding);
    if (found.hit) {
      until = found.t;
      met = &face;
    }
  }
  proxy_ = met == nullptr ? end : Vec3(proxy_ + until * motion);
  if (met != nullptr) touch(*met);
  return met == nullptr;
}

void ReferenceMethod::touch(const Face& face) noexcept {
  for (const Touch& known : touched_) {
    if (known.face.triangle == face.triangle) return;
  }
  if (touched_.size() == kMostTouched) touched_.erase(touched_.begin());
  touched_.push_back({face, closest_point(face.shape, proxy_)});
}

// A one-sided surface is met only from the side its normal points to.
bool ReferenceMethod::can_touch(const Face& face) const noexcept {
  if (materials_[face.object].two_sided) return true;
  return face.shape.has_face && face.shape.normal.dot(proxy_ - face.shape.corner[face.shape.base]) > 0.0;
}

MethodOutput ReferenceMethod::felt(const Vec3& p_SD, const Vec3& velocity_m_per_s) const noexcept {
  MethodOutput output;
  output.p_SP = proxy_ == device_ ? p_SD : to_scene(proxy_);
  const Vec3 stretch = (proxy_ - device_) * unit_m_;
  const double length = stretch.norm();
  if (!(length > 0.0)) return output;
  const double along = velocity_m_per_s.dot(stretch) / length;
  const double strength = felt_material_.stiffness_n_per_m * length - felt_material_.damping_ns_per_m * along;
  if (!(strength > 0.0)) return output;
  output.force_n = stretch * (strength / length);
  output.contact = true;
  return output;
}

std::string ReferenceMethod::describe() const {
  const double steps = std::max<double>(1.0, static_cast<double>(counters_.steps));
  return fmt::format(
      "reference: {} triangles, no search structure, {} sub-steps a step, proxy rests at {:.3g} m\n"
      "  {} steps, {:.1f} triangles in reach and {:.2f} motions a step, at most {} in one sub-step; {} escapes, {} unsettled, {} "
      "infeasible\n",
      triangles_.size(), substeps_, rest_ * unit_m_, counters_.steps, static_cast<double>(counters_.candidates) / steps,
      static_cast<double>(counters_.motions) / steps, counters_.most_motions, counters_.escapes, counters_.unsettled, counters_.infeasible);
}

}  // namespace hapton
