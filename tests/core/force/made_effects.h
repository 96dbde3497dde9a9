#pragma once

#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include "core/effects/surface_effects.h"
#include "core/geometry/triangle_mesh.h"
#include "tests/core/effects/made_textures.h"

namespace hapton {

// An image with waves in both directions, over the sides of a box.
inline std::shared_ptr<const SurfaceImage> made_wave_image() {
  std::vector<float> texels;
  for (int v = 0; v < 32; ++v) {
    for (int u = 0; u < 32; ++u) {
      const double wave = std::sin(2.0 * std::numbers::pi * u / 32.0) * std::cos(2.0 * std::numbers::pi * v / 32.0);
      texels.push_back(static_cast<float>(0.5 + 0.4 * wave));
    }
  }
  return std::make_shared<const SurfaceImage>(32, 32, std::move(texels));
}

// Texture coordinates by x and y: the image repeats every 20 mm.
inline std::shared_ptr<const std::vector<MappedTriangle>> mapped_triangles(const TriangleMesh& mesh) {
  auto triangles = std::make_shared<std::vector<MappedTriangle>>();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    MappedTriangle made;
    for (std::size_t k = 0; k < 3; ++k) {
      made.corner[k] = mesh.corner(t, static_cast<int>(k));
      made.texcoord[k] = made.corner[k].head<2>() / 0.02;
    }
    triangles->push_back(made);
  }
  return triangles;
}

struct NamedEffects {
  const char* name;
  std::function<SurfaceEffects(const TriangleMesh&)> make;
};

inline SurfaceEffects skin_and_flesh() {
  SurfaceEffects effects;
  effects.layers.add({.depth_m = 0.0, .stiffness_n_per_m = 500.0, .pop_force_n = 0.6, .drag_ns_per_m = 3.0});
  effects.layers.add({.depth_m = 0.004, .stiffness_n_per_m = 800.0});
  return effects;
}

inline SurfaceEffects with_map(const TriangleMesh& mesh, ImageMap SurfaceMaps::*map, double at_black, double at_white) {
  SurfaceEffects effects;
  effects.maps.triangles = mapped_triangles(mesh);
  effects.maps.*map = {.image = made_wave_image(), .at_black = at_black, .at_white = at_white};
  return effects;
}

inline std::vector<NamedEffects> all_effects() {
  using Mesh = const TriangleMesh&;
  return {
      {"progressive", [](Mesh) { return SurfaceEffects{.progressive = {.n_per_m2 = 2e5}}; }},
      {"layers", [](Mesh) { return skin_and_flesh(); }},
      {"grid", [](Mesh) { return SurfaceEffects{.bumps = {.height_m = 4e-4, .length_m = 5e-3}}; }},
      {"ridges",
       [](Mesh) {
         return SurfaceEffects{
             .bumps = {.pattern = SurfaceBumps::Pattern::ridges, .height_m = 4e-4, .length_m = 5e-3, .direction = Vec3(0.6, 0.8, 0.0)}};
       }},
      {"viscosity", [](Mesh) { return SurfaceEffects{.viscosity = {.damping_ns_per_m = 4.0}}; }},
      {"snap", [](Mesh) { return SurfaceEffects{.snap = {.stiffness_n_per_m = 300.0, .range_m = 2e-3}}; }},
      {"tap", [](Mesh) { return SurfaceEffects{.tap = {.ns_per_m = 8.0, .frequency_hz = 80.0}}; }},
      {"texture", [](Mesh) { return SurfaceEffects{.texture = {.models = made::texture(1000.0, 20, 18), .mass_kg = 0.1}}; }},
      {"height map", [](Mesh mesh) { return with_map(mesh, &SurfaceMaps::height, -5e-4, 0.0); }},
      {"stiffness map", [](Mesh mesh) { return with_map(mesh, &SurfaceMaps::stiffness, 0.2, 1.0); }},
      {"friction map", [](Mesh mesh) { return with_map(mesh, &SurfaceMaps::friction, 0.1, 0.6); }},
      {"viscosity map", [](Mesh mesh) { return with_map(mesh, &SurfaceMaps::viscosity, 0.5, 5.0); }},
  };
}

}  // namespace hapton
