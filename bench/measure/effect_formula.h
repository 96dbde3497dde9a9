#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "bench/measure/effect_cases.h"
#include "core/math/types.h"

namespace hapton {

// Time, position and velocity of the device at one moment of a smooth motion. Frame S, SI units.
struct FormulaMoment {
  double time_s = 0.0;  // time since the start of the motion, at which waves have phase zero
  Vec3 p = Vec3::Zero();
  Vec3 v = Vec3::Zero();
};

// The force on a device point p by the plane z = 0, whose solid is below it, without effects: the spring of the default material, N.
Vec3 plane_spring(const Vec3& p);

// The force on the plane z = 0 with effects, N. It computes the formulas of docs/effects.md independently of core/effects: the parameters
// are those of core/effects, the code is not. Images have the brightness brightness_at(). Buttons and the volumes of effects other than a
// burst are ignored: those effects act everywhere. Not for recorded textures, nor for layers together with bumps. RT: no.
class EffectFormula {
 public:
  // effects: must outlive this object.
  explicit EffectFormula(const EffectCase& effects) : effects_(effects), space_(effects.space.size()) {}

  // The force at the next moment. Time rises from call to call. Contact, punctures, slips and entries into a volume are found at these
  // moments only, and the towed mass moves from one to the next, so the error grows with the time between them.
  Vec3 force_at(const FormulaMoment& moment);

 private:
  // State of one effect in free space.
  struct SpaceState {
    Vec3 mass_v = Vec3::Zero();  // velocity of the towed mass
    bool was_inside = true;      // the device was in the burst's volume; true at first: a device that begins inside has not entered
    std::optional<double> burst_began_s = {};  // none: no burst yet
  };
  // The vibration since the last tap on the surface.
  struct TapState {
    double began_s = 0.0;
    double amplitude_n = 0.0;
  };

  Vec3 surface_force(const FormulaMoment& moment, bool contact_begins);
  double layers_n(double depth_m, double inward_m_per_s);
  Vec3 friction(const Vec3& p, double coefficient, double normal_n, bool contact_begins);
  Vec3 snap_force(const Vec3& p);
  Vec3 space_force(const FormulaMoment& moment);

  const EffectCase& effects_;
  std::vector<SpaceState> space_;
  std::optional<double> previous_s_ = {};  // time of the previous moment
  bool was_in_contact_ = false;
  std::optional<Vec3> snap_centre_ = {};  // last point of the plane below the device in contact: the surface snap acts around it
  Vec3 friction_anchor_ = Vec3::Zero();   // the point of the plane to which the spring of friction holds the device
  TapState tap_;
  std::size_t punctured_count_ = 0;  // layers that are punctured
  double layer_top_m_ = 0.0;         // depth from which the next layer resists
};

}  // namespace hapton
