#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "bench/measure/effect_cases.h"
#include "core/math/types.h"

namespace hapton {

// Time, position and velocity of the device at one moment of a smooth motion. Frame S, SI units.
struct FormulaMoment {
  double time_s = 0.0;  // time since the touch began
  Vec3 p = Vec3::Zero();
  Vec3 v = Vec3::Zero();
};

// The force of the spring of the default material on the plane z = 0, N.
Vec3 plane_spring(const Vec3& p);

// The force on the plane z = 0 with effects, N, by the formulas of docs/effects.md: a twin of core/effects that shares its parameters, not
// its code. Images show brightness_at. States (contact, punctures, slip, a towed mass) carry over from moment to moment, so moments must be
// close. Only a burst's volume counts; other effects act everywhere. Not for recorded textures, nor layers with bumps. RT: no.
class EffectFormula {
 public:
  // effects: must outlive this object.
  explicit EffectFormula(const EffectCase& effects) : effects_(effects), space_(effects.space.size()) {}

  Vec3 force_at(const FormulaMoment& moment);

 private:
  struct SpaceState {
    Vec3 mass_v = Vec3::Zero();
    bool was_inside = true;
    std::optional<double> rings_since_s = {};
  };
  struct Ring {
    double since_s = 0.0;
    double amplitude_n = 0.0;
  };

  Vec3 touched(const FormulaMoment& moment, bool begins);
  double layers_n(double depth_m, double inward_m_per_s);
  Vec3 friction(const Vec3& p, double coefficient, double normal_n, bool begins);
  Vec3 held_above(const Vec3& p);
  Vec3 in_space(const FormulaMoment& moment);

  const EffectCase& effects_;
  std::vector<SpaceState> space_;
  std::optional<double> last_s_ = {};
  bool in_contact_ = false;
  std::optional<Vec3> left_at_ = {};  // last point of the plane below the probe in contact: the snap holds around it
  Vec3 sticks_at_ = Vec3::Zero();
  Ring ring_;
  std::size_t punctured_ = 0;
  double resists_from_m_ = 0.0;
};

}  // namespace hapton
