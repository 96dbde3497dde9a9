#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/math/bv/OBBRSS.h>
#include <fcl/narrowphase/collision_object.h>
#include <fcl/narrowphase/distance.h>

#include <memory>
#include <vector>

#include "bench/peers/peer_structures.h"

namespace hapton {
namespace {

// Calls distance() between a small sphere and a mesh with a tree of OBBRSS volumes. FCL has no search radius.
class Fcl final : public QueryStructure {
  using Model = fcl::BVHModel<fcl::OBBRSS<double>>;

 public:
  Fcl(const TriangleMesh& mesh, double probe_radius)
      : probe_radius_(probe_radius), sphere_(std::make_shared<fcl::Sphere<double>>(probe_radius)) {
    std::vector<fcl::Vector3<double>> vertices(mesh.vertices.begin(), mesh.vertices.end());
    std::vector<fcl::Triangle> triangles;
    triangles.reserve(mesh.triangles.size());
    for (const auto& [a, b, c] : mesh.triangles) triangles.emplace_back(a, b, c);
    auto model = std::make_shared<Model>();
    model->beginModel(static_cast<int>(triangles.size()), static_cast<int>(vertices.size()));
    model->addSubModel(vertices, triangles);
    model->endModel();
    mesh_ = std::make_unique<fcl::CollisionObject<double>>(model);
    probe_ = std::make_unique<fcl::CollisionObject<double>>(sphere_);
  }
  double first_hit(const Vec3&, const Vec3&) override { return kNothingFound; }
  double nearest(const Vec3& p, double radius) override {
    probe_->setTranslation(p);
    probe_->computeAABB();
    const fcl::DistanceRequest<double> request(false);
    fcl::DistanceResult<double> result;
    const double distance = fcl::distance(mesh_.get(), probe_.get(), request, result) + probe_radius_;
    return distance <= radius ? distance : kNothingFound;
  }

 private:
  double probe_radius_;
  std::shared_ptr<fcl::Sphere<double>> sphere_;
  std::unique_ptr<fcl::CollisionObject<double>> mesh_;
  std::unique_ptr<fcl::CollisionObject<double>> probe_;
};

// Small compared with the mesh: FCL reports no distance for a sphere that overlaps the mesh.
double probe_radius_for(const TriangleMesh& mesh) {
  Vec3 low = mesh.vertices.front();
  Vec3 high = low;
  for (const Vec3& v : mesh.vertices) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  return 1e-7 * (high - low).maxCoeff();
}

}  // namespace

std::vector<QueryStructureKind> fcl_structures() {
  return {{.library = {},
           .name = "fcl obbrss",
           .precision = "double",
           .segments = false,
           .note = "distance() of a small sphere to the mesh, without a radius",
           .make = [](const TriangleMesh& mesh) -> Result<std::unique_ptr<QueryStructure>> {
             return std::make_unique<Fcl>(mesh, probe_radius_for(mesh));
           }}};
}

}  // namespace hapton
