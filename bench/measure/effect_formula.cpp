#include "bench/measure/effect_formula.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <variant>

#include "core/force/touch_scene.h"

namespace hapton {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

Vec3 along_plane(const Vec3& v) { return {v.x(), v.y(), 0.0}; }

Vec3 at_most(const Vec3& v, double length) { return v.norm() > length ? Vec3(v.normalized() * length) : v; }

// A height, or another number that changes from place to place, and its gradient along the plane.
struct ValueOnPlane {
  double value = 0.0;
  Vec3 gradient = Vec3::Zero();
};

ValueOnPlane height_of(const SurfaceBumps& bumps, const Vec3& p) {
  if (!(bumps.height_m > 0.0)) return {};
  const double k = kTurn / bumps.length_m;
  const double half = 0.5 * bumps.height_m;
  if (bumps.pattern == SurfaceBumps::Pattern::ridges) {
    const double x = bumps.direction.dot(p);
    return {half * (std::cos(k * x) - 1.0), along_plane(-half * k * std::sin(k * x) * bumps.direction)};
  }
  return {half * ((std::cos(k * p.x()) + std::cos(k * p.y()) + 1.0) / 3.0 - 1.0),
          -half * k / 3.0 * Vec3(std::sin(k * p.x()), std::sin(k * p.y()), 0.0)};
}

// The value that an image gives at p, with the gradient of brightness_at(); `where_off` if there is no image.
ValueOnPlane value_of(const ImageMap& map, const Vec3& p, double where_off) {
  if (!map.is_on()) return {where_off, Vec3::Zero()};
  const double range = map.at_white - map.at_black;
  const double u = kImagesPerM * p.x();
  const double v = kImagesPerM * p.y();
  const double k = kTurn * kWavesPerImage;
  return {map.at_black + range * brightness_at(u, v), range * 0.25 * k * kImagesPerM * Vec3(std::cos(k * u), std::cos(k * v), 0.0)};
}

double damped_sine(double time_s, double frequency_hz, double decay_s) {
  return std::exp(-time_s / decay_s) * std::sin(kTurn * frequency_hz * time_s);
}

double wave(Waveform form, double cycles) {
  const double phase = std::fmod(cycles, 1.0);
  switch (form) {
    case Waveform::sine:
      return std::sin(kTurn * phase);
    case Waveform::square:
      return phase < 0.5 ? 1.0 : -1.0;
    case Waveform::triangle:
      return std::asin(std::sin(kTurn * phase)) / (0.25 * kTurn);
    case Waveform::sawtooth:
      return 2.0 * phase - 1.0;
  }
  return 0.0;
}

Vec3 from_target(const SnapEffect& snap, const Vec3& p) {
  const Vec3 q = p - snap.position;
  switch (snap.target) {
    case SnapEffect::Target::line:
      return q - q.dot(snap.direction) * snap.direction;
    case SnapEffect::Target::plane:
      return q.dot(snap.direction) * snap.direction;
    default:
      return q;
  }
}

}  // namespace

Vec3 plane_spring(const Vec3& p) { return {0.0, 0.0, Material().stiffness_n_per_m * std::max(0.0, -p.z())}; }

Vec3 EffectFormula::force_at(const FormulaMoment& moment) {
  Vec3 force_n = space_force(moment);
  if (moment.p.z() < 0.0) {
    force_n += surface_force(moment, !was_in_contact_);
    was_in_contact_ = true;
    snap_centre_ = along_plane(moment.p);
  } else {
    was_in_contact_ = false;
    force_n += snap_force(moment.p);
  }
  previous_s_ = moment.time_s;
  return force_n;
}

Vec3 EffectFormula::surface_force(const FormulaMoment& moment, bool contact_begins) {
  const SurfaceEffects& surface = effects_.surface;
  const double k = Material().stiffness_n_per_m;
  const double depth_m = -moment.p.z();
  if (contact_begins) {
    punctured_count_ = 0;
    layer_top_m_ = 0.0;
    tap_ = {moment.time_s, std::clamp(-moment.v.z() * surface.tap.ns_per_m, 0.0, surface.tap.max_force_n)};
  }
  const ValueOnPlane bumps =
      surface.maps.height.is_on() ? value_of(surface.maps.height, moment.p, 0.0) : height_of(surface.bumps, moment.p);
  const ValueOnPlane stiffness_share = value_of(surface.maps.stiffness, moment.p, 1.0);
  const double pressed_m = std::max(0.0, depth_m + bumps.value);
  double normal_n = stiffness_share.value * k * pressed_m + surface.progressive.n_per_m2 * pressed_m * pressed_m;
  if (surface.layers.is_on()) normal_n = layers_n(depth_m, -moment.v.z());

  // Minus the gradient of the potential 1/2 stiffness_share k pressed_m^2, and the other forces along the normal of the bumps.
  Vec3 force_n = normal_n * (Vec3::UnitZ() - bumps.gradient) - 0.5 * k * pressed_m * pressed_m * stiffness_share.gradient;
  const double bound_n = std::abs(normal_n);
  force_n += friction(moment.p, value_of(surface.maps.friction, moment.p, 0.0).value, bound_n, contact_begins);
  const Vec3 along = along_plane(moment.v);
  force_n += at_most(-surface.viscosity.damping_ns_per_m * along, bound_n);
  force_n += at_most(-value_of(surface.maps.viscosity, moment.p, 0.0).value * along, bound_n);
  force_n.z() += tap_.amplitude_n * damped_sine(moment.time_s - tap_.began_s, surface.tap.frequency_hz, surface.tap.decay_s);
  return force_n;
}

double EffectFormula::layers_n(double depth_m, double inward_m_per_s) {
  const TissueLayers& layers = effects_.surface.layers;
  const auto resistance = [&] {
    return punctured_count_ < layers.count() ? layers[punctured_count_].stiffness_n_per_m * std::max(0.0, depth_m - layer_top_m_) : 0.0;
  };
  while (punctured_count_ < layers.count() && resistance() > layers[punctured_count_].pop_force_n) {
    ++punctured_count_;
    if (punctured_count_ < layers.count()) layer_top_m_ = std::max(depth_m, layers[punctured_count_].depth_m);
  }
  return resistance() + (punctured_count_ > 0 ? layers[punctured_count_ - 1].drag_ns_per_m * inward_m_per_s : 0.0);
}

// The force of a spring to a point of the plane. At the limit of the friction cone the hand drags this point along.
Vec3 EffectFormula::friction(const Vec3& p, double coefficient, double normal_n, bool contact_begins) {
  const Vec3 here = along_plane(p);
  if (contact_begins) friction_anchor_ = here;
  const double k = Material().stiffness_n_per_m;
  friction_anchor_ = here - at_most(here - friction_anchor_, coefficient * normal_n / k);
  return -k * (here - friction_anchor_);
}

Vec3 EffectFormula::snap_force(const Vec3& p) {
  const SurfaceSnap& snap = effects_.surface.snap;
  if (!snap_centre_) return Vec3::Zero();
  // The snap ends above its range, and four ranges away along the plane (docs/effects.md).
  const bool is_far = p.z() > snap.range_m || (along_plane(p) - *snap_centre_).norm() > 4.0 * snap.range_m;
  if (is_far) snap_centre_.reset();
  return is_far ? Vec3(Vec3::Zero()) : Vec3(0.0, 0.0, -snap.stiffness_n_per_m * p.z());
}

Vec3 EffectFormula::space_force(const FormulaMoment& moment) {
  const double dt_s = previous_s_ ? moment.time_s - *previous_s_ : 0.0;
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < space_.size(); ++i) {
    SpaceState& state = space_[i];
    const SpaceEffect& effect = effects_.space[i].effect;
    if (const auto* spring = std::get_if<SpringEffect>(&effect)) {
      sum += at_most(spring->stiffness_n_per_m * (spring->centre - moment.p), spring->max_force_n);
    } else if (const auto* constant = std::get_if<ConstantEffect>(&effect)) {
      sum += constant->force_n;
    } else if (const auto* snap = std::get_if<SnapEffect>(&effect)) {
      const Vec3 q = from_target(*snap, moment.p);
      const double u = std::min(1.0, q.norm() / snap->range_m);
      sum -= snap->max_force_n * 4.0 * u * (1.0 - u) * q.normalized();
    } else if (const auto* well = std::get_if<GravityWellEffect>(&effect)) {
      const Vec3 q = moment.p - well->centre;
      const double x = q.norm() / (std::numbers::sqrt2 * well->radius_m);
      sum -= well->max_force_n * 1.5 * std::numbers::sqrt3 * x / std::pow(1.0 + x * x, 1.5) * q.normalized();
    } else if (const auto* viscous = std::get_if<ViscousEffect>(&effect)) {
      sum += at_most(-viscous->damping_ns_per_m * moment.v, viscous->max_force_n);
    } else if (const auto* waves = std::get_if<WaveEffect>(&effect)) {
      sum += waves->amplitude_n * wave(waves->waveform, waves->frequency_hz * moment.time_s) * waves->direction;
    } else if (const auto* mass = std::get_if<MassEffect>(&effect)) {
      state.mass_v += (1.0 - std::exp(-dt_s / mass->filter_s)) * (moment.v - state.mass_v);
      sum += at_most(-mass->mass_kg / mass->filter_s * (moment.v - state.mass_v), mass->max_force_n);
    } else if (const auto* burst = std::get_if<BurstEffect>(&effect)) {
      const bool is_inside = burst->volume.contains(moment.p);
      if (is_inside && !state.was_inside) state.burst_began_s = moment.time_s;
      state.was_inside = is_inside;
      if (!state.burst_began_s) continue;
      const double burst_s = moment.time_s - *state.burst_began_s;
      if (burst_s >= burst->duration_s) continue;
      sum += burst->amplitude_n * damped_sine(burst_s, burst->frequency_hz, burst->decay_s) * burst->direction;
    }
  }
  return sum;
}

}  // namespace hapton
