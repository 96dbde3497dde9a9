#pragma once

#include <array>
#include <memory>
#include <vector>

#include "core/effects/effect_sample.h"
#include "core/effects/surface_image.h"

namespace hapton {

// A triangle of a surface and where it lies in the images.
struct MappedTriangle {
  std::array<Vec3, 3> corner;               // frame S
  std::array<Eigen::Vector2d, 3> texcoord;  // as in SurfaceImage
};

// Texture coordinates (u, v) of a surface point, and their gradients along the surface. Frame: S. Units of du and dv: 1/m.
struct MapPlace {
  Eigen::Vector2d texcoord = Eigen::Vector2d::Zero();
  Vec3 du = Vec3::Zero();
  Vec3 dv = Vec3::Zero();
};

// A number of a surface that an image gives: from at_black to at_white, linear in the image's value.
struct ImageMap {
  struct Value {
    double number = 0.0;
    Vec3 gradient = Vec3::Zero();  // along the surface, per metre
  };

  std::shared_ptr<const SurfaceImage> image = {};  // null: off
  double at_black = 0.0;
  double at_white = 0.0;

  bool is_on() const noexcept { return image != nullptr; }
  Value at(const MapPlace& place) const noexcept;
  // The largest |gradient| anywhere on these triangles. RT: set-up only.
  double steepest(const std::vector<MappedTriangle>& triangles) const;
};

// What the images of a surface say at one place.
struct MapSample {
  double height_m = 0.0;
  Vec3 height_gradient = Vec3::Zero();
  double stiffness = 1.0;  // share of the material's
  Vec3 stiffness_gradient = Vec3::Zero();
  double friction = 0.0;
  double viscosity_ns_per_m = 0.0;
};

// Images on the surface's texture coordinates give height, stiffness, friction and viscosity. With U(d) the energy of the material's spring
// at the depth d, f = dU/dd its force, h the height (at most 0, as in SurfaceBumps) and s the share of the stiffness, the force becomes
//   s f(d + h) (n - grad h) - U(d + h) grad s,
// the gradient of one potential, s U(d + h): going from soft to stiff costs what stiff to soft gives back. Friction is SpringFriction,
// viscosity SurfaceViscosity. Frame: S. RT: sample yes.
//
// Bound: that of f, times sqrt(1 + slope^2), plus U times the gradient of s. Passivity: conservative on flat surfaces, friction and
// viscosity dissipative; on curved ones as SurfaceBumps. Where texture coordinates have a seam, neighbouring places lie apart in the
// images: the force is continuous there if the images agree on both sides of the seam.
struct SurfaceMaps {
  static constexpr Passivity kPassivity = Passivity::conservative;
  // The largest slope of the height: that of the steepest bumps by a formula.
  static constexpr double kSteepest = 1.05;

  std::shared_ptr<const std::vector<MappedTriangle>> triangles = {};  // not null where a map is on
  ImageMap height = {};                                               // m, -bump_height_m to 0
  ImageMap stiffness = {};                                            // share, above 0, at most 1
  ImageMap friction = {};                                             // coefficient
  ImageMap viscosity = {};                                            // Ns/m, 0 or more

  bool is_on() const noexcept { return height.is_on() || stiffness.is_on() || friction.is_on() || viscosity.is_on(); }
  MapSample sample(const MapPlace& place) const noexcept;
};

// The texture coordinates of the triangle's first corner, and their gradients, zero if it has no area. RT: set-up only.
MapPlace map_gradients(const MappedTriangle& triangle);

}  // namespace hapton
