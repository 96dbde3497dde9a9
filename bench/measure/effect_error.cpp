#include "bench/measure/effect_error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <random>

#include "bench/measure/effect_formula.h"
#include "core/force/force_method.h"
#include "core/force/touch_step.h"
#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

// The formula is evaluated this often in a step, so it finds an event (contact, puncture, slip) to 1/64 step, below the sampling error.
constexpr int kMomentsPerStep = 64;

// The hand already moves at the start of a run, but the velocity estimates and virtual masses of the effects begin at rest. After this
// time, 25 times the memory of SmoothVelocity at 1 kHz, the difference has died out.
constexpr double kSettleS = 0.2;

// At the beginning the hand is at least this high above the plane, so that every run begins without contact; a free choice.
constexpr double kFirstHeightM = 0.2e-3;

// The time of a sample since the start of the motion; the first sample is one step after that, as in EffectStep.
double time_of(std::size_t sample, double rate_hz) { return static_cast<double>(sample + 1) / rate_hz; }

// A hand that strokes and lifts: on each axis a sum of two waves, from 1.6 mm below the plane to 0.9 mm above it, and at most 0.15 m/s
// along the plane. The common period of all waves is 100 s, so that no part of a run repeats. The motion begins above the plane. Frame S.
class SmoothMotion {
 public:
  explicit SmoothMotion(std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> phase(0.0, 2.0 * std::numbers::pi);
    do {
      for (auto& axis : waves_) {
        for (Wave& wave : axis) wave.phase = phase(random);
      }
    } while (at(0.0).p.z() < kFirstHeightM);
  }

  FormulaMoment at(double time_s) const {
    FormulaMoment moment = {.time_s = time_s, .p = mean_, .v = Vec3::Zero()};
    for (int axis = 0; axis < 3; ++axis) {
      for (const Wave& wave : waves_[static_cast<std::size_t>(axis)]) {
        const double angular_frequency = 2.0 * std::numbers::pi * wave.hz;
        moment.p[axis] += wave.length_m * std::sin(angular_frequency * time_s + wave.phase);
        moment.v[axis] += wave.length_m * angular_frequency * std::cos(angular_frequency * time_s + wave.phase);
      }
    }
    return moment;
  }

 private:
  struct Wave {
    double length_m, hz, phase = 0.0;
  };

  Vec3 mean_ = {0, 0, -0.35e-3};
  std::array<std::array<Wave, 2>, 3> waves_ = {{{{{.length_m = 0.02, .hz = 0.61}, {.length_m = 0.004, .hz = 1.3}}},
                                                {{{.length_m = 0.015, .hz = 0.47}, {.length_m = 0.003, .hz = 1.7}}},
                                                {{{.length_m = 0.9e-3, .hz = 1.1}, {.length_m = 0.35e-3, .hz = 2.3}}}}};
};

// The force of every step in newtons, as method proxy computes it with these effects. Frame S.
Result<std::vector<Vec3>> felt_forces(const EffectCase& effects, const SmoothMotion& motion, const EffectErrorSettings& settings) {
  const TouchScene scene = {.objects = {{std::make_shared<const TriangleMesh>(effect_plane()), {}, effects.surface}},
                            .effects = effects.space};
  auto method = make_method({}, scene);
  if (!method) return tl::unexpected(method.error());
  TouchStep touch(std::move(*method), scene);
  TouchInput input;
  input.dt_s = 1.0 / settings.rate_hz;
  std::vector<Vec3> felt;
  for (std::size_t i = 0; i < settings.steps; ++i) {
    input.p_WD = motion.at(time_of(i, settings.rate_hz)).p;
    if (i == 0) touch.reset(input);
    felt.push_back(touch.step(input).force_n);
  }
  return felt;
}

}  // namespace

const TriangleMesh& effect_plane() {
  static const TriangleMesh plane = make_plane_grid(0.1, 4);
  return plane;
}

Result<std::optional<EffectError>> measure_effect_error(const EffectCase& effects, const EffectErrorSettings& settings) {
  if (effects.surface.texture.is_on() || static_cast<double>(settings.steps) <= kSettleS * settings.rate_hz) return std::nullopt;
  const SmoothMotion motion(settings.seed);
  const auto felt = felt_forces(effects, motion, settings);
  if (!felt) return tl::unexpected(felt.error());

  const bool is_plain = !effects.surface.any() && effects.space.empty();
  EffectFormula form(effects);
  double error_squares = 0.0;
  double exact_squares = 0.0;
  double worst = 0.0;
  for (std::size_t i = 0; i < felt->size(); ++i) {
    Vec3 exact = Vec3::Zero();
    for (int part = i == 0 ? kMomentsPerStep : 1; part <= kMomentsPerStep;
         ++part) {  // the formula begins at the first sample, like the method
      const double behind_s = (1.0 - static_cast<double>(part) / kMomentsPerStep) / settings.rate_hz;
      exact = form.force_at(motion.at(time_of(i, settings.rate_hz) - behind_s));
    }
    if (time_of(i, settings.rate_hz) < kSettleS) continue;
    const Vec3 spring = is_plain ? Vec3(Vec3::Zero()) : plane_spring(motion.at(time_of(i, settings.rate_hz)).p);
    const double difference = ((*felt)[i] - exact).norm();
    error_squares += difference * difference;
    exact_squares += (exact - spring).squaredNorm();
    worst = std::max(worst, difference);
  }
  return EffectError{.rms = exact_squares > 0.0 ? std::sqrt(error_squares / exact_squares) : std::sqrt(error_squares), .worst_n = worst};
}

}  // namespace hapton
