#include "scene/mesh_appearance.h"

#include <algorithm>
#include <cmath>

namespace hapton {

bool MeshAppearance::has_colours_or_images() const {
  return std::any_of(triangles.begin(), triangles.end(), [&](const TriangleAppearance& triangle) {
    if (triangle.has_colours) return true;
    if (triangle.material >= materials.size()) return false;
    const VisualMaterial& material = materials[triangle.material];
    return material.colour.has_value() || material.image.has_value() || material.alpha_mode != AlphaMode::opaque;
  });
}

bool MeshAppearance::has_texcoords() const {
  return std::any_of(triangles.begin(), triangles.end(), [](const TriangleAppearance& triangle) {
    const Eigen::Vector2f a = triangle.corners[1].texcoord - triangle.corners[0].texcoord;
    const Eigen::Vector2f b = triangle.corners[2].texcoord - triangle.corners[0].texcoord;
    return a.x() * b.y() != a.y() * b.x();
  });
}

void MeshAppearance::drop_unused_images() {
  std::vector<bool> has_triangle(materials.size(), false);
  for (const TriangleAppearance& triangle : triangles) {
    if (triangle.material < materials.size()) has_triangle[triangle.material] = true;
  }
  std::vector<bool> is_used(images.size(), false);
  for (std::size_t m = 0; m < materials.size(); ++m) {
    for (std::optional<std::size_t>* image : {&materials[m].image, &materials[m].normals}) {
      if (!has_triangle[m]) image->reset();
      if (*image && **image < images.size()) is_used[**image] = true;
    }
  }
  for (std::size_t i = 0; i < images.size(); ++i) {
    if (!is_used[i]) images[i].bytes = {};
  }
}

Eigen::Vector2f texcoord_of(double right, double up) {
  constexpr double kFarthest = 1e6;
  if (!(std::abs(right) <= kFarthest && std::abs(up) <= kFarthest)) return Eigen::Vector2f::Zero();
  return Eigen::Vector2d(right, 1.0 - up).cast<float>();
}

// From linear light to sRGB (IEC 61966-2-1).
float to_srgb(double linear) {
  const double clamped = std::clamp(std::isfinite(linear) ? linear : 0.0, 0.0, 1.0);
  return static_cast<float>(clamped <= 0.0031308 ? 12.92 * clamped : 1.055 * std::pow(clamped, 1.0 / 2.4) - 0.055);
}

}  // namespace hapton
