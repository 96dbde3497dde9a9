#include "vision_node/deformed_mesh.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "scene/annotations.h"

namespace hapton {
namespace {

// Most anchors that are kept: one for each point of all annotations, and as many for points that were replaced while a stroke was drawn.
constexpr std::size_t kMaxAnchors = 2 * kMaxAnnotationPoints;

}  // namespace

DeformedMesh::DeformedMesh(std::shared_ptr<const TriangleMesh> rest, std::shared_ptr<const MeshDeformation> deformation)
    : rest_(std::move(rest)), deformation_(std::move(deformation)) {}

DeformedMesh::DeformedMesh(std::shared_ptr<const TriangleMesh> rest, FindVertices find)
    : rest_(std::move(rest)), find_vertices_(std::move(find)), are_vertices_outdated_(true), vertices_(rest_->vertices) {}

bool DeformedMesh::set_time(double time_s) {
  return deformation_ != nullptr && std::exchange(weights_, deformation_->weights_at(time_s)) != weights_;
}

const SurfaceFinder& DeformedMesh::finder() const {
  if (finder_ == nullptr) finder_ = std::make_unique<SurfaceFinder>(rest_);
  return *finder_;
}

const std::vector<Vec3>& DeformedMesh::vertices() const {
  if (deformation_ == nullptr) {
    if (!std::exchange(are_vertices_outdated_, false)) return vertices_;
    if (auto found = find_vertices_()) vertices_ = std::move(*found);
    return vertices_;
  }
  if (vertices_weights_ != weights_) {
    vertices_ = deformation_->vertices_at(rest_->vertices, weights_);
    vertices_weights_ = weights_;
  }
  return vertices_;
}

Vec3 DeformedMesh::interpolate(const std::vector<Vec3>& vertices, std::uint32_t triangle, const Vec3& barycentric) const {
  Vec3 p = Vec3::Zero();
  for (std::size_t k = 0; k < 3; ++k) {
    p += barycentric[static_cast<Eigen::Index>(k)] * vertices[static_cast<std::size_t>(rest_->triangles[triangle][k])];
  }
  return p;
}

double DeformedMesh::most_displacement() const {
  if (deformation_ != nullptr) return deformation_->most_displacement(weights_, {});
  double most_squared = 0.0;
  for (std::size_t v = 0; v < vertices().size(); ++v) {
    most_squared = std::max(most_squared, (vertices_[v] - rest_->vertices[v]).squaredNorm());
  }
  return std::sqrt(most_squared);
}

DeformedMesh::TouchedPoint DeformedMesh::find_closest(const Vec3& p) const {
  const SurfaceFinder::SurfacePoint found = finder().find_closest(p, vertices(), most_displacement());
  return {interpolate(rest_->vertices, found.triangle, found.barycentric), found.triangle};
}

const DeformedMesh::Anchor& DeformedMesh::find_anchor(const Vec3& p_rest) const {
  if (anchors_.size() >= kMaxAnchors) anchors_.clear();
  const auto [at, is_new] = anchors_.try_emplace({p_rest.x(), p_rest.y(), p_rest.z()});
  if (is_new) {
    const SurfaceFinder::SurfacePoint found = finder().find_closest(p_rest);
    at->second = {found.triangle, found.barycentric};
  }
  return at->second;
}

Vec3 DeformedMesh::place(const Vec3& p_rest) const {
  const Anchor& anchor = find_anchor(p_rest);
  return interpolate(vertices(), anchor.triangle, anchor.barycentric);
}

}  // namespace hapton
