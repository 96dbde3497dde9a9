// The stiffness and viscosity that stiffest.h states for every effect, compared with the derivative of the force that EffectStep computes.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <random>
#include <variant>

#include "core/effects/effect_step.h"
#include "core/force/stiffest.h"

namespace hapton {
namespace {

using Random = std::mt19937_64;

double between(Random& random, double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); }
double log_between(Random& random, double low, double high) { return std::exp(between(random, std::log(low), std::log(high))); }
Vec3 any_direction(Random& random) { return Vec3(between(random, -1, 1), between(random, -1, 1), between(random, -1, 1)).normalized(); }

// Largest eigenvalue of the symmetric part of -dF/dx, F(x) a force of three numbers.
template <class Force>
double largest_slope(const Force& force, const Vec3& at, double step) {
  Mat3 k;
  for (int i = 0; i < 3; ++i) k.col(i) = (force(at - step * Vec3::Unit(i)) - force(at + step * Vec3::Unit(i))) / (2.0 * step);
  return Eigen::SelfAdjointEigenSolver<Mat3>(0.5 * (k + k.transpose()), Eigen::EigenvaluesOnly).eigenvalues().maxCoeff();
}

// An effect that begins at rest in free space: its force as a function of the position, and as a function of the velocity.
struct SampledEffect {
  SpaceEffect effect;

  Vec3 force_at(const Vec3& p) const {
    EffectStep step({}, {effect});
    return step.step(p, 1e-3, {}).force_n;
  }
  // v is the velocity of the last eight intervals, of which SmoothVelocity takes the mean.
  Vec3 force_at_velocity(const Vec3& v) const {
    EffectStep step({}, {effect});
    Vec3 force = Vec3::Zero();
    for (int n = -8; n <= 0; ++n) force = step.step(1e-3 * n * v, 1e-3, {}).force_n;
    return force;
  }
};

// A random effect of each type (a new type does not compile without one), and the distance from the origin over which its force changes.
void draw_effect(Random& random, SpringEffect& made) {
  made = {.stiffness_n_per_m = log_between(random, 1.0, 1e6), .max_force_n = log_between(random, 0.1, 100.0)};
}
void draw_effect(Random& random, SnapEffect& made) {
  made = {.target = static_cast<SnapEffect::Target>(random() % 3),
          .direction = any_direction(random),
          .range_m = log_between(random, 1e-5, 1.0),
          .max_force_n = log_between(random, 0.1, 100.0)};
}
void draw_effect(Random& random, GravityWellEffect& made) {
  made = {.radius_m = log_between(random, 1e-5, 1.0), .max_force_n = log_between(random, 0.1, 100.0)};
}
void draw_effect(Random& random, ConstantEffect& made) { made = {.force_n = any_direction(random)}; }
void draw_effect(Random& random, ViscousEffect& made) {
  made = {.damping_ns_per_m = log_between(random, 0.1, 1000.0), .max_force_n = log_between(random, 0.1, 100.0)};
}
void draw_effect(Random& random, WaveEffect& made) { made = {.direction = any_direction(random)}; }
void draw_effect(Random& random, BurstEffect& made) { made = {.direction = any_direction(random)}; }
void draw_effect(Random& random, MassEffect& made) { made = {.mass_kg = log_between(random, 0.001, 5.0)}; }

double size_of(const SpringEffect& effect) { return effect.max_force_n / effect.stiffness_n_per_m; }
double size_of(const SnapEffect& effect) { return effect.range_m; }
double size_of(const GravityWellEffect& effect) { return effect.radius_m; }
template <class Other>
double size_of(const Other&) {
  return 0.01;
}

template <class Effect>
void expect_stiffness_of(Random& random) {
  for (int n = 0; n < 50; ++n) {
    Effect effect;
    draw_effect(random, effect);
    const SampledEffect sampled{effect};
    const auto force = [&](const Vec3& p) { return sampled.force_at(p); };
    const double size = size_of(effect);
    double largest_n_per_m = 0.0;
    for (int place = 0; place < 200; ++place) {
      const Vec3 at = log_between(random, 1e-3, 2.0) * size * any_direction(random);
      largest_n_per_m = std::max(largest_n_per_m, largest_slope(force, at, 1e-5 * size));
    }
    const double claimed_n_per_m = stiffest_of(effect).n_per_m;
    EXPECT_GE(claimed_n_per_m * (1.0 + 1e-4) + 1e-9, largest_n_per_m) << "type " << SpaceEffect(effect).index() << ", sample " << n;
    EXPECT_LE(claimed_n_per_m, 2.0 * largest_n_per_m + 1e-9) << "type " << SpaceEffect(effect).index() << ", sample " << n;
  }
}

template <class Effect>
void expect_viscosity_of(Random& random) {
  if (std::is_same_v<Effect, MassEffect>) return;  // has a limit of its own: hapton check and find_stable_mass
  for (int n = 0; n < 50; ++n) {
    Effect effect;
    draw_effect(random, effect);
    const SampledEffect sampled{effect};
    const auto force = [&](const Vec3& v) { return sampled.force_at_velocity(v); };
    const double largest_ns_per_m = largest_slope(force, 1e-5 * any_direction(random), 1e-5);
    const double claimed_ns_per_m = viscosity_of(SpaceEffect(effect));
    // The position changes with the velocity as well, but in the last sample it is the origin.
    EXPECT_NEAR(claimed_ns_per_m, std::max(0.0, largest_ns_per_m), 1e-4 * claimed_ns_per_m + 1e-9)
        << "type " << SpaceEffect(effect).index() << ", sample " << n;
  }
}

template <std::size_t... type>
void expect_all(std::index_sequence<type...>, Random& random) {
  (expect_stiffness_of<std::variant_alternative_t<type, SpaceEffect>>(random), ...);
  (expect_viscosity_of<std::variant_alternative_t<type, SpaceEffect>>(random), ...);
}

TEST(FeltStiffness, OfEveryEffectInFreeSpaceIsWhatItClaims) {
  Random random(17);
  SCOPED_TRACE("seed 17");
  expect_all(std::make_index_sequence<std::variant_size_v<SpaceEffect>>(), random);
}

// A plane that a method touches exactly: the proxy is on the plane straight above the device, the force is along z. Each sample is made by
// a copy of the EffectStep, so that its memory (friction, layers) is that of the sample before.
struct TouchedPlane {
  Material material;
  SurfaceEffects effects;
  double image_m = 1.0;  // a side of its images, which repeat

  SurfaceContact contact_at(const Vec3& p) const {
    return {.force_n = {0, 0, -material.stiffness_n_per_m * p.z()}, .p_SP = {p.x(), p.y(), 0}, .object = 0, .contact = p.z() < 0.0};
  }
  Vec3 force_at(EffectStep step, const Vec3& p) const {
    SurfaceContact contact = contact_at(p);
    MapSample map;
    if (effects.maps.is_on()) {
      map = effects.maps.sample({.texcoord = p.head<2>() / image_m, .du = Vec3::UnitX() / image_m, .dv = Vec3::UnitY() / image_m});
      contact.map = &map;
    }
    return step.step(p, 0.0, contact).force_n;
  }
};

// The largest stiffness found at many places of a plane that is pressed with up to this force.
double largest_felt_stiffness(const TouchedPlane& plane, double max_pressed_n, double size_m, Random& random) {
  double largest_n_per_m = 0.0;
  const double max_depth_m = max_pressed_n / stiffest_spring_of(plane.material, plane.effects).n_per_m;
  for (int n = 0; n < 3000; ++n) {
    const double height = plane.effects.bumps.height_m;
    const Vec3 at(between(random, 0, size_m), between(random, 0, size_m),
                  -max_depth_m * between(random, 0.97, 1.0) - height * between(random, 0, 1));
    EffectStep before({plane.effects}, {});
    const double pressed_n = before.step(at, 1e-3, plane.contact_at(at)).force_n.z();  // f: grad h has no component along n
    if (!(pressed_n > 0.0) || pressed_n > max_pressed_n) continue;
    const auto force = [&](const Vec3& p) { return plane.force_at(before, p); };
    largest_n_per_m = std::max(largest_n_per_m, largest_slope(force, at, 1e-6 * std::min(size_m, max_depth_m)));
  }
  return largest_n_per_m;
}

void expect_claim_up_to_twice_felt(const TouchedPlane& plane, double pressed_n, double size_m, Random& random, const std::string& what) {
  const double felt_n_per_m = largest_felt_stiffness(plane, pressed_n, size_m, random);
  const double claimed_n_per_m = stiffest_by_place_of(plane.material, plane.effects, pressed_n).n_per_m;
  EXPECT_GE(claimed_n_per_m * (1.0 + 1e-4), felt_n_per_m) << what;
  EXPECT_LE(claimed_n_per_m, 2.0 * felt_n_per_m) << what;
}

TEST(FeltStiffness, OfBumpsIsAtMostTwiceWhatIsFelt) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    Random random(seed);
    TouchedPlane plane{.material = {.stiffness_n_per_m = log_between(random, 50.0, 5000.0)}, .effects = {}};
    plane.effects.bumps = {.pattern = static_cast<SurfaceBumps::Pattern>(seed % 2), .length_m = log_between(random, 1e-4, 0.05)};
    plane.effects.bumps.height_m = plane.effects.bumps.length_m * between(random, 0.01, 0.33);
    expect_claim_up_to_twice_felt(plane, log_between(random, 0.5, 10.0), plane.effects.bumps.length_m, random,
                                  "seed " + std::to_string(seed));
  }
}

TEST(FeltStiffness, OfBumpsInLayersIsThatOfTheLayerThatIsPressed) {
  Random random(3);
  TouchedPlane plane{.material = {}, .effects = {}};
  plane.effects.bumps = {.height_m = 0.0003, .length_m = 0.001};
  plane.effects.layers.add({.depth_m = 0.0, .stiffness_n_per_m = 400.0, .pop_force_n = 2.0});
  const double weak = stiffest_by_place_of(plane.material, plane.effects, 10.0).n_per_m;
  EXPECT_EQ(weak, stiffest_by_place_of(plane.material, plane.effects, 2.0).n_per_m) << "it is punctured at 2 N";
  expect_claim_up_to_twice_felt(plane, 2.0, 0.001, random, "seed 3");
}

// Friction that the effects compute (methods smooth and sweep, and by an image) is a spring along the surface beside that of the bumps.
TEST(FeltStiffness, OfBumpsWithFrictionCountsBoth) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    TouchedPlane plane{
        .material = {.stiffness_n_per_m = log_between(random, 200.0, 2000.0), .friction_static = 0.9, .friction_dynamic = 0.9},
        .effects = {}};
    plane.effects.bumps = {.pattern = static_cast<SurfaceBumps::Pattern>(seed % 2), .length_m = log_between(random, 0.003, 0.05)};
    plane.effects.bumps.height_m = plane.effects.bumps.length_m * between(random, 0.01, 0.2);
    plane.effects.drag = {.stiffness_n_per_m = plane.material.stiffness_n_per_m, .friction = {0.9, 0.9}};
    expect_claim_up_to_twice_felt(plane, log_between(random, 0.5, 10.0), plane.effects.bumps.length_m, random,
                                  "seed " + std::to_string(seed));
  }
}

// Two triangles that put the image on a square of the plane.
std::shared_ptr<const std::vector<MappedTriangle>> square_of(double side_m) {
  const Vec3 right(side_m, 0, 0);
  const Vec3 up(0, side_m, 0);
  const std::vector<MappedTriangle> two = {{{Vec3(0, 0, 0), right, Vec3(right + up)}, {Eigen::Vector2d(0, 0), {1, 0}, {1, 1}}},
                                           {{Vec3(0, 0, 0), Vec3(right + up), up}, {Eigen::Vector2d(0, 0), {1, 1}, {0, 1}}}};
  return std::make_shared<const std::vector<MappedTriangle>>(two);
}

std::shared_ptr<const SurfaceImage> noise_of(Random& random, int side) {
  std::vector<float> texels;
  for (int n = 0; n < side * side; ++n) texels.push_back(static_cast<float>(between(random, 0, 1)));
  return std::make_shared<const SurfaceImage>(side, side, std::move(texels));
}

// The largest stiffness at many places. Each is pressed so deep below the bumps there that the force is pressed_n.
double largest_felt_stiffness_of_images(const TouchedPlane& plane, double pressed_n, Random& random) {
  double largest_n_per_m = 0.0;
  for (int n = 0; n < 4000; ++n) {
    Vec3 at(between(random, 0, plane.image_m), between(random, 0, plane.image_m), 0);
    const MapSample map =
        plane.effects.maps.sample({.texcoord = at.head<2>() / plane.image_m, .du = Vec3::UnitX() / plane.image_m, .dv = Vec3::Zero()});
    const double depth_m = pressed_n / (map.stiffness * plane.material.stiffness_n_per_m);
    at.z() = map.height_m - depth_m;
    const auto force = [&](const Vec3& p) { return plane.force_at(EffectStep({plane.effects}, {}), p); };
    largest_n_per_m = std::max(largest_n_per_m, largest_slope(force, at, 1e-6 * std::min(plane.image_m, depth_m)));
  }
  return largest_n_per_m;
}

// Relief and stiffness by images of noise, alone and together. Together, the bound takes the worst of each image for the same place.
TEST(FeltStiffness, OfImagesIsAtMostAFewTimesWhatIsFelt) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    Random random(seed);
    TouchedPlane plane{
        .material = {.stiffness_n_per_m = log_between(random, 200.0, 2000.0)}, .effects = {}, .image_m = log_between(random, 0.003, 0.1)};
    plane.effects.maps.triangles = square_of(plane.image_m);
    const bool has_height = seed % 3 != 0;
    const bool has_stiffness = seed % 3 != 1;
    if (has_height)
      plane.effects.maps.height = {
          .image = noise_of(random, 5), .at_black = -0.1 * plane.image_m * between(random, 0.1, 1.0), .at_white = 0.0};
    if (has_stiffness)
      plane.effects.maps.stiffness = {.image = noise_of(random, 4), .at_black = between(random, 0.2, 0.8), .at_white = 1.0};
    const double pressed_n = log_between(random, 0.5, 10.0);
    const double felt_n_per_m = largest_felt_stiffness_of_images(plane, pressed_n, random);
    const double claimed_n_per_m = stiffest_by_place_of(plane.material, plane.effects, pressed_n).n_per_m;
    EXPECT_GE(claimed_n_per_m * (1.0 + 1e-3), felt_n_per_m) << "seed " << seed;
    EXPECT_LE(claimed_n_per_m, (has_height && has_stiffness ? 3.0 : 2.0) * felt_n_per_m) << "seed " << seed;
  }
}

// The derivative with respect to the velocity: the needle moves along n - grad h, into layers of which one has been punctured. It presses
// the next one, because viscosity is limited to the force on the surface.
TEST(FeltStiffness, DragOfLayersIsWhatTheNeedleFeels) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    TouchedPlane plane{.material = {}, .effects = {}};
    if (seed % 2 == 0) plane.effects.bumps = {.height_m = 0.0003, .length_m = 0.002};
    if (seed % 3 == 0) plane.effects.viscosity.damping_ns_per_m = log_between(random, 1.0, 100.0);
    plane.effects.layers.add(
        {.depth_m = 0.0, .stiffness_n_per_m = 400.0, .pop_force_n = 0.1, .drag_ns_per_m = log_between(random, 1.0, 100.0)});
    plane.effects.layers.add({.depth_m = 0.005, .stiffness_n_per_m = 400.0, .drag_ns_per_m = 900.0});
    double largest_ns_per_m = 0.0;
    for (int n = 0; n < 200; ++n) {
      const Vec3 at(between(random, 0, 0.002), between(random, 0, 0.002), -0.012);
      EffectStep punctured({plane.effects}, {});
      for (int k = 0; k < 10; ++k) {
        const Vec3 before = at + Vec3(0, 0, 0.0002 * (9 - k));
        punctured.step(before, 1e-3, plane.contact_at(before));
      }
      for (int k = 0; k < 10; ++k) punctured.step(at, 1e-3, plane.contact_at(at));
      const auto force = [&](const Vec3& v) {
        EffectStep step = punctured;
        Vec3 felt = Vec3::Zero();
        for (int k = -8; k <= 0; ++k) felt = step.step(at + 1e-3 * k * v, 1e-3, plane.contact_at(at + 1e-3 * k * v)).force_n;
        return felt;
      };
      largest_ns_per_m = std::max(largest_ns_per_m, largest_slope(force, Vec3::Zero(), 1e-5));
    }
    const double claimed_ns_per_m = std::max(drag_of(plane.effects), viscosity_of(plane.effects));
    EXPECT_GE(claimed_ns_per_m * (1.0 + 1e-4), largest_ns_per_m) << "seed " << seed;
    EXPECT_LE(claimed_ns_per_m, 2.0 * largest_ns_per_m) << "seed " << seed;
  }
}

}  // namespace
}  // namespace hapton
