#include "core/effects/surface_maps.h"

#include <algorithm>
#include <cmath>

namespace hapton {

ImageMap::Value ImageMap::at(const MapPlace& place) const noexcept {
  const SurfaceImage::Sample sample = image->sample(place.texcoord.x(), place.texcoord.y());
  const double range = at_white - at_black;
  return {at_black + range * sample.value, range * (sample.gradient.x() * place.du + sample.gradient.y() * place.dv)};
}

double ImageMap::steepest(const std::vector<MappedTriangle>& triangles) const {
  const Eigen::Vector2d slope = std::abs(at_white - at_black) * image->steepest();
  double most = 0.0;
  for (const MappedTriangle& triangle : triangles) {
    const MapPlace place = map_gradients(triangle);
    // The largest of |a du + b dv| over |a| <= slope.x, |b| <= slope.y is at a corner.
    const Vec3 along_u = slope.x() * place.du;
    const Vec3 along_v = slope.y() * place.dv;
    most = std::max({most, (along_u + along_v).norm(), (along_u - along_v).norm()});
  }
  return most;
}

MapSample SurfaceMaps::sample(const MapPlace& place) const noexcept {
  MapSample sample;
  if (height.is_on()) {
    const ImageMap::Value value = height.at(place);
    sample.height_m = value.number;
    sample.height_gradient = value.gradient;
  }
  if (stiffness.is_on()) {
    const ImageMap::Value value = stiffness.at(place);
    sample.stiffness = value.number;
    sample.stiffness_gradient = value.gradient;
  }
  if (friction.is_on()) sample.friction = friction.at(place).number;
  if (viscosity.is_on()) sample.viscosity_ns_per_m = viscosity.at(place).number;
  return sample;
}

// With edges e1, e2 and their normal m, the gradient of a linear function with the differences d1, d2 along the edges is g = (d1 e2 - d2
// e1) x m / |m|^2: g . e1 = d1 and g . e2 = d2.
MapPlace map_gradients(const MappedTriangle& triangle) {
  const Vec3 e1 = triangle.corner[1] - triangle.corner[0];
  const Vec3 e2 = triangle.corner[2] - triangle.corner[0];
  const Vec3 m = e1.cross(e2);
  const double area_squared = m.squaredNorm();
  MapPlace place;
  place.texcoord = triangle.texcoord[0];
  const Eigen::Vector2d d1 = triangle.texcoord[1] - triangle.texcoord[0];
  const Eigen::Vector2d d2 = triangle.texcoord[2] - triangle.texcoord[0];
  place.du = (d1.x() * e2 - d2.x() * e1).cross(m) / area_squared;
  place.dv = (d1.y() * e2 - d2.y() * e1).cross(m) / area_squared;
  // Without an area there is no gradient.
  if (!place.du.allFinite() || !place.dv.allFinite()) place.du = place.dv = Vec3::Zero();
  return place;
}

}  // namespace hapton
