#include "bench/measure/effect_cases.h"

#include <array>
#include <memory>
#include <utility>

#include "core/effects/texture_models.h"

namespace hapton {
namespace {

SurfaceEffects made_layers() {
  SurfaceEffects effects;
  for (int i = 0; i < 8; ++i) {
    effects.layers.add({.depth_m = 1e-3 * i, .stiffness_n_per_m = 1000.0, .pop_force_n = 0.5, .drag_ns_per_m = 1.0});
  }
  return effects;
}

SurfaceEffects all_of_a_surface() {
  return {.progressive = {.n_per_m2 = 1e5},
          .layers = {},
          .bumps = {.height_m = 2e-4, .length_m = 2e-3},
          .viscosity = {.damping_ns_per_m = 3.0},
          .snap = {.range_m = 2e-3},
          .tap = {.ns_per_m = 5.0}};
}

// The image whose texels are the values of brightness_at.
std::shared_ptr<const SurfaceImage> waves_image() {
  std::vector<float> texels;
  for (int y = 0; y < kTexels; ++y) {
    for (int x = 0; x < kTexels; ++x) texels.push_back(static_cast<float>(brightness_at((x + 0.5) / kTexels, (y + 0.5) / kTexels)));
  }
  return std::make_shared<const SurfaceImage>(kTexels, kTexels, std::move(texels));
}

// All kinds of maps on one mesh; the texture coordinates are x and y of the corners, a projection from above.
SurfaceMaps all_maps(const TriangleMesh& mesh) {
  auto triangles = std::make_shared<std::vector<MappedTriangle>>();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    MappedTriangle made;
    for (std::size_t k = 0; k < 3; ++k) {
      made.corner[k] = mesh.corner(t, static_cast<int>(k));
      made.texcoord[k] = kImagesPerM * made.corner[k].head<2>();
    }
    triangles->push_back(made);
  }
  const auto image = waves_image();
  return {.triangles = triangles,
          .height = {.image = image, .at_black = -2e-4, .at_white = 0.0},
          .stiffness = {.image = image, .at_black = 0.5, .at_white = 1.0},
          .friction = {.image = image, .at_black = 0.1, .at_white = 0.8},
          .viscosity = {.image = image, .at_black = 0.0, .at_white = 3.0}};
}

std::vector<EffectCase> map_cases(const TriangleMesh& mesh) {
  const SurfaceMaps all = all_maps(mesh);
  return {{"bumps, image", {.maps = {.triangles = all.triangles, .height = all.height}}, {}},
          {"stiffness, image", {.maps = {.triangles = all.triangles, .stiffness = all.stiffness}}, {}},
          {"friction, image", {.maps = {.triangles = all.triangles, .friction = all.friction}}, {}},
          {"viscosity, image", {.maps = {.triangles = all.triangles, .viscosity = all.viscosity}}, {}},
          {"all images", {.maps = all}, {}}};
}

// Makes a texture with as many models as recorded ones have: 6 x 6 models, joined by 50 triangles.
std::shared_ptr<const TextureModels> made_texture(double rate_hz, std::size_t ar, std::size_t ma) {
  constexpr std::size_t kSide = 6;
  const auto spread = [](std::size_t order, double shift) {
    std::vector<double> frequencies;
    for (std::size_t i = 0; i < order; ++i)
      frequencies.push_back(std::numbers::pi * (static_cast<double>(i) + shift) / static_cast<double>(order));
    return frequencies;
  };
  std::vector<TextureModel> models;
  for (std::size_t n = 0; n < kSide * kSide; ++n) {
    const double shift = 0.3 + 0.4 * static_cast<double>(n) / (kSide * kSide);
    models.push_back({.speed_m_per_s = 0.05 * static_cast<double>(n % kSide),
                      .force_n = 1.0 * static_cast<double>(n / kSide),
                      .ar = spread(ar, shift),
                      .ma = spread(ma, shift),
                      .variance = 0.01 * static_cast<double>(n)});
  }
  std::vector<TextureTriangle> triangles;
  for (std::size_t n = 0; n + kSide < models.size(); ++n) {
    if (n % kSide == kSide - 1) continue;
    triangles.push_back({n, n + 1, n + kSide});
    triangles.push_back({n + 1, n + kSide + 1, n + kSide});
  }
  auto made = TextureModels::make(rate_hz, std::move(models), std::move(triangles));
  return made ? std::make_shared<const TextureModels>(std::move(*made)) : nullptr;
}

std::vector<EffectCase> texture_cases() {
  return {{"texture of 1 kHz", {.texture = {.models = made_texture(1000.0, 20, 18)}}, {}},
          {"texture of 10 kHz", {.texture = {.models = made_texture(10000.0, 20, 0)}}, {}}};
}

struct NamedEffect {
  std::string name;
  SwitchedEffect effect;
};

// The burst decays in 50 s, so that it vibrates in every step of a run.
std::vector<NamedEffect> all_of_space() {
  const auto everywhere = EffectVolume::ball(Vec3::Zero(), 1.0);
  return {{"spring", SpringEffect{}},
          {"constant", ConstantEffect{.force_n = {0, -0.2, 0}, .volume = everywhere}},
          {"magnet", SnapEffect{.range_m = 0.2}},
          {"line snap", SnapEffect{.target = SnapEffect::Target::line, .range_m = 0.2}},
          {"plane snap", SnapEffect{.target = SnapEffect::Target::plane, .range_m = 0.2}},
          {"gravity well", GravityWellEffect{}},
          {"viscous", ViscousEffect{.volume = everywhere}},
          {"wave", WaveEffect{.volume = everywhere}},
          {"mass", MassEffect{.volume = everywhere}},
          {"burst", BurstEffect{.decay_s = 50.0, .duration_s = 60.0, .volume = EffectVolume::box({-1, -1, 0}, {1, 1, 1})}}};
}

std::vector<EffectCase> formula_cases() {
  std::vector<EffectCase> cases = {
      {"none", {}, {}},
      {"progressive stiffness", {.progressive = {.n_per_m2 = 1e5}}, {}},
      {"8 layers", made_layers(), {}},
      {"bumps, ridges", {.bumps = {.pattern = SurfaceBumps::Pattern::ridges, .height_m = 2e-4, .length_m = 2e-3}}, {}},
      {"bumps, grid", {.bumps = {.height_m = 2e-4, .length_m = 2e-3}}, {}},
      {"viscosity", {.viscosity = {.damping_ns_per_m = 3.0}}, {}},
      {"snap", {.snap = {.range_m = 2e-3}}, {}},
      {"vibration on tap", {.tap = {.ns_per_m = 5.0, .decay_s = 60.0}}, {}},
      {"all of a surface", all_of_a_surface(), {}},
  };
  std::vector<SwitchedEffect> space;
  for (const NamedEffect& one : all_of_space()) {
    cases.push_back({one.name, {}, {one.effect}});
    space.push_back(one.effect);
  }
  cases.push_back({"all of space", {}, space});
  cases.push_back({"all of both", all_of_a_surface(), space});
  return cases;
}

}  // namespace

std::vector<EffectCase> make_effect_cases(const TriangleMesh& mesh) {
  std::vector<EffectCase> cases = formula_cases();
  for (EffectCase& one : map_cases(mesh)) cases.push_back(std::move(one));
  for (EffectCase& one : texture_cases()) cases.push_back(std::move(one));
  return cases;
}

}  // namespace hapton
