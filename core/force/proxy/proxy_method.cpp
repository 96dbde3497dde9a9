#include "core/force/proxy/proxy_method.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/force/contact_material.h"

namespace hapton {

namespace {

constexpr double kFarthestGoal = 0x1p10;  // local units

std::vector<std::shared_ptr<const TriangleMesh>> meshes_of(const TouchScene& scene) {
  std::vector<std::shared_ptr<const TriangleMesh>> meshes;
  for (const TouchObject& object : scene.objects) meshes.push_back(object.mesh);
  return meshes;
}

std::vector<Material> materials_of(const TouchScene& scene) {
  std::vector<Material> materials;
  for (const TouchObject& object : scene.objects) materials.push_back(object.material);
  return materials;
}

// A device farther out than a billion scenes is taken to be there: its squares must stay finite.
Vec3 within_limits(const Vec3& local) {
  constexpr double kFarthest = 0x1p30;
  constexpr double kHuge = 1e200;  // what overflowed on the way into local units is as good as this
  const Vec3 finite = local.cwiseMax(-kHuge).cwiseMin(kHuge);
  const double most = finite.cwiseAbs().maxCoeff();
  return most > kFarthest ? Vec3(finite * (kFarthest / most)) : finite;
}

}  // namespace

Result<std::unique_ptr<ForceMethod>> ProxyMethod::make(const MethodSettings& settings, const TouchScene& scene) {
  if (!(settings.shading >= 0.0 && settings.shading <= 1.0)) return fail("proxy: a shading of {:g}; give 0 to 1", settings.shading);
  if (!(settings.crease_deg >= 0.0 && settings.crease_deg <= 180.0)) {
    return fail("proxy: a crease angle of {:g} degrees; give 0 to 180", settings.crease_deg);
  }
  if (auto fits = TouchGeometry::check(meshes_of(scene)); !fits) return fail("proxy: {}", fits.error().what);
  return std::unique_ptr<ForceMethod>(new ProxyMethod(settings, scene));
}

ProxyMethod::ProxyMethod(const MethodSettings& settings, const TouchScene& scene)
    : geometry_(meshes_of(scene), settings.build_on_approach ? BuildPolicy::on_approach : BuildPolicy::at_once,
                settings.shading > 0.0 ? std::optional(settings.crease_deg * std::numbers::pi / 180.0) : std::nullopt),
      surfaces_(materials_of(scene)),
      shading_(settings.shading),
      surface_(geometry_, surfaces_),
      glance_(geometry_, surfaces_) {
  for (const TouchObject& object : scene.objects) {
    has_one_sided_ |= !object.material.two_sided;
    has_friction_ |= object.material.friction_static > 0.0;
  }
  // hover: 2^21 times the rounding of local coordinates, so distances of this size keep six digits; and far below what is felt
  // (1e-10 m on a 100 mm scene).
  constexpr double kHover = 0x1p-30;
  hover_ = kHover;
  is_point_ = settings.probe_radius_m == 0.0;
  clearance_.rest = settings.probe_radius_m / geometry_.unit_m() + kHover;
  clearance_.slack = 0.5 * kHover;
  clearance_.tolerance = 0x1p-10 * kHover;
  // A sphere hardly larger than the hover has too few digits for a surface of its own.
  constexpr double kLeastRadius = 0x1p-20;
  if (clearance_.rest - kHover >= kLeastRadius) sphere_ = std::make_unique<SphereFollower>(geometry_, surfaces_, clearance_.rest);
  // For what a point cannot walk on: as small as the reference's, so that it goes wherever that goes.
  if (is_point_) sphere_ = std::make_unique<SphereFollower>(geometry_, surfaces_, 0.5 * kHover, true);
  off_ = hover_;
}

Material ProxyMethod::touched_material() const noexcept {
  const int count = std::min(pushing_count_, touching_count_);
  if (count < 2) return surfaces_[touching_count_ > 0 ? geometry_.mesh_of(touching_[0].triangle) : 0];
  ContactMaterial material;
  for (int i = 0; i < count; ++i) material.add(surfaces_[geometry_.mesh_of(touching_[i].triangle)], push_[i]);
  return material.mean();
}

Material ProxyMethod::material_of(const ConstrainedMotion& held) const noexcept {
  ContactMaterial material;
  for (int i = 0; i < held.active_count; ++i) material.add(surfaces_[geometry_.mesh_of(touching_[held.active[i]].triangle)], held.push[i]);
  return held.active_count > 0 ? material.mean() : touched_material();
}

bool ProxyMethod::can_touch(std::uint32_t triangle, const Vec3& p) const noexcept {
  if (!has_one_sided_ || surfaces_[geometry_.mesh_of(triangle)].two_sided) return true;
  const Vec3& a = geometry_.corner(triangle, 0);
  return accurate_cross(geometry_.corner(triangle, 1) - a, geometry_.corner(triangle, 2) - a).dot(p - a) > 0.0;
}

void ProxyMethod::reset(const Vec3& p_SD) noexcept {
  surface_.leave();
  if (sphere_ != nullptr) sphere_->leave();
  placed_ = p_SD.allFinite();
  settle_at(within_limits(geometry_.to_local(p_SD)));
  geometry_.place(proxy_);
  step_off_surface();
  last_device_ = proxy_;
  near_reach_ = 0.0;
  forget_near();
  exits_from_ = Vec3::Constant(std::numeric_limits<double>::infinity());
  empty_radius_squared_m2_ = 0.0;
  empty_retry_ = 0.0;
}

// A point probe placed on a surface has no side yet: it takes the one the triangle's vertex order shows.
void ProxyMethod::step_off_surface() noexcept {
  if (!is_point_ || !placed_) return;
  for (int i = 0; i < 8; ++i) {  // at an edge or corner each of its faces in turn
    std::uint32_t nearest = 0;
    double bound = clearance_.rest * clearance_.rest;
    bool any = false;
    geometry_.visit_nearest(proxy_, bound, [&](std::uint32_t triangle, double) {
      const double d = geometry_.separation(triangle, proxy_).distance;
      if (d * d < bound) {
        bound = d * d;
        nearest = triangle;
        any = true;
      }
      return bound;
    });
    if (!any) return;
    const Vec3& a = geometry_.corner(nearest, 0);
    const Vec3 normal = accurate_cross(geometry_.corner(nearest, 1) - a, geometry_.corner(nearest, 2) - a);
    const double length = normal.norm();
    proxy_ += (2.0 * clearance_.rest) * (length > 0.0 ? Vec3(normal / length) : geometry_.separation(nearest, proxy_).normal);
  }
}

void ProxyMethod::settle_at(const Vec3& p) noexcept {
  proxy_ = p;
  free_ = true;
  off_ = hover_;
  sliding_ = false;
  touching_count_ = 0;
  pushing_count_ = 0;
}

// In a known empty ball the proxy is free and a step is this comparison; what is not finite is not in it.
MethodOutput ProxyMethod::step(const MethodInput& input) noexcept {
  if (!((input.p_SD - empty_center_S_).squaredNorm() < empty_radius_squared_m2_)) return step_outside(input);
  ++counters_.steps;
  ++counters_.skipped;
  last_free_S_ = input.p_SD;
  return {.force_n = Vec3::Zero(), .p_SP = input.p_SD, .contact = false};
}

MethodOutput ProxyMethod::step_outside(const MethodInput& input) noexcept {
  leave_ball();
  if (!input.p_SD.allFinite()) return {.force_n = Vec3::Zero(), .p_SP = geometry_.to_scene(proxy_), .contact = false};
  ++counters_.steps;
  const Vec3 device = within_limits(geometry_.to_local(input.p_SD));
  if (!placed_) reset(input.p_SD);
  const Vec3 last = last_device_;
  const Vec3 moved = device - last;
  stride_ = moved.norm();
  last_device_ = device;
  const std::size_t waiting = geometry_.waiting_count();
  const double may_go = geometry_.look_ahead(proxy_, kLookAheadSteps * stride_);
  if (geometry_.waiting_count() != waiting) forget_near();  // what came in is not there yet
  const double way = (device - proxy_).norm();
  const double clear = free_ && empty_retry_ <= 0.0 ? find_empty_ball(device, may_go - way) : 0.0;
  empty_retry_ -= stride_;
  if (way < clear) {
    settle_at(device);
    enter_ball(input.p_SD, clear);
  } else {
    const std::uint64_t events = surface_.events();
    follow(last, device);
    counters_.most_events = std::max(counters_.most_events, surface_.events() - events);
  }
  if (free_) return {.force_n = Vec3::Zero(), .p_SP = input.p_SD, .contact = false};

  ++counters_.contact_steps;
  const Vec3 p_SP = geometry_.to_scene(proxy_);
  const double speed_m_per_s = input.dt_s > 0.0 ? geometry_.unit_m() / input.dt_s : 0.0;
  // The surface itself is one hover nearer to the device than the proxy.
  const Vec3 stretch = proxy_ - device;
  const double length = stretch.norm();
  const Vec3 turned = shading_ > 0.0 ? shaded(stretch) : stretch;
  const Vec3 felt = length > off_ ? Vec3(turned * ((length - off_) / length * geometry_.unit_m())) : Vec3::Zero();
  return {.force_n = force_of(felt, moved * speed_m_per_s), .p_SP = p_SP, .contact = length > off_};
}

// The planes that hold the proxy, made the first of those it touches.
void ProxyMethod::bring_pushing_first(const ConstrainedMotion& held) noexcept {
  std::array<int, 3> at = held.active;
  for (int i = 0; i < held.active_count; ++i) {
    if (at[i] == i) continue;
    std::swap(touching_[i], touching_[at[i]]);
    for (int j = i + 1; j < held.active_count; ++j) {
      if (at[j] == i) at[j] = at[i];  // it was moved to make room
    }
  }
  push_ = held.push;
  pushing_count_ = held.active_count;
}

// The stretch is the sum of push * normal over the planes that hold the proxy: the same sum over smooth normals gives the direction.
Vec3 ProxyMethod::shaded(const Vec3& stretch) noexcept {
  Vec3 smooth = Vec3::Zero();
  for (int i = 0; i < std::min(pushing_count_, touching_count_); ++i) {
    const Separation& s = touching_[i].separation;
    Vec3 normal = geometry_.smooth_normal(touching_[i].triangle, s.nearest);
    if (normal.dot(s.normal) < 0.0) normal = -normal;  // two-sided
    smooth += push_[i] * normal;
  }
  const double length = stretch.norm();
  const double smooth_length = smooth.norm();
  if (!(length > 0.0) || !(smooth_length > 0.0) || smooth.dot(stretch) <= 0.0) return stretch;
  const Vec3 mixed = (1.0 - shading_) * (stretch / length) + shading_ * (smooth / smooth_length);
  const Vec3 result = mixed * (length / mixed.norm());
  const double turned = (result - stretch).norm() / length;
  counters_.shading_squared += turned * turned;
  counters_.shading_most = std::max(counters_.shading_most, turned);
  return result;
}

// Hooke's law, less damping along the stretch; damping never pulls in.
Vec3 ProxyMethod::force_of(const Vec3& stretch_m, const Vec3& velocity_m_per_s) const noexcept {
  const Material material = touched_material();
  const Vec3 spring = material.stiffness_n_per_m * stretch_m;
  const double length = stretch_m.norm();
  if (material.damping_ns_per_m == 0.0 || length == 0.0) return spring;
  const Vec3 direction = stretch_m / length;
  const double drag = material.damping_ns_per_m * velocity_m_per_s.dot(direction);
  return std::max(0.0, spring.norm() - drag) * direction;
}

bool ProxyMethod::fold_had_a_say() const noexcept { return met_fold_ || before_.pushing_count > 1 || pushing_count_ > 1; }

// Whether this step went farther than the device did, by more than the curve of what it slides on explains. From fold to fold any such
// step may have let go of one.
bool ProxyMethod::has_caught_up() const noexcept {
  if (before_.free || free_) return false;
  return (proxy_ - before_.proxy).norm() > (fold_had_a_say() ? kCatchUpFold : kCatchUp) * stride_;
}

// Of the planes of a fold that held the point, one holds it no longer. A ball changes those wherever it rolls.
bool ProxyMethod::has_left_fold() const noexcept {
  if (!is_point_ || before_.pushing_count < 2) return false;
  const auto holds = touching_.begin() + pushing_count_;
  return std::any_of(before_.triangles.begin(), before_.triangles.begin() + before_.pushing_count, [&](std::uint32_t held) {
    return std::none_of(touching_.begin(), holds, [&](const Touch& touch) { return touch.triangle == held; });
  });
}

// Whether the way taken within the step may be another than that of a device that moves there bit by bit.
ProxyMethod::Doubt ProxyMethod::doubt_of_step() const noexcept {
  if (before_.free != free_ || has_left_fold()) return Doubt::great;
  if (!has_caught_up()) return Doubt::none;
  const bool has_swept = sweeps_left_ < kMaxSweeps;
  return has_swept || (proxy_ - before_.proxy).norm() > kLeap * stride_ ? Doubt::great : Doubt::slight;
}

// Follows the device from one sample to the next. Where the proxy lets go of a ridge or fold, the way it takes depends on where the device
// was just then: such a step is done again in many parts. In two where it only went farther than the device, from facet to facet: mostly
// they lead to the same place.
void ProxyMethod::follow_by_sweeps(const Vec3& last, const Vec3& device) noexcept {
  save(before_);
  met_fold_ = false;
  solve(device);
  const Doubt doubt = doubt_of_step();
  if (doubt == Doubt::none) return;
  ++counters_.redone;
  if (doubt == Doubt::slight) {
    const Vec3 at_once = proxy_;
    follow_in_parts(last, device, 2);
    if ((proxy_ - at_once).norm() <= kSamePlace * stride_ + kBeside * hover_) return;
  }
  ++counters_.divided;
  follow_in_parts(last, device, kParts);
}

// A part in which the proxy leaps lets go of something within: it is done in parts itself.
void ProxyMethod::follow_in_parts(const Vec3& last, const Vec3& device, int parts) noexcept {
  restore(before_);
  const Vec3 way = (device - last) / parts;
  for (int part = 0; part < parts; ++part) {
    const Vec3 from = last + part * way;
    const Vec3 to = part + 1 < parts ? Vec3(from + way) : device;
    save(part_);
    const int sweeps_before = sweeps_left_;
    solve(to);
    if (free_ || (proxy_ - part_.proxy).norm() <= kLetGo * way.norm()) continue;
    if ((4 + parts - part) * (sweeps_before - sweeps_left_) > sweeps_left_) continue;  // it might end short for want of sweeps
    restore(part_);
    for (int i = 1; i <= kParts; ++i) solve(i < kParts ? Vec3(from + (static_cast<double>(i) / kParts) * way) : to);
  }
}

ContactTriangle ProxyMethod::shape_of(std::uint32_t triangle) const noexcept {
  return {geometry_.corner(triangle, 0), geometry_.corner(triangle, 1), geometry_.corner(triangle, 2)};
}

void ProxyMethod::save(Stand& stand) const noexcept {
  stand.proxy = proxy_;
  stand.free = free_;
  stand.sliding = sliding_;
  for (int i = 0; i < touching_count_; ++i) {
    stand.triangles[i] = touching_[i].triangle;
    stand.separations[i] = touching_[i].separation;
  }
  stand.touching_count = touching_count_;
  stand.push = push_;
  stand.pushing_count = pushing_count_;
}

void ProxyMethod::restore(const Stand& stand) noexcept {
  proxy_ = stand.proxy;
  free_ = stand.free;
  sliding_ = stand.sliding;
  for (int i = 0; i < stand.touching_count; ++i) {
    touching_[i] = {.triangle = stand.triangles[i], .shape = shape_of(stand.triangles[i]), .separation = stand.separations[i]};
  }
  touching_count_ = stand.touching_count;
  push_ = stand.push;
  pushing_count_ = stand.pushing_count;
}

// No motion need be longer than to cross the scene.
Vec3 ProxyMethod::shortened(const Vec3& motion) noexcept {
  const double length = motion.norm();
  return length > kLongestMotion ? Vec3(motion * (kLongestMotion / length)) : motion;
}

void ProxyMethod::solve(const Vec3& device) noexcept {
  if (walk(device)) return;
  const Vec3 from = proxy_;
  descend(device);
  if (!is_point_) look_ahead(proxy_ - from);
  for (int i = 0; i < kMaxEscapes && !free_ && sweeps_left_ > kEscapeSweeps && escape(device); ++i) ++counters_.escapes;
}

// Moves the proxy to the constrained minimum. Every pass either moves it nearer to the device or adds a plane to the set that holds it.
void ProxyMethod::descend(const Vec3& device) noexcept {
  pushing_count_ = 0;                                  // until it is at rest
  const double rest_of_motion = clearance_.tolerance;  // shorter motions are below the clearance's own slack
  constexpr double kRounding = 0x1p-48;                // of a distance within the scene
  constexpr double kNormalError = 0x1p-24;  // of the goal: what the normal of an edge at hover distance may be off (point_triangle.h)
  double nearest = std::numeric_limits<double>::infinity();
  int idle = 0;
  int last_doubt = kMaxIterations;
  for (int i = 0; i < kMaxIterations && sweeps_left_ > 0; ++i) {
    if (touching_count_ == 0 && cross_emptiness(device)) return;
    Vec3 goal = device - proxy_;
    const double distance = goal.norm();
    const bool arrives = distance <= kLongestMotion;
    if (distance > kFarthestGoal) goal *= kFarthestGoal / distance;  // a device far away must not cost the digits of what is near
    idle = distance < nearest - kRounding ? 0 : idle + 1;
    nearest = std::min(nearest, distance);
    if (idle > kMaxIdle && touching_count_ > 0) {  // caged: moves back and forth within the clearance's slack
      pushing_count_ = 1;
      push_[0] = distance;
      return;
    }
    if (touching_count_ == 0) {
      if (advance(shortened(goal))) {
        free_ = false;
      } else if (arrives) {
        settle_at(device);
        return;
      }
      continue;
    }
    ++counters_.iterations;
    const ConstrainedMotion constrained = next_motion(goal);
    const Vec3 motion = has_friction_ ? rub(goal, constrained) : constrained.motion;
    if (motion.norm() <= rest_of_motion + kNormalError * distance) {
      if (i < last_doubt && forget_doubtful(constrained)) {
        last_doubt = 0;
        continue;
      }
      bring_pushing_first(constrained);
      return;
    }
    if (!advance(shortened(motion)) && constrained.active_count == 0 && arrives) {
      settle_at(device);
      return;
    }
  }
  ++counters_.unconverged;
}

// Far outside the scene there is nothing to meet, and positions there are too coarse to meet it exactly: the proxy goes straight to the
// device (true), or to where its way enters the scene's surroundings.
bool ProxyMethod::cross_emptiness(const Vec3& device) noexcept {
  const double surroundings = 2.0 + 2.0 * clearance_.rest;
  if (proxy_.norm() <= 1.01 * surroundings) return false;
  const Vec3 way = device - proxy_;
  const double length = way.norm();
  const Vec3 direction = length > 0.0 ? Vec3(way / length) : Vec3::Zero();
  const double foot = -proxy_.dot(direction);
  const double miss = (proxy_ + foot * direction).norm();
  const double entry = foot - std::sqrt(std::max(0.0, (surroundings - miss) * (surroundings + miss)));
  if (miss >= surroundings || entry <= 0.0 || entry >= length) {
    settle_at(device);
    return true;
  }
  proxy_ += entry * direction;
  return false;
}

// A point probe held by an edge or vertex may only be held by its rounding: forgets such touches, so that the next sweep says
// whether they really block. False when there are none.
bool ProxyMethod::forget_doubtful(const ConstrainedMotion& held) noexcept {
  if (!is_point_) return false;
  bool any = false;
  for (int i = 0; i < held.active_count; ++i) any |= touching_[held.active[i]].separation.feature != Feature::face;
  if (!any) return false;
  const auto end = std::remove_if(touching_.begin(), touching_.begin() + touching_count_,
                                  [](const Touch& touch) { return touch.separation.feature != Feature::face; });
  touching_count_ = static_cast<int>(end - touching_.begin());
  return true;
}

ConstrainedMotion ProxyMethod::next_motion(const Vec3& goal) noexcept {
  for (int i = 0; i < touching_count_; ++i) {
    const Separation& s = touching_[i].separation;
    planes_[i] = {s.normal, clearance_.rest - s.distance};
  }
  return constrain_motion(goal, std::span<const ContactPlane>(planes_.data(), static_cast<std::size_t>(touching_count_)));
}

// Coulomb friction: the frictionless goal lies `depth` above the device; the proxy may stay up to mu * depth short of it.
Vec3 ProxyMethod::rub(const Vec3& goal, const ConstrainedMotion& constrained) noexcept {
  const Vec3& motion = constrained.motion;
  const Material material = material_of(constrained);
  const double depth = (goal - motion).norm();
  const double way = motion.norm();
  const double hold = (sliding_ ? material.friction_dynamic : material.friction_static) * depth;
  if (way <= hold + clearance_.slack) {
    if (way < 0.5 * material.friction_dynamic * depth) sliding_ = false;
    return Vec3::Zero();
  }
  sliding_ = true;
  return motion * (1.0 - material.friction_dynamic * depth / way);
}

// A ball round the device with no triangle in it: how far the probe may go there. The search is no wider than 64 strides, and is not
// repeated before a part of what it found has been travelled. What lies hardly nearer than what is known is not looked at: over an even
// surface that would be thousands of triangles, for a ball hardly larger.
double ProxyMethod::find_empty_ball(const Vec3& device, double may_go) noexcept {
  constexpr double kHardlyNearer = 0.75 * 0.75;  // of squares
  const double widest = 64.0 * stride_ + 4.0 * clearance_.rest;
  double clear_squared = widest * widest;
  geometry_.visit_nearest(device, clear_squared, [&](std::uint32_t triangle, double bound) {
    const double d = geometry_.separation(triangle, device).distance;
    clear_squared = std::min(bound, kHardlyNearer * d * d);
    return clear_squared;
  });
  // Shorter by what the way into local units rounds to.
  const double radius = std::min(std::sqrt(clear_squared) * (1.0 - 0x1p-40) - clearance_.rest, may_go) - 0x1p-48 * (1.0 + device.norm());
  empty_retry_ = std::max(0.25 * radius, 4.0 * stride_);
  return std::max(radius, 0.0);
}

// From here on a step within the ball round the sample is one comparison, in the sample's own frame.
void ProxyMethod::enter_ball(const Vec3& p_SD, double radius) noexcept {
  const double radius_m = radius * geometry_.unit_m();
  empty_center_S_ = p_SD;
  last_free_S_ = p_SD;
  empty_radius_squared_m2_ = std::min(radius_m * radius_m, std::numeric_limits<double>::max());
}

// The proxy is where the steps in the ball left it, and the ball is forgotten: who has left it may come back through a face.
void ProxyMethod::leave_ball() noexcept {
  if (empty_radius_squared_m2_ == 0.0) return;
  empty_radius_squared_m2_ = 0.0;
  proxy_ = within_limits(geometry_.to_local(last_free_S_));
  last_device_ = proxy_;
  empty_retry_ -= (proxy_ - geometry_.to_local(empty_center_S_)).norm();
}

bool ProxyMethod::prepare() { return geometry_.build_wanted(); }

}  // namespace hapton
