#include "core/effects/surface_maps.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "core/effects/effect_step.h"
#include "tests/core/effects/effect_paths.h"

namespace hapton {
namespace {

constexpr double kMapSpring = 1000.0;  // N/m
constexpr double kSide = 0.1;          // m: the image lies on a square of the plane z = 0
constexpr double kRadPerWave = 2.0 * std::numbers::pi;

template <class ValueAt>
std::shared_ptr<const SurfaceImage> shared_image(int side, ValueAt value_at) {
  std::vector<float> texels;
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) texels.push_back(static_cast<float>(value_at((x + 0.5) / side, (y + 0.5) / side)));
  }
  return std::make_shared<const SurfaceImage>(side, side, std::move(texels));
}

std::shared_ptr<const std::vector<MappedTriangle>> square() {
  const std::vector<MappedTriangle> two = {
      {{Vec3(0, 0, 0), Vec3(kSide, 0, 0), Vec3(kSide, kSide, 0)}, {Eigen::Vector2d(0, 0), {1, 0}, {1, 1}}},
      {{Vec3(0, 0, 0), Vec3(kSide, kSide, 0), Vec3(0, kSide, 0)}, {Eigen::Vector2d(0, 0), {1, 1}, {0, 1}}}};
  return std::make_shared<const std::vector<MappedTriangle>>(two);
}

// The place of p on the map of the square; the map continues beyond the sides of the square.
MapPlace place_of(const Vec3& p) { return {.texcoord = p.head<2>() / kSide, .du = Vec3::UnitX() / kSide, .dv = Vec3::UnitY() / kSide}; }

struct MappedPlane {
  explicit MappedPlane(const SurfaceMaps& surface_maps) : maps(surface_maps), step({SurfaceEffects{.maps = surface_maps}}, {}) {}

  Vec3 force_at(const Vec3& p_SD) {
    SurfaceContact contact{.p_SP = p_SD};
    const MapSample map = maps.sample(place_of(p_SD));
    if (p_SD.z() < 0.0) {
      contact = {.force_n = {0, 0, -kMapSpring * p_SD.z()}, .p_SP = {p_SD.x(), p_SD.y(), 0}, .object = 0, .contact = true, .map = &map};
    }
    return step.step(p_SD, 1e-3, contact).force_n;
  }

  SurfaceMaps maps;
  EffectStep step;
};

TEST(SurfaceMaps, GradientsAreThoseOfTheTriangle) {
  const auto triangles = square();
  for (const MappedTriangle& triangle : *triangles) {
    const MapPlace place = map_gradients(triangle);
    EXPECT_LT((place.du - Vec3::UnitX() / kSide).norm(), 1e-12);
    EXPECT_LT((place.dv - Vec3::UnitY() / kSide).norm(), 1e-12);
  }
  // Any triangle: the gradients give the differences along its edges, and lie in its plane.
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int n = 0; n < 100; ++n) {
    MappedTriangle triangle;
    for (std::size_t k = 0; k < 3; ++k) {
      triangle.corner[k] = Vec3(unit(random), unit(random), unit(random));
      triangle.texcoord[k] = {unit(random), unit(random)};
    }
    const MapPlace place = map_gradients(triangle);
    const Vec3 normal = (triangle.corner[1] - triangle.corner[0]).cross(triangle.corner[2] - triangle.corner[0]).normalized();
    for (std::size_t k = 1; k < 3; ++k) {
      const Vec3 edge = triangle.corner[k] - triangle.corner[0];
      const Eigen::Vector2d difference = triangle.texcoord[k] - triangle.texcoord[0];
      EXPECT_NEAR(place.du.dot(edge), difference.x(), 1e-9);
      EXPECT_NEAR(place.dv.dot(edge), difference.y(), 1e-9);
    }
    EXPECT_LT(std::abs(place.du.dot(normal)), 1e-9 * place.du.norm());
  }
  const MappedTriangle flat = {{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(2, 0, 0)}, {Eigen::Vector2d(0, 0), {1, 0}, {1, 1}}};
  EXPECT_EQ(map_gradients(flat).du, Vec3(0, 0, 0)) << "without area";
  EXPECT_EQ(map_gradients(flat).dv, Vec3(0, 0, 0));
  // The edges are so short that the square of their normal underflows to 0.
  const MappedTriangle tiny = {{Vec3(1, 2, 3), Vec3(1, 2, 3) + 0x1p-52 * Vec3(4, 0, 0), Vec3(1, 2, 3) + 0x1p-52 * Vec3(0, 4, 0)},
                               {Eigen::Vector2d(0.3, 0.4), {1e200, 0}, {0, 1e200}}};
  for (const double scale : {0.0, 1e-100}) {
    MappedTriangle small = tiny;
    for (Vec3& corner : small.corner) corner *= scale;
    EXPECT_EQ(map_gradients(small).du, Vec3(0, 0, 0)) << scale;
    EXPECT_EQ(map_gradients(small).dv, Vec3(0, 0, 0)) << scale;
    EXPECT_EQ(map_gradients(small).texcoord, Eigen::Vector2d(0.3, 0.4)) << scale;
  }
}

// A file may have any texture coordinates: if one gradient overflows, both are zero, so that no force is NaN.
TEST(SurfaceMaps, AGradientThatIsNotFiniteIsZero) {
  for (const bool is_along_u : {true, false}) {
    MappedTriangle triangle = {{Vec3(0, 0, 0), Vec3(1e-3, 0, 0), Vec3(0, 1e-3, 0)}, {Eigen::Vector2d(0, 0), {1, 0}, {0, 1}}};
    EXPECT_GT(map_gradients(triangle).du.norm() * map_gradients(triangle).dv.norm(), 1e5);
    for (Eigen::Vector2d& texcoord : triangle.texcoord) texcoord[is_along_u ? 0 : 1] *= 1e308;
    const MapPlace place = map_gradients(triangle);
    EXPECT_EQ(place.du, Vec3(0, 0, 0)) << is_along_u;
    EXPECT_EQ(place.dv, Vec3(0, 0, 0)) << is_along_u;
  }
}

// The image of a ramp is felt as an inclined plane: f(d + h) (n - grad h), with the depth d and the height h, which is linear.
TEST(SurfaceMaps, ARampPushesDownhillByTheFormula) {
  const ImageMap height = {.image = shared_image(256, [](double u, double) { return u; }), .at_black = -1e-3, .at_white = 0.0};
  MappedPlane plane({.triangles = square(), .height = height});
  for (double x = 0.01; x < 0.09; x += 0.003) {
    for (const double depth_m : {0.0005, 0.002, 0.004}) {
      const double pressed_m = std::max(0.0, depth_m - 1e-3 * (1.0 - x / kSide));
      const Vec3 expected = kMapSpring * pressed_m * (Vec3::UnitZ() - 1e-3 / kSide * Vec3::UnitX());
      EXPECT_LT((plane.force_at({x, 0.03, -depth_m}) - expected).norm(), 1e-5) << x << " " << depth_m;
    }
  }
}

// An image of a wave feels like bumps (SurfaceBumps) of that wave, but for the height that the spline smooths away at 64 texels a wave.
TEST(SurfaceMaps, AWaveFeelsAsBumpsByTheFormula) {
  constexpr double kHeight = 1e-3;
  const SurfaceBumps bumps = {.pattern = SurfaceBumps::Pattern::ridges, .height_m = kHeight, .length_m = kSide / 8.0};
  const ImageMap height = {.image = shared_image(512, [](double u, double) { return 0.5 + 0.5 * std::cos(8.0 * kRadPerWave * u); }),
                           .at_black = -kHeight,
                           .at_white = 0.0};
  MappedPlane plane({.triangles = square(), .height = height});
  EffectStep formula({SurfaceEffects{.bumps = bumps}}, {});
  const double share = 1.0 - std::pow(std::cos(std::numbers::pi / 64.0), 2);
  for (double x = 0.0; x < kSide; x += 0.00037) {
    const Vec3 p(x, 0.02, -0.003);
    const Vec3 expected = formula.step(p, 1e-3, {.force_n = {0, 0, 3.0}, .p_SP = {x, 0.02, 0}, .object = 0, .contact = true}).force_n;
    // Allowed error: `share` of the spring force kMapSpring * kHeight / 2 = 0.5 N, and of the force along the slope, 3 N times the slope.
    EXPECT_LT((plane.force_at(p) - expected).norm(), share * (0.5 + 3.0 * bumps.slope()) + 1e-3) << x;
  }
  EXPECT_NEAR(height.steepest(*square()), bumps.slope(), 0.01 * bumps.slope());
}

TEST(SurfaceMaps, StiffnessScalesTheSpringAndPushesToTheSoftSide) {
  const ImageMap stiffness = {.image = shared_image(256, [](double u, double) { return u; }), .at_black = 0.2, .at_white = 1.0};
  MappedPlane plane({.triangles = square(), .stiffness = stiffness});
  for (double x = 0.01; x < 0.09; x += 0.007) {
    const double share = 0.2 + 0.8 * x / kSide;
    const double energy_j = 0.5 * kMapSpring * 0.003 * 0.003;
    EXPECT_LT((plane.force_at({x, 0.05, -0.003}) - Vec3(-energy_j * 0.8 / kSide, 0, share * 3.0)).norm(), 1e-5) << x;
  }
}

TEST(SurfaceMaps, HeightAndStiffnessGiveNoEnergyOverAClosedPath) {
  const auto waves = [](double u, double v) { return 0.5 + 0.25 * (std::sin(8.0 * kRadPerWave * u) + std::sin(6.0 * kRadPerWave * v)); };
  const auto others = [](double u, double v) { return 0.5 + 0.5 * std::sin(5.0 * kRadPerWave * u) * std::cos(3.0 * kRadPerWave * v); };
  const ImageMap height = {.image = shared_image(256, waves), .at_black = -1e-3, .at_white = 0.0};
  const ImageMap stiffness = {.image = shared_image(128, others), .at_black = 0.1, .at_white = 1.0};
  const SurfaceMaps cases[] = {{.triangles = square(), .height = height},
                               {.triangles = square(), .stiffness = stiffness},
                               {.triangles = square(), .height = height, .stiffness = stiffness}};
  for (const SurfaceMaps& maps : cases) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      MappedPlane plane(maps);
      const auto work =
          paths::work_along(paths::closed(seed, 50000, {0.05, 0.05, -0.002}, 0.012), [&](const Vec3& p) { return plane.force_at(p); });
      EXPECT_LT(std::abs(work.net_j), 1e-4 * work.absolute_j) << "seed " << seed;
    }
  }
}

// Friction coefficient 0.8 on one half and 0.1 on the other: the force changes at the border of the halves and nowhere else.
TEST(SurfaceMaps, FrictionIsThatOfThePlace) {
  const ImageMap friction = {
      .image = shared_image(256, [](double u, double) { return u < 0.5 ? 1.0 : 0.0; }), .at_black = 0.1, .at_white = 0.8};
  MappedPlane plane({.triangles = square(), .friction = friction});
  for (double x = 0.01; x < 0.09; x += 1e-4) {
    const Vec3 force_n = plane.force_at({x, 0.05, -0.002});
    EXPECT_NEAR(force_n.z(), 2.0, 1e-12);
    if (x > 0.013 && x < 0.049) {
      EXPECT_NEAR(force_n.x(), -1.6, 1e-6) << x;
    }
    if (x > 0.053) {
      EXPECT_NEAR(force_n.x(), -0.2, 1e-6) << x;
    }
  }
  // Lifted off and put down again elsewhere: no friction force is left over.
  plane.force_at({0.02, 0.05, 0.001});
  EXPECT_NEAR(plane.force_at({0.021, 0.05, -0.002}).x(), 0.0, 1e-12);
}

TEST(SurfaceMaps, TheSteepestSlopeIsNeverExceeded) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> unit(0, 1);
  const ImageMap height = {.image = shared_image(32, [&](double, double) { return unit(random); }), .at_black = -1e-3, .at_white = 0.0};
  const double steepest = height.steepest(*square());
  double steepest_sampled = 0.0;
  for (int n = 0; n < 20000; ++n)
    steepest_sampled = std::max(steepest_sampled, height.at(place_of(kSide * Vec3(unit(random), unit(random), 0))).gradient.norm());
  EXPECT_LE(steepest_sampled, steepest * (1.0 + 1e-12));
  EXPECT_GT(steepest_sampled, 0.3 * steepest);
}

// Viscosity that rises to the right: the force is -b(u) v along the surface, at most the contact force.
TEST(SurfaceMaps, ViscosityIsThatOfThePlace) {
  const ImageMap viscosity = {.image = shared_image(256, [](double u, double) { return u; }), .at_black = 0.0, .at_white = 20.0};
  MappedPlane plane({.triangles = square(), .viscosity = viscosity});
  for (int n = 0; n < 160; ++n) {
    const double x = 0.01 + 5e-4 * n;
    const Vec3 force_n = plane.force_at({x, 0.05, -0.003});
    if (n < 10) continue;  // the velocity is a mean of eight differences
    EXPECT_NEAR(force_n.x(), -std::min(20.0 * x / kSide * 0.5, 3.0), 2e-3) << x;
    EXPECT_NEAR(force_n.z(), 3.0, 1e-9);
  }
}

}  // namespace
}  // namespace hapton
