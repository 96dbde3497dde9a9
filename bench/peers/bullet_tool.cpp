#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <btBulletDynamicsCommon.h>

#include <cmath>

#include "bench/peers/tool_peers.h"

namespace hapton {
namespace {

// Bullet's tolerances are made for bodies of 0.05 to 10 units, so a unit is a centimetre here.
constexpr double kUnitsPerM = 100.0;
constexpr double kMassKg = 0.1;  // of the tool; a free choice
constexpr double kStepS = 1e-3;
// The collision margin of each body, which keeps its surface apart from others; a free choice.
constexpr double kMarginM = 1e-4;

btVector3 to_bullet(const Vec3& v) { return {btScalar(v.x()), btScalar(v.y()), btScalar(v.z())}; }
Vec3 from_bullet(const btVector3& v) { return {v.x(), v.y(), v.z()}; }

btTransform to_bullet(const Pose& X) {
  const Quat q(X.linear());
  return btTransform(btQuaternion(btScalar(q.x()), btScalar(q.y()), btScalar(q.z()), btScalar(q.w())),
                     to_bullet(kUnitsPerM * X.translation()));
}

Pose from_bullet(const btTransform& X) {
  const btQuaternion q = X.getRotation();
  Pose made = Pose::Identity();
  made.translation() = from_bullet(X.getOrigin()) / kUnitsPerM;
  made.linear() = Quat(q.w(), q.x(), q.y(), q.z()).normalized().toRotationMatrix();
  return made;
}

std::unique_ptr<btTriangleMesh> to_bullet(const TriangleMesh& mesh) {
  auto made = std::make_unique<btTriangleMesh>(true, false);
  made->preallocateVertices(static_cast<int>(mesh.vertices.size()));
  made->preallocateIndices(static_cast<int>(3 * mesh.triangles.size()));
  for (const Vec3& vertex : mesh.vertices) made->findOrAddVertex(to_bullet(kUnitsPerM * vertex), false);
  for (const auto& triangle : mesh.triangles) {
    made->addTriangleIndices(static_cast<int>(triangle[0]), static_cast<int>(triangle[1]), static_cast<int>(triangle[2]));
  }
  return made;
}

class BulletTool final : public SixdofMethod {
 public:
  explicit BulletTool(const SixdofScenario& scenario, const ToolCoupling& coupling)
      : coupling_(coupling),
        scene_mesh_(to_bullet(*scenario.scene)),
        tool_mesh_(to_bullet(*scenario.tool)),
        scene_shape_(scene_mesh_.get(), true),
        tool_shape_(tool_mesh_.get()),
        dispatcher_(&configuration_),
        world_(&dispatcher_, &broadphase_, &solver_, &configuration_) {
    btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher_);
    world_.setGravity(btVector3(0, 0, 0));
    scene_shape_.setMargin(btScalar(kMarginM * kUnitsPerM));
    tool_shape_.setMargin(btScalar(kMarginM * kUnitsPerM));
    tool_shape_.updateBound();
    scene_body_ = std::make_unique<btRigidBody>(0, nullptr, &scene_shape_, btVector3(0, 0, 0));
    // With this inertia rotations oscillate on the coupling as fast as translations.
    const double inertia = kMassKg * coupling_.rotational_stiffness_nm_per_rad / coupling_.stiffness_n_per_m;
    const btScalar units = btScalar(inertia * kUnitsPerM * kUnitsPerM);
    tool_body_ = std::make_unique<btRigidBody>(btScalar(kMassKg), nullptr, &tool_shape_, btVector3(units, units, units));
    for (btRigidBody* body : {scene_body_.get(), tool_body_.get()}) {
      body->setFriction(0);
      body->setRestitution(0);
    }
    tool_body_->setActivationState(DISABLE_DEACTIVATION);
    world_.addRigidBody(scene_body_.get());
    world_.addRigidBody(tool_body_.get());
  }
  ~BulletTool() override {
    world_.removeRigidBody(tool_body_.get());
    world_.removeRigidBody(scene_body_.get());
  }

  void reset(const Pose& X_SD) override {
    tool_body_->setWorldTransform(to_bullet(X_SD));
    tool_body_->setLinearVelocity(btVector3(0, 0, 0));
    tool_body_->setAngularVelocity(btVector3(0, 0, 0));
    tool_body_->clearForces();
    last_X_SD_ = X_SD;
  }

  ToolOutput step(const Pose& X_SD) override {
    const Spring before = pull(X_SD);
    const Vec3 velocity = (X_SD.translation() - last_X_SD_.translation()) / kStepS;
    const Vec3 turning = turn_between(Quat(last_X_SD_.linear()), Quat(X_SD.linear())) / kStepS;
    const double damping = 2.0 * std::sqrt(coupling_.stiffness_n_per_m * kMassKg);
    const double lever2 = coupling_.rotational_stiffness_nm_per_rad / coupling_.stiffness_n_per_m;
    const Vec3 force = before.force_n + damping * (velocity - from_bullet(tool_body_->getLinearVelocity()) / kUnitsPerM);
    const Vec3 torque = before.torque_nm + damping * lever2 * (turning - from_bullet(tool_body_->getAngularVelocity()));
    tool_body_->applyCentralForce(to_bullet(kUnitsPerM * force));
    tool_body_->applyTorque(to_bullet(kUnitsPerM * kUnitsPerM * torque));
    world_.stepSimulation(btScalar(kStepS), 0);
    last_X_SD_ = X_SD;

    ToolOutput output;
    for (int i = 0; i < dispatcher_.getNumManifolds(); ++i)
      output.proxy.haptons += dispatcher_.getManifoldByIndexInternal(i)->getNumContacts();
    output.contact = output.proxy.haptons > 0;
    output.X_WP = from_bullet(tool_body_->getWorldTransform());
    if (!output.contact) return output;
    const Spring after = pull(X_SD);
    output.force_n = -after.force_n;
    output.torque_nm = -after.torque_nm;
    return output;
  }

  Placement placement(const ToolStep& exact) const override { return local_placement(exact, from_bullet(tool_body_->getWorldTransform())); }

 private:
  struct Spring {
    Vec3 force_n;
    Vec3 torque_nm;
  };
  // The coupling's force and torque on the tool, towards the device.
  Spring pull(const Pose& X_SD) const {
    const Pose X = from_bullet(tool_body_->getWorldTransform());
    return {coupling_.stiffness_n_per_m * (X_SD.translation() - X.translation()),
            coupling_.rotational_stiffness_nm_per_rad * turn_between(Quat(X.linear()), Quat(X_SD.linear()))};
  }

  ToolCoupling coupling_;
  std::unique_ptr<btTriangleMesh> scene_mesh_;
  std::unique_ptr<btTriangleMesh> tool_mesh_;
  btBvhTriangleMeshShape scene_shape_;
  btGImpactMeshShape tool_shape_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_;
  std::unique_ptr<btRigidBody> scene_body_;
  std::unique_ptr<btRigidBody> tool_body_;
  Pose last_X_SD_ = Pose::Identity();
};

}  // namespace

SixdofMethodKind bullet_tool() {
  return {.name = "bullet",
          .what = "Bullet: a body of 100 g on a critically damped spring, GImpact, steps of 1 ms, margin 0.1 mm",
          .most_triangles = 200'000,
          .make = [](const SixdofScenario& scenario) -> Result<std::unique_ptr<SixdofMethod>> {
            const auto checked = ToolStep::make(*scenario.tool, {scenario.scene}, scenario.coupling);
            if (!checked) return tl::unexpected(checked.error());
            return std::make_unique<BulletTool>(scenario, (*checked)->coupling());
          }};
}

}  // namespace hapton
