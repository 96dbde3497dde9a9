#pragma once

#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "core/force/force_method.h"
#include "core/force/proxy/proxy_method.h"

namespace hapton {

// The method `proxy` on one surface whose shape may change in each step.
//
// Before each step the surface takes its shape at that time and carries the probe along: a probe that it holds, or that it may have passed,
// moves to the same place of the deformed surface, on the same side (ProxyMethod::Anchor), and the device point of the last sample moves by
// the same vector. From there the proxy follows the device as usual. So a surface that moves into the hand pushes the proxy ahead, friction
// and damping are relative to the surface, and the proxy never passes it, however far the surface moved since the last step.
//
// While hand and surface cannot have met since the last search for the nearest surface, a step is a few comparisons.
//
// Surface, the template argument, writes its shape at a time into the geometry that the proxy follows:
//   double travel_to(double time_s) const   m: at that time no vertex is farther than this from its position in the geometry
//   bool is_due(double time_s) const        shape() must be called for that time even if no vertex moves
//   void shape(double time_s)               gives the geometry the shape at that time
//   void skip_to(double time_s)             that time is reached, and the geometry keeps its shape
//   Vec3 rest_of(vertex) const, Vec3 displacement_between(vertex, from_s, to_s) const   as DeformingGeometry
// All noexcept, RT: yes. Times of the first four do not decrease, except: shape() for the last step's time may follow skip_to() for it.
//
// Frame: S. RT: all but construction. Threads: one.
template <class Surface>
class CarriedProxy {
 public:
  // Pre: the method is a ProxyMethod of one object that deforms.
  template <class... Arguments>
  explicit CarriedProxy(std::unique_ptr<ForceMethod> method, Arguments&&... of_surface)
      : method_(std::move(method)),
        proxy_(static_cast<ProxyMethod&>(*method_)),
        surface_(proxy_.deforming_geometry(), std::forward<Arguments>(of_surface)...) {}

  MethodOutput step(const MethodInput& input) noexcept {
    if (!input.p_SD.allFinite() || !std::isfinite(input.time_s)) return {.force_n = Vec3::Zero(), .p_SP = input.p_SD};
    if (!has_begun_ || pending_start_) begin(input);
    if (!input.is_correction) {
      time_before_last_s_ = last_time_s_;
      p_SD_before_last_ = last_p_SD_;
    }
    double reach_m = surface_.travel_to(input.time_s);
    MethodOutput output{.force_n = Vec3::Zero(), .p_SP = input.p_SD};
    if ((input.p_SD - clear_centre_).norm() + reach_m < clear_radius_m_) {
      surface_.skip_to(input.time_s);
      last_p_SD_ = input.p_SD;
      last_time_s_ = input.time_s;
      return output;
    }
    if (clear_radius_m_ > 0.0) {
      resume_at_last_step();
      if (input.is_correction) proxy_.note_sample_before(p_SD_before_last_);
      reach_m = surface_.travel_to(input.time_s);
    }
    if (reach_m > 0.0 || surface_.is_due(input.time_s)) deform(input.time_s, reach_m);
    output = method_->step({.p_SD = input.p_SD, .dt_s = input.dt_s, .is_correction = input.is_correction});
    if (!output.contact) search_around(input.p_SD, (input.p_SD - last_p_SD_).norm() + reach_m);
    last_p_SD_ = input.p_SD;
    last_time_s_ = input.time_s;
    return output;
  }

  void reset(const Vec3& p_SD) noexcept {
    pending_start_ = p_SD;
    resumes_ = false;
  }
  // As ForceMethod::resume: the surface has the shape that it has at the time of the next step.
  void resume(const Vec3& p_SP) noexcept {
    pending_start_ = p_SP;
    resumes_ = true;
  }

  // As ForceMethod::held_at.
  std::optional<Vec3> held_at() const noexcept { return pending_start_ || clear_radius_m_ > 0.0 ? std::nullopt : proxy_.held_at(); }

  // As ForceMethod::find_place.
  std::optional<SurfacePlace> find_place() const noexcept {
    const auto held = proxy_.find_held_place();
    if (!held) return std::nullopt;
    const TouchGeometry& geometry = proxy_.geometry();
    const Triangle& vertices = geometry.object_geometry(0).triangle(geometry.triangle_of(held->triangle));
    Mat3 rest;
    Mat3 now;
    Mat3 moved;
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t vertex = vertices[static_cast<std::size_t>(k)];
      rest.col(k) = surface_.rest_of(vertex);
      now.col(k) = geometry.corner(held->triangle, k);
      moved.col(k) = surface_.displacement_between(vertex, time_before_last_s_, last_time_s_);
    }
    return SurfacePlace{.p_rest = geometry.to_scene(rest * held->weights),
                        .moved = geometry.unit_m() * (moved * held->weights),
                        .gradient = gradient_of_deformed(rest, now)};
  }

  ForceMethod& method() noexcept { return *method_; }
  const ForceMethod& method() const noexcept { return *method_; }
  Surface& surface() noexcept { return surface_; }
  const Surface& surface() const noexcept { return surface_; }
  double last_time_s() const noexcept { return last_time_s_; }

 private:
  static constexpr double kSearchSteps = 64.0;  // a search reaches as far as this many steps like the last one

  // Goes back to the last step, in which hand and surface had not met.
  void resume_at_last_step() noexcept {
    clear_radius_m_ = 0.0;
    travel_until_search_m_ = 0.0;
    surface_.shape(last_time_s_);
    method_->resume(last_p_SD_);
  }

  void begin(const MethodInput& input) noexcept {
    surface_.shape(input.time_s);
    last_p_SD_ = pending_start_.value_or(input.p_SD);
    resumes_ ? method_->resume(last_p_SD_) : method_->reset(last_p_SD_);
    last_time_s_ = input.time_s;
    pending_start_.reset();
    resumes_ = false;
    has_begun_ = true;
    clear_radius_m_ = 0.0;
    travel_until_search_m_ = 0.0;
  }

  void deform(double time_s, double reach_m) noexcept {
    const ProxyMethod::Anchor anchor = proxy_.anchor(reach_m);
    surface_.shape(time_s);
    proxy_.move_with_surface(anchor);
  }

  // Pre: the probe is free, at the device.
  void search_around(const Vec3& p_SD, double moved_m) noexcept {
    travel_until_search_m_ -= moved_m;
    if (travel_until_search_m_ > 0.0) return;
    const double reach_m = kSearchSteps * moved_m;
    const double unit_m = proxy_.geometry().unit_m();
    // Less the rounding of the conversion to local units.
    const double clear_radius_m = proxy_.anchor(reach_m).distance * unit_m * (1.0 - 0x1p-40) - 0x1p-48 * (unit_m + p_SD.norm());
    travel_until_search_m_ = 0.25 * clear_radius_m;
    if (clear_radius_m < 4.0 * moved_m || !(clear_radius_m > 0.0)) return;
    clear_centre_ = p_SD;
    clear_radius_m_ = clear_radius_m;
  }

  std::unique_ptr<ForceMethod> method_;
  ProxyMethod& proxy_;  // *method_
  Surface surface_;
  std::optional<Vec3> pending_start_;  // where the next step begins after reset() or resume()
  bool resumes_ = false;               // pending_start_ comes from resume()
  bool has_begun_ = false;
  Vec3 last_p_SD_ = Vec3::Zero();
  double last_time_s_ = 0.0;
  double time_before_last_s_ = 0.0;       // time of the sample before the last
  Vec3 p_SD_before_last_ = Vec3::Zero();  // device point of that sample
  Vec3 clear_centre_ = Vec3::Zero();
  double clear_radius_m_ = 0.0;         // radius around clear_centre_ without any surface; 0: not known
  double travel_until_search_m_ = 0.0;  // distances of hand and surface that may add up before the next search
};

}  // namespace hapton
