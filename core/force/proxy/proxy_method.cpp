#include "core/force/proxy/proxy_method.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace hapton {

namespace {

constexpr double kMinRadius = 0x1p-20;  // local units: digits are too few to tell the corners that a smaller probe closes
// Local units. The centre of a larger sphere can be as far from the scene as its radius, where it has too few digits for the contact
// offset. So has a device that is farther away (SweptMotion).
constexpr double kLargestRadius = 0x1p10;

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

BuildPolicy policy_of(const MethodSettings& settings, const TouchScene& scene) {
  if (scene.objects.front().deformation != nullptr) return BuildPolicy::to_deform;
  return settings.build_on_approach ? BuildPolicy::on_approach : BuildPolicy::at_once;
}

// Clamps a device farther out than a billion scene sizes to that distance, so that its squares stay finite.
Vec3 within_limits(const Vec3& local) {
  constexpr double kFarthest = 0x1p30;  // local units
  constexpr double kHuge = 1e200;       // replaces a coordinate that overflowed in the conversion
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
  if (auto fits = TouchGeometry::check(meshes_of(scene), scene.part_of); !fits) return fail("proxy: {}", fits.error().what);
  std::unique_ptr<ProxyMethod> method(new ProxyMethod(settings, scene));
  const double largest_m = kLargestRadius * method->geometry_.unit_m();
  if (!(settings.probe_radius_m >= 0.0 && settings.probe_radius_m <= largest_m)) {
    return fail("proxy: a probe radius of {:g} m; give 0 to {:g} m, about a thousand times the size of what is touched",
                settings.probe_radius_m, largest_m);
  }
  return std::unique_ptr<ForceMethod>(std::move(method));
}

ProxyMethod::ProxyMethod(const MethodSettings& settings, const TouchScene& scene)
    : geometry_(make_geometry(settings, scene)),
      materials_(materials_of(scene)),
      surfaces_(geometry_, materials_),
      clearance_(clearance_of(settings, geometry_.unit_m())),
      shading_(settings.shading),
      is_point_(settings.probe_radius_m == 0.0),
      surface_(geometry_, materials_),
      // The sphere that stands for a point is as large as in the reference, so the proxy fits wherever the reference does.
      sphere_(geometry_, materials_, is_point_ ? 0.5 * kContactOffset : clearance_.offset, clearance_.offset < kMinRadius),
      flight_(surfaces_, clearance_),
      swept_(surfaces_, clearance_, is_point_) {}

std::optional<double> ProxyMethod::shading_crease_rad(const MethodSettings& settings) {
  return settings.shading > 0.0 ? std::optional(settings.crease_deg * std::numbers::pi / 180.0) : std::nullopt;
}

TouchGeometry ProxyMethod::make_geometry(const MethodSettings& settings, const TouchScene& scene) {
  const std::optional<double> crease_rad = shading_crease_rad(settings);
  auto meshes = meshes_of(scene);
  if (scene.built != nullptr && scene.part_of.is_empty() && scene.built->are_built_from(meshes, crease_rad))
    return TouchGeometry(*scene.built);
  return TouchGeometry(std::move(meshes), policy_of(settings, scene), crease_rad, scene.part_of);
}

Clearance ProxyMethod::clearance_of(const MethodSettings& settings, double unit_m) {
  return {.offset = settings.probe_radius_m / unit_m + kContactOffset, .slop = 0.5 * kContactOffset, .tolerance = 0x1p-10 * kContactOffset};
}

void ProxyMethod::reset(const Vec3& p_SD) noexcept {
  resume(p_SD);
  if (!is_point_ || !has_sample_) return;
  proxy_.position = flight_.off_surface(proxy_.position, kContactOffset);
  last_device_ = proxy_.position;
}

std::optional<Vec3> ProxyMethod::held_at() const noexcept {
  if (proxy_.is_free || ball_.exists()) return std::nullopt;
  return geometry_.to_scene(proxy_.position);
}

std::optional<Vec3> ProxyMethod::carried_from() const noexcept {
  if (!carried_from_) return std::nullopt;
  return geometry_.to_scene(*carried_from_);
}

void ProxyMethod::resume(const Vec3& p_SP) noexcept {
  surface_.leave();
  sphere_.forget();
  swept_.forget();
  leave_ball();
  ball_.reset();
  carried_from_.reset();
  is_unconverged_ = false;
  is_at_sphere_offset_ = false;
  touched_object_ = -1;
  has_sample_ = p_SP.allFinite();
  proxy_.settle_at(within_limits(geometry_.to_local(p_SP)));
  geometry_.place_probe(proxy_.position);
  // A sphere whose centre is on an edge or a vertex has no direction that leads away from the surface.
  if (!is_point_ && has_sample_) proxy_.position = flight_.off_surface(proxy_.position, kContactOffset);
  last_device_ = proxy_.position;
}

// If friction has changed, the proxy settles again at the beginning of the next step: what held the proxy may hold it no longer.
void ProxyMethod::set_materials(std::span<const Material> materials) noexcept {
  bool has_friction_changed = false;
  for (std::size_t i = 0; i < std::min(materials.size(), materials_.size()); ++i) {
    has_friction_changed |= materials[i].friction_static != materials_[i].friction_static;
    has_friction_changed |= materials[i].friction_dynamic != materials_[i].friction_dynamic;
    materials_[i] = materials[i];
  }
  if (!has_friction_changed) return;
  surfaces_.note_friction();
  sphere_.note_friction();
  if (!surface_.is_on_surface()) return;
  surface_.note_friction();
  is_unconverged_ = true;
}

// Within a known empty ball the proxy is free and the step is this one comparison, which fails for samples that are not finite.
MethodOutput ProxyMethod::step(const MethodInput& input) noexcept {
  if (!ball_.contains(input.p_SD)) return step_outside(input);
  ++counters_.steps;
  ++counters_.skipped;
  ball_.note_sample(input.p_SD, input.is_correction);
  return {.force_n = Vec3::Zero(), .p_SP = input.p_SD, .contact = false};
}

MethodOutput ProxyMethod::step_outside(const MethodInput& input) noexcept {
  leave_ball();
  if (!input.p_SD.allFinite()) return {.force_n = Vec3::Zero(), .p_SP = geometry_.to_scene(proxy_.position), .contact = false};
  ++counters_.steps;
  const Vec3 device = within_limits(geometry_.to_local(input.p_SD));
  if (!has_sample_) reset(input.p_SD);
  const Vec3 last = std::exchange(last_device_, device);
  const Vec3 from = begin_motion(input, last);
  const double empty_radius = find_empty_radius(device, (device - last).norm());
  if ((device - proxy_.position).norm() < empty_radius) {
    proxy_.settle_at(device);
    ball_.enter(geometry_, input.p_SD, geometry_.to_scene(sample_before_), empty_radius);
  } else {
    const std::uint64_t events = surface_.events();
    follow(from, device);
    counters_.most_events = std::max(counters_.most_events, surface_.events() - events);
    counters_.most_work = std::max(counters_.most_work, StepWork::kMax - work_left_);
  }
  if (!proxy_.is_free) return render_contact(input, device);
  touched_object_ = -1;
  return {.force_n = Vec3::Zero(), .p_SP = input.p_SD, .contact = false};
}

Vec3 ProxyMethod::begin_motion(const MethodInput& input, const Vec3& last) noexcept {
  if (!input.is_correction) sample_before_ = last;
  if (!carried_from_) tries_.forget();
  work_left_ = StepWork::kMax;
  return std::exchange(carried_from_, std::nullopt).value_or(last);
}

void ProxyMethod::note_sample_before(const Vec3& p_SD) noexcept { sample_before_ = within_limits(geometry_.to_local(p_SD)); }

double ProxyMethod::find_empty_radius(const Vec3& device, double displacement) noexcept {
  const std::size_t waiting = geometry_.waiting_count();
  const double may_go = geometry_.request_ahead(proxy_.position, kLookAheadSteps * displacement);
  if (geometry_.waiting_count() != waiting) {  // what the followers have found does not contain new objects
    sphere_.forget_near();
    swept_.drop_motion();
  }
  double empty_radius = 0.0;
  if (proxy_.is_free && ball_.is_due()) {
    empty_radius = ball_.find(geometry_, device, displacement, clearance_.offset, may_go - (device - proxy_.position).norm());
    work_left_ -= ball_.work();
  }
  ball_.note_motion(displacement);
  return empty_radius;
}

MethodOutput ProxyMethod::render_contact(const MethodInput& input, const Vec3& device) noexcept {
  ++counters_.contact_steps;
  if (proxy_.contact_count > 0) touched_object_ = static_cast<int>(geometry_.mesh_of(proxy_.strongest_triangle()));
  const double speed_m_per_s = input.dt_s > 0.0 ? geometry_.unit_m() / input.dt_s : 0.0;
  // The surface is one contact offset nearer to the device than the proxy.
  const Vec3 extension = proxy_.position - device;
  const double length = extension.norm();
  const Vec3 turned = shading_ > 0.0 ? shaded(extension) : extension;
  const bool is_contact = length > active_offset_;
  const Vec3 extension_m = is_contact ? Vec3(turned * ((length - active_offset_) / length * geometry_.unit_m())) : Vec3::Zero();
  return {.force_n = force_of(extension_m, (device - sample_before_) * speed_m_per_s),
          .p_SP = geometry_.to_scene(proxy_.position),
          .contact = is_contact,
          .object = is_contact ? touched_object_ : -1};
}

// The spring extension is the sum of multiplier * normal over the active constraints; the same sum over smooth normals gives the shaded
// direction.
Vec3 ProxyMethod::shaded(const Vec3& extension) noexcept {
  Vec3 smooth = Vec3::Zero();
  const auto active = proxy_.active();
  for (std::size_t i = 0; i < active.size(); ++i) {
    const Separation& s = active[i].separation;
    Vec3 normal = geometry_.smooth_normal(active[i].triangle, s.nearest);
    if (normal.dot(s.normal) < 0.0) normal = -normal;  // two-sided
    smooth += proxy_.multipliers[i] * normal;
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

// A proxy that ran out of work on its way to the next contact has no contact. The material is still that of the object that it touched
// last; without such an object, it is the softest material.
Material ProxyMethod::felt_material() const noexcept {
  if (proxy_.contact_count > 0) return surfaces_.mean_material(proxy_);
  if (touched_object_ >= 0) return materials_[static_cast<std::size_t>(touched_object_)];
  return *std::ranges::min_element(materials_, {}, &Material::stiffness_n_per_m);
}

// Hooke's law, less damping along the extension; damping never makes the force attractive.
Vec3 ProxyMethod::force_of(const Vec3& extension_m, const Vec3& velocity_m_per_s) const noexcept {
  const Material material = felt_material();
  const Vec3 spring = material.stiffness_n_per_m * extension_m;
  const double length = extension_m.norm();
  if (material.damping_ns_per_m == 0.0 || length == 0.0) return spring;
  const Vec3 direction = extension_m / length;
  const double drag = material.damping_ns_per_m * velocity_m_per_s.dot(direction);
  return std::max(0.0, spring.norm() - drag) * direction;
}

// Puts the proxy at the last sample in the ball and goes on from there, because the probe may come back through a face.
void ProxyMethod::leave_ball() noexcept {
  if (!ball_.exists()) return;
  proxy_.position = within_limits(geometry_.to_local(ball_.last_sample()));
  last_device_ = proxy_.position;
  note_sample_before(ball_.sample_before());
  ball_.leave(geometry_);
}

bool ProxyMethod::prepare() { return geometry_.build_requested(); }

}  // namespace hapton
