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

// Clamps a device farther out than a billion scene sizes to that distance, so that its squares stay finite.
Vec3 within_limits(const Vec3& local) {
  constexpr double kFarthest = 0x1p30;
  constexpr double kHuge = 1e200;  // replaces a coordinate that overflowed in the conversion
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
      vertex_probe_(geometry_, surfaces_) {
  for (const TouchObject& object : scene.objects) {
    has_one_sided_ |= !object.material.two_sided;
    has_friction_ |= object.material.friction_static > 0.0;
  }
  // 2^21 times the rounding of local coordinates, so distances of this size keep six digits; far below what can be felt (1e-10 m on a 100
  // mm scene).
  constexpr double kContactOffset = 0x1p-30;
  contact_offset_ = kContactOffset;
  is_point_ = settings.probe_radius_m == 0.0;
  clearance_.offset = settings.probe_radius_m / geometry_.unit_m() + kContactOffset;
  clearance_.slop = 0.5 * kContactOffset;
  clearance_.tolerance = 0x1p-10 * kContactOffset;
  // The offset surface of a smaller sphere has too few significant digits.
  constexpr double kLeastRadius = 0x1p-20;
  if (clearance_.offset - kContactOffset >= kLeastRadius) sphere_ = std::make_unique<SphereFollower>(geometry_, surfaces_, clearance_.offset);
  // For points on triangles that are not walkable. The radius is the reference's, so the proxy fits wherever the reference does.
  if (is_point_) sphere_ = std::make_unique<SphereFollower>(geometry_, surfaces_, 0.5 * kContactOffset, true);
  active_offset_ = contact_offset_;
}

Material ProxyMethod::contact_material() const noexcept {
  const int count = std::min(active_count_, contact_count_);
  if (count < 2) return surfaces_[contact_count_ > 0 ? geometry_.mesh_of(contacts_[0].triangle) : 0];
  ContactMaterial material;
  for (int i = 0; i < count; ++i) material.add(surfaces_[geometry_.mesh_of(contacts_[i].triangle)], multipliers_[i]);
  return material.mean();
}

Material ProxyMethod::material_of(const ConstrainedMotion& held) const noexcept {
  ContactMaterial material;
  for (int i = 0; i < held.active_count; ++i)
    material.add(surfaces_[geometry_.mesh_of(contacts_[held.active[i]].triangle)], held.multipliers[i]);
  return held.active_count > 0 ? material.mean() : contact_material();
}

bool ProxyMethod::can_touch(std::uint32_t triangle, const Vec3& p) const noexcept {
  if (!has_one_sided_ || surfaces_[geometry_.mesh_of(triangle)].two_sided) return true;
  const Vec3& a = geometry_.corner(triangle, 0);
  return accurate_cross(geometry_.corner(triangle, 1) - a, geometry_.corner(triangle, 2) - a).dot(p - a) > 0.0;
}

void ProxyMethod::reset(const Vec3& p_SD) noexcept {
  surface_.leave();
  if (sphere_ != nullptr) sphere_->stop_tracking();
  has_sample_ = p_SD.allFinite();
  settle_at(within_limits(geometry_.to_local(p_SD)));
  geometry_.place_probe(proxy_);
  step_off_surface();
  last_device_ = proxy_;
  cache_radius_ = 0.0;
  forget_near();
  exits_from_ = Vec3::Constant(std::numeric_limits<double>::infinity());
  empty_radius_squared_m2_ = 0.0;
  empty_retry_ = 0.0;
}

// A point probe placed exactly on a surface takes the side that the triangle's vertex order shows.
void ProxyMethod::step_off_surface() noexcept {
  if (!is_point_ || !has_sample_) return;
  for (int i = 0; i < 8; ++i) {  // at an edge or vertex, each face in turn
    std::uint32_t nearest = 0;
    double bound = clearance_.offset * clearance_.offset;
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
    proxy_ += (2.0 * clearance_.offset) * (length > 0.0 ? Vec3(normal / length) : geometry_.separation(nearest, proxy_).normal);
  }
}

void ProxyMethod::settle_at(const Vec3& p) noexcept {
  proxy_ = p;
  free_ = true;
  active_offset_ = contact_offset_;
  sliding_ = false;
  contact_count_ = 0;
  active_count_ = 0;
}

// Within a known empty ball the proxy is free and the step is this one comparison, which fails for samples that are not finite.
MethodOutput ProxyMethod::step(const MethodInput& input) noexcept {
  if (!((input.p_SD - empty_centre_S_).squaredNorm() < empty_radius_squared_m2_)) return step_outside(input);
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
  if (!has_sample_) reset(input.p_SD);
  const Vec3 last = last_device_;
  const Vec3 moved = device - last;
  displacement_ = moved.norm();
  last_device_ = device;
  const std::size_t waiting = geometry_.waiting_count();
  const double may_go = geometry_.request_ahead(proxy_, kLookAheadSteps * displacement_);
  if (geometry_.waiting_count() != waiting) forget_near();  // new objects are not in the caches
  const double distance = (device - proxy_).norm();
  const double clear = free_ && empty_retry_ <= 0.0 ? find_empty_ball(device, may_go - distance) : 0.0;
  empty_retry_ -= displacement_;
  if (distance < clear) {
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
  // The surface is one contact offset nearer to the device than the proxy.
  const Vec3 extension = proxy_ - device;
  const double length = extension.norm();
  const Vec3 turned = shading_ > 0.0 ? shaded(extension) : extension;
  const Vec3 extension_m =
      length > active_offset_ ? Vec3(turned * ((length - active_offset_) / length * geometry_.unit_m())) : Vec3::Zero();
  return {.force_n = force_of(extension_m, moved * speed_m_per_s), .p_SP = p_SP, .contact = length > active_offset_};
}

// Reorders contacts_ so that the active constraints come first.
void ProxyMethod::bring_active_first(const ConstrainedMotion& held) noexcept {
  std::array<int, 3> at = held.active;
  for (int i = 0; i < held.active_count; ++i) {
    if (at[i] == i) continue;
    std::swap(contacts_[i], contacts_[at[i]]);
    for (int j = i + 1; j < held.active_count; ++j) {
      if (at[j] == i) at[j] = at[i];  // swapped away above
    }
  }
  multipliers_ = held.multipliers;
  active_count_ = held.active_count;
}

// The spring extension is the sum of multiplier * normal over the active constraints; the same sum over smooth normals gives the shaded
// direction.
Vec3 ProxyMethod::shaded(const Vec3& extension) noexcept {
  Vec3 smooth = Vec3::Zero();
  for (int i = 0; i < std::min(active_count_, contact_count_); ++i) {
    const Separation& s = contacts_[i].separation;
    Vec3 normal = geometry_.smooth_normal(contacts_[i].triangle, s.nearest);
    if (normal.dot(s.normal) < 0.0) normal = -normal;  // two-sided
    smooth += multipliers_[i] * normal;
  }
  const double length = extension.norm();
  const double smooth_length = smooth.norm();
  if (!(length > 0.0) || !(smooth_length > 0.0) || smooth.dot(extension) <= 0.0) return extension;
  const Vec3 mixed = (1.0 - shading_) * (extension / length) + shading_ * (smooth / smooth_length);
  const Vec3 result = mixed * (length / mixed.norm());
  const double turned = (result - extension).norm() / length;
  counters_.shading_squared += turned * turned;
  counters_.shading_most = std::max(counters_.shading_most, turned);
  return result;
}

// Hooke's law, less damping along the extension; damping never makes the force attractive.
Vec3 ProxyMethod::force_of(const Vec3& extension_m, const Vec3& velocity_m_per_s) const noexcept {
  const Material material = contact_material();
  const Vec3 spring = material.stiffness_n_per_m * extension_m;
  const double length = extension_m.norm();
  if (material.damping_ns_per_m == 0.0 || length == 0.0) return spring;
  const Vec3 direction = extension_m / length;
  const double drag = material.damping_ns_per_m * velocity_m_per_s.dot(direction);
  return std::max(0.0, spring.norm() - drag) * direction;
}

bool ProxyMethod::involves_concave_edge() const noexcept { return met_concave_edge_ || before_step_.active_count > 1 || active_count_ > 1; }

// Whether the proxy moved farther than the device by more than the curvature of the surface explains. Where a concave edge is involved, any
// such step may have released a constraint.
bool ProxyMethod::has_outrun_device() const noexcept {
  if (before_step_.free || free_) return false;
  return (proxy_ - before_step_.proxy).norm() > (involves_concave_edge() ? kOutrunAtConcaveEdge : kOutrun) * displacement_;
}

// Whether a constraint of the concave edge that held the point was released. For a sphere constraints change all the time, so this applies
// to points only.
bool ProxyMethod::has_left_concave_edge() const noexcept {
  if (!is_point_ || before_step_.active_count < 2) return false;
  const auto holding_end = contacts_.begin() + active_count_;
  return std::any_of(before_step_.triangles.begin(), before_step_.triangles.begin() + before_step_.active_count, [&](std::uint32_t held) {
    return std::none_of(contacts_.begin(), holding_end, [&](const Contact& contact) { return contact.triangle == held; });
  });
}

// Whether following the device in smaller steps might have led elsewhere.
ProxyMethod::Doubt ProxyMethod::doubt_of_step() const noexcept {
  if (before_step_.free != free_ || has_left_concave_edge()) return Doubt::great;
  if (!has_outrun_device()) return Doubt::none;
  const bool has_swept = sweeps_left_ < kMaxSweeps;
  return has_swept || (proxy_ - before_step_.proxy).norm() > kJump * displacement_ ? Doubt::great : Doubt::slight;
}

// Follows the device from one sample to the next. Where the proxy leaves a convex or concave edge, its path depends on where the device was
// at that moment, so the step is repeated in sub-steps: two if the proxy only moved farther than the device (mostly that gives the same
// position), otherwise kSubsteps.
void ProxyMethod::follow_by_sweeps(const Vec3& last, const Vec3& device) noexcept {
  save(before_step_);
  met_concave_edge_ = false;
  solve(device);
  const Doubt doubt = doubt_of_step();
  if (doubt == Doubt::none) return;
  ++counters_.substepped;
  if (doubt == Doubt::slight) {
    const Vec3 at_once = proxy_;
    follow_in_substeps(last, device, 2);
    if ((proxy_ - at_once).norm() <= kSamePosition * displacement_ + kBeside * contact_offset_) return;
  }
  ++counters_.substepped_finely;
  follow_in_substeps(last, device, kSubsteps);
}

// A sub-step in which the proxy jumps contains a release and is itself divided.
void ProxyMethod::follow_in_substeps(const Vec3& last, const Vec3& device, int count) noexcept {
  restore(before_step_);
  const Vec3 motion = (device - last) / count;
  for (int substep = 0; substep < count; ++substep) {
    const Vec3 from = last + substep * motion;
    const Vec3 to = substep + 1 < count ? Vec3(from + motion) : device;
    save(before_substep_);
    const int sweeps_before = sweeps_left_;
    solve(to);
    if (free_ || (proxy_ - before_substep_.proxy).norm() <= kReleaseJump * motion.norm()) continue;
    if ((4 + count - substep) * (sweeps_before - sweeps_left_) > sweeps_left_) continue;  // it might run out of sweeps before the end
    restore(before_substep_);
    for (int i = 1; i <= kSubsteps; ++i) solve(i < kSubsteps ? Vec3(from + (static_cast<double>(i) / kSubsteps) * motion) : to);
  }
}

ContactTriangle ProxyMethod::shape_of(std::uint32_t triangle) const noexcept {
  return {geometry_.corner(triangle, 0), geometry_.corner(triangle, 1), geometry_.corner(triangle, 2)};
}

void ProxyMethod::save(State& state) const noexcept {
  state.proxy = proxy_;
  state.free = free_;
  state.sliding = sliding_;
  for (int i = 0; i < contact_count_; ++i) {
    state.triangles[i] = contacts_[i].triangle;
    state.separations[i] = contacts_[i].separation;
  }
  state.contact_count = contact_count_;
  state.multipliers = multipliers_;
  state.active_count = active_count_;
}

void ProxyMethod::restore(const State& state) noexcept {
  proxy_ = state.proxy;
  free_ = state.free;
  sliding_ = state.sliding;
  for (int i = 0; i < state.contact_count; ++i) {
    contacts_[i] = {.triangle = state.triangles[i], .shape = shape_of(state.triangles[i]), .separation = state.separations[i]};
  }
  contact_count_ = state.contact_count;
  multipliers_ = state.multipliers;
  active_count_ = state.active_count;
}

// Limits a motion to the length that crosses the scene.
Vec3 ProxyMethod::shortened(const Vec3& motion) noexcept {
  const double length = motion.norm();
  return length > kLongestMotion ? Vec3(motion * (kLongestMotion / length)) : motion;
}

void ProxyMethod::solve(const Vec3& device) noexcept {
  if (walk(device)) return;
  const Vec3 from = proxy_;
  descend(device);
  if (!is_point_) prefetch_cache(proxy_ - from);
  for (int i = 0; i < kMaxEscapes && !free_ && sweeps_left_ > kEscapeSweeps && escape(device); ++i) ++counters_.escapes;
}

// Moves the proxy to the constrained minimum. Every iteration moves it nearer to the device or adds an active constraint.
void ProxyMethod::descend(const Vec3& device) noexcept {
  active_count_ = 0;                                 // until it has settled
  const double least_motion = clearance_.tolerance;  // shorter motions are below the tolerance of the clearance
  constexpr double kRounding = 0x1p-48;              // share of a distance within the scene
  constexpr double kNormalError = 0x1p-24;  // share of the goal: error of an edge's normal at the contact offset (point_triangle.h)
  double nearest = std::numeric_limits<double>::infinity();
  int idle = 0;
  int last_doubt = kMaxIterations;
  for (int i = 0; i < kMaxIterations && sweeps_left_ > 0; ++i) {
    if (contact_count_ == 0 && cross_empty_space(device)) return;
    Vec3 goal = device - proxy_;
    const double distance = goal.norm();
    const bool arrives = distance <= kLongestMotion;
    if (distance > kFarthestGoal) goal *= kFarthestGoal / distance;  // so that a distant device does not cost significant digits
    idle = distance < nearest - kRounding ? 0 : idle + 1;
    nearest = std::min(nearest, distance);
    if (idle > kMaxIdle && contact_count_ > 0) {  // moving back and forth within the slop of the clearance
      active_count_ = 1;
      multipliers_[0] = distance;
      return;
    }
    if (contact_count_ == 0) {
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
    const Vec3 motion = has_friction_ ? apply_friction(goal, constrained) : constrained.motion;
    if (motion.norm() <= least_motion + kNormalError * distance) {
      if (i < last_doubt && forget_doubtful(constrained)) {
        last_doubt = 0;
        continue;
      }
      bring_active_first(constrained);
      return;
    }
    if (!advance(shortened(motion)) && constrained.active_count == 0 && arrives) {
      settle_at(device);
      return;
    }
  }
  ++counters_.unconverged;
}

// Far outside the scene there are no contacts and positions are coarse: the proxy goes straight to the device (true), or to where its path
// enters the scene's surroundings.
bool ProxyMethod::cross_empty_space(const Vec3& device) noexcept {
  const double surroundings = 2.0 + 2.0 * clearance_.offset;
  if (proxy_.norm() <= 1.01 * surroundings) return false;
  const Vec3 path = device - proxy_;
  const double length = path.norm();
  const Vec3 direction = length > 0.0 ? Vec3(path / length) : Vec3::Zero();
  const double closest_at = -proxy_.dot(direction);
  const double miss = (proxy_ + closest_at * direction).norm();
  const double entry = closest_at - std::sqrt(std::max(0.0, (surroundings - miss) * (surroundings + miss)));
  if (miss >= surroundings || entry <= 0.0 || entry >= length) {
    settle_at(device);
    return true;
  }
  proxy_ += entry * direction;
  return false;
}

// An edge or vertex contact of a point probe may exist by rounding only: drops such contacts, so that the next sweep shows whether they
// block. Returns false if there are none.
bool ProxyMethod::forget_doubtful(const ConstrainedMotion& held) noexcept {
  if (!is_point_) return false;
  bool any = false;
  for (int i = 0; i < held.active_count; ++i) any |= contacts_[held.active[i]].separation.feature != Feature::face;
  if (!any) return false;
  const auto end = std::remove_if(contacts_.begin(), contacts_.begin() + contact_count_,
                                  [](const Contact& contact) { return contact.separation.feature != Feature::face; });
  contact_count_ = static_cast<int>(end - contacts_.begin());
  return true;
}

ConstrainedMotion ProxyMethod::next_motion(const Vec3& goal) noexcept {
  for (int i = 0; i < contact_count_; ++i) {
    const Separation& s = contacts_[i].separation;
    planes_[i] = {s.normal, clearance_.offset - s.distance};
  }
  return constrain_motion(goal, std::span<const ContactPlane>(planes_.data(), static_cast<std::size_t>(contact_count_)));
}

// Coulomb friction: the frictionless goal is `depth` above the device; the proxy may stay up to mu * depth short of the goal.
Vec3 ProxyMethod::apply_friction(const Vec3& goal, const ConstrainedMotion& constrained) noexcept {
  const Vec3& motion = constrained.motion;
  const Material material = material_of(constrained);
  const double depth = (goal - motion).norm();
  const double length = motion.norm();
  const double hold = (sliding_ ? material.friction_dynamic : material.friction_static) * depth;
  if (length <= hold + clearance_.slop) {
    if (length < 0.5 * material.friction_dynamic * depth) sliding_ = false;
    return Vec3::Zero();
  }
  sliding_ = true;
  return motion * (1.0 - material.friction_dynamic * depth / length);
}

// Radius of an empty ball round the device, for the probe. The search is limited to 64 displacements and is repeated only after a part of
// the radius has been travelled. Triangles hardly nearer than the nearest so far are skipped: over a smooth surface there are thousands,
// for a ball hardly larger.
double ProxyMethod::find_empty_ball(const Vec3& device, double may_go) noexcept {
  constexpr double kHardlyNearer = 0.75 * 0.75;  // of squared distances
  const double widest = 64.0 * displacement_ + 4.0 * clearance_.offset;
  double clear_squared = widest * widest;
  geometry_.visit_nearest(device, clear_squared, [&](std::uint32_t triangle, double bound) {
    const double d = geometry_.separation(triangle, device).distance;
    clear_squared = std::min(bound, kHardlyNearer * d * d);
    return clear_squared;
  });
  // Reduced by the rounding of the conversion to local units.
  const double radius = std::min(std::sqrt(clear_squared) * (1.0 - 0x1p-40) - clearance_.offset, may_go) - 0x1p-48 * (1.0 + device.norm());
  empty_retry_ = std::max(0.25 * radius, 4.0 * displacement_);
  return std::max(radius, 0.0);
}

// From now on a step within the ball is one comparison, in the sample's own frame.
void ProxyMethod::enter_ball(const Vec3& p_SD, double radius) noexcept {
  const double radius_m = radius * geometry_.unit_m();
  empty_centre_S_ = p_SD;
  last_free_S_ = p_SD;
  empty_radius_squared_m2_ = std::min(radius_m * radius_m, std::numeric_limits<double>::max());
}

// Restores the proxy to the last sample in the ball and forgets the ball, because the probe may come back through a face.
void ProxyMethod::leave_ball() noexcept {
  if (empty_radius_squared_m2_ == 0.0) return;
  empty_radius_squared_m2_ = 0.0;
  proxy_ = within_limits(geometry_.to_local(last_free_S_));
  last_device_ = proxy_;
  empty_retry_ -= (proxy_ - geometry_.to_local(empty_centre_S_)).norm();
}

bool ProxyMethod::prepare() { return geometry_.build_wanted(); }

}  // namespace hapton
