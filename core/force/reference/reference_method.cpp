#include "core/force/reference/reference_method.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hapton {
namespace {

constexpr double kFarthest = 1e12;         // local units: a device farther out is clamped to this, so that its square stays finite
constexpr int kMaxSubsteps = 1 << 20;      // a free choice
constexpr double kLargestRadius = 1024.0;  // in diagonals of the box; the centre of a larger sphere is so far away that digits are lost
constexpr double kJumpRatio = 8.0;  // times the device's motion: a longer motion of the proxy is a jump; no slide is that fast for long
constexpr double kMinHalvedSubstep = 0x1p-38;  // local units: shorter sub-steps are not halved; a thousand times the tolerance of a contact
constexpr std::size_t kLevels = 48;            // levels of halving: down to kMinHalvedSubstep for motions up to 2^9
constexpr int kMaxHalvings = 1024;             // most halvings in one pass over a step
constexpr std::size_t kMaxPrepared = std::size_t{1} << 17;  // 40 MB; triangles of larger scenes are prepared when they are gathered

// The box around those vertices that triangles use.
Box bounds_of(const TouchScene& scene) {
  Box box;
  for (const TouchObject& object : scene.objects) {
    for (const Triangle& triangle : object.mesh->triangles) {
      for (const std::uint32_t index : triangle) box.grow(object.mesh->vertices[index]);
    }
  }
  return box;
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
  if (settings.reference_substeps < 1 || settings.reference_substeps > kMaxSubsteps) {
    return fail("method reference: {} sub-steps a step; give 1 to {}", settings.reference_substeps, kMaxSubsteps);
  }
  if (settings.reference_substep_limit < settings.reference_substeps || settings.reference_substep_limit > kMaxSubsteps) {
    return fail("method reference: at most {} sub-steps a step; give the first count, {}, to {}", settings.reference_substep_limit,
                settings.reference_substeps, kMaxSubsteps);
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
  const double diagonal_m = bounds_of(scene).diagonal();
  if (diagonal_m > 0.0 && settings.probe_radius_m > kLargestRadius * diagonal_m) {
    return fail("method reference: a probe radius of {:g} m; give 0 to {:g} m, about a thousand times the size of what is touched",
                settings.probe_radius_m, kLargestRadius * diagonal_m);
  }
  return std::unique_ptr<ReferenceMethod>(new ReferenceMethod(settings, scene, prefilter));
}

ReferenceMethod::ReferenceMethod(const MethodSettings& settings, const TouchScene& scene, bool prefilter)
    : substeps_(settings.reference_substeps), substep_limit_(settings.reference_substep_limit), prefilter_(prefilter) {
  const Box box = bounds_of(scene);
  centre_ = 0.5 * box.low + 0.5 * box.high;
  const double size = std::max(box.diagonal(), settings.probe_radius_m);
  unit_m_ = size > 0.0 ? power_of_two_above(size) : 1.0;
  std::vector<Material> materials;
  for (const TouchObject& object : scene.objects) {
    const auto shift = static_cast<std::uint32_t>(vertices_.size());
    const auto number = static_cast<std::uint32_t>(materials.size());
    materials.push_back(object.material);
    for (const Vec3& vertex : object.mesh->vertices) vertices_.push_back(to_local(vertex));
    for (const auto& [a, b, c] : object.mesh->triangles) {
      triangles_.push_back({a + shift, b + shift, c + shift});
      object_of_.push_back(number);
    }
  }
  boxes_.emplace(vertices_, triangles_);
  if (triangles_.size() <= kMaxPrepared) {
    prepared_.reserve(triangles_.size());
    for (std::uint32_t i = 0; i < triangles_.size(); ++i) prepared_.push_back(prepare_triangle(i));
  }
  proxy_ = std::make_unique<ReferenceProxy>(settings.probe_radius_m / unit_m_, std::move(materials), triangles_.size());
  start_state_ = proxy_->make_state();
  for (std::size_t i = 0; i < kLevels; ++i) level_states_.push_back(proxy_->make_state());
}

// A distant device keeps its direction; its distance is clamped before anything can overflow.
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

// Gathers the triangles whose boxes are within `bound` of the device point; all triangles without the prefilter.
void ReferenceMethod::gather(const Vec3& device, double bound) noexcept {
  proxy_->clear_faces();
  const auto add = [&](std::uint32_t triangle) {
    proxy_->add_face({prepared_.empty() ? prepare_triangle(triangle) : prepared_[triangle], triangle, object_of_[triangle]});
  };
  if (prefilter_) {
    for (const std::uint32_t triangle : boxes_->find_near(device, bound)) add(triangle);
  } else {
    for (std::uint32_t triangle = 0; triangle < triangles_.size(); ++triangle) add(triangle);
  }
  counters_.candidates += proxy_->faces();
}

MethodOutput ReferenceMethod::step(const MethodInput& input) noexcept {
  if (!input.p_SD.allFinite()) {
    return {.force_n = Vec3::Zero(), .p_SP = has_sample_ ? to_scene(proxy_->state().position) : Vec3(Vec3::Zero()), .contact = false};
  }
  if (!has_sample_) reset(input.p_SD);
  ++counters_.steps;
  const Vec3 from = device_;
  const Vec3 to = device_to_local(input.p_SD);
  const Vec3 path = to - from;
  if (!input.is_correction) sample_before_ = from;
  gather(to, (proxy_->state().position - from).norm() + path.norm() + 4.0 * proxy_->rest_offset());
  last_step_ = {};
  if (proxy_->faces() == 0 && proxy_->state().free) {
    proxy_->place_free(to);
  } else {
    follow_to_the_limit(from, to);
  }
  device_ = to;
  counters_.unsettled_steps += last_step_.settled ? 0 : 1;
  if (last_step_.settled) counters_.most_substeps = std::max<std::uint64_t>(counters_.most_substeps, last_step_.substeps);
  counters_.proxy = proxy_->counters();
  const Vec3 velocity =
      input.dt_s > 0.0 && std::isfinite(input.dt_s) ? Vec3((to - sample_before_) * (unit_m_ / input.dt_s)) : Vec3(Vec3::Zero());
  MethodOutput output = compute_output(input.p_SD, proxy_->surface_position(to), velocity);
  if (output.contact) output.p_SP = to_scene(proxy_->state().position);
  return output;
}

void ReferenceMethod::follow(const Vec3& from, const Vec3& to, int substeps) noexcept {
  halvings_left_ = kMaxHalvings;
  Vec3 last = from;
  for (int i = 1; i <= substeps; ++i) {
    const Vec3 next = i == substeps ? to : Vec3(from + (double(i) / substeps) * (to - from));
    follow_substep(last, next, 0);
    last = next;
  }
}

// Where a proxy under friction jumps, the result depends on where the device is at that moment, so the sub-step is halved until the moment
// is known. Sub-steps of equal length would find it only within their length, and twice as many would often find the same wrong moment.
void ReferenceMethod::follow_substep(const Vec3& from, const Vec3& to, std::size_t level) noexcept {
  if (!proxy_->has_memory()) return proxy_->follow(from, to, {});
  ReferenceProxy::State& before = level_states_[level];
  proxy_->save(before);
  proxy_->follow(from, to, {});
  const double length = (to - from).norm();
  const bool jumps = length > kMinHalvedSubstep && (proxy_->state().position - before.position).norm() > kJumpRatio * length;
  if (!jumps || level + 1 == level_states_.size() || halvings_left_ == 0) return;
  --halvings_left_;
  proxy_->restore(before);
  const Vec3 middle = 0.5 * (from + to);
  follow_substep(from, middle, level + 1);
  follow_substep(middle, to, level + 1);
}

void ReferenceMethod::follow_to_the_limit(const Vec3& from, const Vec3& to) noexcept {
  if (from == to) return follow(from, to, 1);  // nothing to divide
  proxy_->save(start_state_);
  last_step_.substeps = substeps_;
  follow(from, to, substeps_);
  for (last_step_.settled = false; !last_step_.settled && last_step_.substeps <= substep_limit_ / 2;) {
    const Vec3 coarse = proxy_->surface_position(to) - to;
    const double coarse_stiffness = proxy_->state().material.stiffness_n_per_m;
    const bool coarse_sliding = proxy_->state().sliding;
    proxy_->restore(start_state_);
    last_step_.substeps *= 2;
    follow(from, to, last_step_.substeps);
    const Vec3 fine = proxy_->surface_position(to) - to;
    const double length = std::max(coarse.norm(), fine.norm());
    const double change = (fine - coarse).norm();
    last_step_.change = length > 0.0 ? change / length : 0.0;
    last_step_.settled = change <= std::max(kAgreement * length, kResolution) && proxy_->state().sliding == coarse_sliding &&
                         (length == 0.0 || proxy_->state().material.stiffness_n_per_m == coarse_stiffness);
  }
}

void ReferenceMethod::reset(const Vec3& p_SD) noexcept {
  counters_ = {};
  proxy_->clear_counters();
  last_step_ = {};
  has_sample_ = p_SD.allFinite();
  if (has_sample_) device_ = device_to_local(p_SD);
  proxy_->place_free(device_);
}

MethodOutput ReferenceMethod::settle_from(const Vec3& p_SP, const Vec3& p_SD, double near_enough_m) noexcept {
  const Vec3 position = to_local(p_SP);
  device_ = device_to_local(p_SD);
  has_sample_ = true;
  gather(device_, (position - device_).norm() + 4.0 * proxy_->rest_offset());
  proxy_->place_clear(position);
  proxy_->follow(device_, device_,
                 {.friction = false, .tips_at_boundaries = false, .keeps_to_surface = false, .near_enough = near_enough_m / unit_m_});
  return compute_output(p_SD, proxy_->state().position, Vec3::Zero());
}

void ReferenceMethod::continue_from(const Vec3& p_SP, const Vec3& p_SD, bool sliding) noexcept {
  device_ = device_to_local(p_SD);
  has_sample_ = true;
  const Vec3 penetration = to_local(p_SP) - device_;
  const double length = penetration.norm();
  if (!(length > 0.0)) return proxy_->place_free(device_);
  proxy_->place_free(device_);
  gather(device_, length + 128.0 * proxy_->rest_offset());
  const Vec3 position = device_ + penetration;
  if (proxy_->place_on_surface(position, sliding)) return;
  const double lift_share = proxy_->has_room(position) ? 0.0 : 2.0 * ReferenceProxy::kPointRadius / length;
  proxy_->place_held(position + lift_share * penetration, sliding);
  proxy_->follow(device_, device_, {});
  if (!proxy_->state().free) proxy_->set_sliding(sliding);
}

MethodOutput ReferenceMethod::compute_output(const Vec3& p_SD, const Vec3& position, const Vec3& velocity_m_per_s) const noexcept {
  MethodOutput output;
  output.p_SP = position == device_ ? p_SD : to_scene(position);
  const Vec3 extension = (position - device_) * unit_m_;
  const double length = extension.norm();
  if (!(length > 0.0)) return output;
  output.contact = true;
  output.object = proxy_->state().object;
  const Material& material = proxy_->state().material;
  const double along = velocity_m_per_s.dot(extension) / length;
  const double strength = material.stiffness_n_per_m * length - material.damping_ns_per_m * along;
  if (strength > 0.0) output.force_n = extension * (strength / length);
  return output;
}

std::string ReferenceMethod::describe() const {
  const double steps = std::max<double>(1.0, static_cast<double>(counters_.steps));
  const ReferenceProxy::Counters& proxy = counters_.proxy;
  return fmt::format(
      "reference: {} triangles, no search structure; each step in {}, {}, {} ... at most {} sub-steps until the force changes by less than "
      "{:g}\n"
      "  or its place by {:.3g} m\n"
      "  {} steps, {} not settled, at most {} sub-steps in a settled step; {:.1f} triangles in reach, {:.1f} sub-steps and {:.1f} motions "
      "a "
      "step\n"
      "  at most {} motions in one sub-step; {} escapes, {} unconverged, {} infeasible\n",
      triangles_.size(), substeps_, 2 * substeps_, 4 * substeps_, substep_limit_, kAgreement, kResolution * unit_m_, counters_.steps,
      counters_.unsettled_steps, counters_.most_substeps, static_cast<double>(counters_.candidates) / steps,
      static_cast<double>(proxy.substeps) / steps, static_cast<double>(proxy.motions) / steps, proxy.most_motions, proxy.escapes,
      proxy.unconverged, proxy.infeasible);
}

}  // namespace hapton
