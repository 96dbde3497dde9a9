#include "core/tool/contact_surface.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hapton {
namespace {

std::vector<std::shared_ptr<const SurfaceFeatures>> features_of(const TouchGeometry& scene) {
  std::vector<std::shared_ptr<const SurfaceFeatures>> features;
  for (std::uint32_t o = 0; o < scene.object_count(); ++o) {
    features.push_back(std::make_shared<const SurfaceFeatures>(scene.object_geometry(o)));
  }
  return features;
}

std::shared_ptr<const SurfaceFeatures> features_of(const std::shared_ptr<const ContactSurface>& surface) {
  return {surface, &surface->features()};
}

std::vector<std::shared_ptr<const SurfaceFeatures>> features_of(const std::vector<std::shared_ptr<const ContactSurface>>& objects) {
  std::vector<std::shared_ptr<const SurfaceFeatures>> features;
  for (const auto& object : objects) features.push_back(features_of(object));
  return features;
}

std::vector<const ObbTree*> trees_of(const std::vector<std::shared_ptr<const ContactSurface>>& objects) {
  std::vector<const ObbTree*> trees;
  for (const auto& object : objects) trees.push_back(&object->tree());
  return trees;
}

double radius_of(const ObjectGeometry& tool) {
  double squared = 0.0;
  for (const Vec3& v : tool.vertices()) squared = std::max(squared, v.squaredNorm());
  return std::sqrt(squared) * (1.0 + 0x1p-50);
}

}  // namespace

ContactSurface::ContactSurface(std::shared_ptr<const ObjectGeometry> geometry)
    : geometry_(std::move(geometry)), features_(*geometry_), tree_(*geometry_) {}

ToolSurface::ToolSurface(const ObjectGeometry& tool)
    : features(std::make_shared<const SurfaceFeatures>(tool)), tree(tool), radius(radius_of(tool)) {}

ToolSurface::ToolSurface(const std::shared_ptr<const ContactSurface>& surface, const Vec3& grip, const ObjectGeometry& tool)
    : features(features_of(surface)), tree(surface->tree().with_origin_at(grip)), radius(radius_of(tool)) {}

SceneSurface::SceneSurface(const TouchGeometry& scene) : features(features_of(scene)), tree(scene) {}

SceneSurface::SceneSurface(const std::vector<std::shared_ptr<const ContactSurface>>& objects, const TouchGeometry& scene)
    : features(features_of(objects)), tree(trees_of(objects), scene) {}

}  // namespace hapton
