#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/narrowphase/continuous_collision.h>

#include <algorithm>

#include "bench/peers/tool_peers.h"

namespace hapton {
namespace {

constexpr double kStopShortM = 1e-5;  // m; the tool stops this far before the contact that FCL finds; a free choice

using FclMesh = fcl::BVHModel<fcl::OBBRSSd>;

std::shared_ptr<FclMesh> to_fcl(const TriangleMesh& mesh) {
  std::vector<fcl::Triangle> triangles;
  for (const auto& t : mesh.triangles) triangles.emplace_back(t[0], t[1], t[2]);
  auto made = std::make_shared<FclMesh>();
  made->beginModel(static_cast<int>(triangles.size()), static_cast<int>(mesh.vertices.size()));
  made->addSubModel(mesh.vertices, triangles);
  made->endModel();
  return made;
}

class FclTool final : public SixdofMethod {
 public:
  FclTool(const SixdofScenario& scenario, const ToolCoupling& coupling)
      : coupling_(coupling), tool_(to_fcl(*scenario.tool)), scene_(to_fcl(*scenario.scene)) {
    for (const Vec3& vertex : scenario.tool->vertices) radius_m_ = std::max(radius_m_, vertex.norm());
  }

  void reset(const Pose& X_SD) override { X_SP_ = X_SD; }

  ToolOutput step(const Pose& X_SD) override {
    fcl::ContinuousCollisionRequestd request(10, 1e-4, fcl::CCDM_LINEAR, fcl::GST_LIBCCD, fcl::CCDC_CONSERVATIVE_ADVANCEMENT);
    fcl::ContinuousCollisionResultd result;
    const fcl::Transform3d still = fcl::Transform3d::Identity();
    fcl::continuousCollide(tool_.get(), fcl::Transform3d(X_SP_.matrix()), fcl::Transform3d(X_SD.matrix()), scene_.get(), still, still,
                           request, result);
    const Vec3 turn = turn_between(Quat(X_SP_.linear()), Quat(X_SD.linear()));
    // Stop before the contact: FCL reports a collision for touching bodies, in whatever direction they move.
    const double length_m = (X_SD.translation() - X_SP_.translation()).norm() + turn.norm() * radius_m_;
    const double time = result.is_collide ? std::clamp(result.time_of_contact - kStopShortM / length_m, 0.0, 1.0) : 1.0;
    X_SP_.translation() += time * (X_SD.translation() - X_SP_.translation());
    X_SP_.linear() = (turn_by(time * turn) * Quat(X_SP_.linear())).normalized().toRotationMatrix();

    ToolOutput output;
    output.contact = result.is_collide;
    output.X_WP = X_SP_;
    if (!output.contact) return output;
    output.force_n = coupling_.stiffness_n_per_m * (X_SP_.translation() - X_SD.translation());
    output.torque_nm = coupling_.rotational_stiffness_nm_per_rad * turn_between(Quat(X_SD.linear()), Quat(X_SP_.linear()));
    return output;
  }

  Placement placement(const ToolStep& exact) const override { return local_placement(exact, X_SP_); }

 private:
  ToolCoupling coupling_;
  std::shared_ptr<FclMesh> tool_;
  std::shared_ptr<FclMesh> scene_;
  double radius_m_ = 0.0;
  Pose X_SP_ = Pose::Identity();
};

}  // namespace

SixdofMethodKind fcl_tool() {
  return {.name = "fcl",
          .what = "FCL: continuous collision by conservative advancement; the tool stops at the first contact",
          .most_triangles = 200'000,
          .make = [](const SixdofScenario& scenario) -> Result<std::unique_ptr<SixdofMethod>> {
            const auto checked = ToolStep::make(*scenario.tool, {scenario.scene}, scenario.coupling);
            if (!checked) return tl::unexpected(checked.error());
            return std::make_unique<FclTool>(scenario, (*checked)->coupling());
          }};
}

}  // namespace hapton
