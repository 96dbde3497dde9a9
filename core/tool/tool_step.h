#pragma once

#include <memory>
#include <vector>

#include "core/base/result.h"
#include "core/base/worker_team.h"
#include "core/tool/tool_friction.h"
#include "core/tool/tool_proxy.h"

namespace hapton {

// The spring between device and proxy of a rigid tool.
struct ToolCoupling {
  double stiffness_n_per_m = 1000.0;
  // About the grip point. 0: the stiffness times the tool's mean squared lever about any axis through the grip point (two thirds of the
  // mean squared distance of its surface), as for springs distributed over the whole surface.
  double rotational_stiffness_nm_per_rad = 0.0;
};

// One device sample and the pose of the static scene. Frame W.
struct ToolInput {
  Pose X_WD = Pose::Identity();  // grip point and orientation of the stylus
  Pose X_WS = Pose::Identity();  // static scene in world (the view transform)
};

struct ToolOutput {
  Vec3 force_n = Vec3::Zero();    // acts on the device at the grip point, frame W
  Vec3 torque_nm = Vec3::Zero();  // about the grip point, frame W
  Pose X_WP = Pose::Identity();   // the proxy: where the tool is drawn
  bool contact = false;           // the tool is held by a surface
  ToolProxyStep proxy;
};

// One haptic step of a rigid tool, shared by the live node, replay, tests and benches: the 6-DOF counterpart of TouchStep.
//   force  = stiffness * (p_WP - p_WD)
//   torque = rotational_stiffness * rotation vector from device to proxy
// RT: step and reset yes without a team, make set-up only.
class ToolStep {
 public:
  // tool: metres, from the grip point, along the stylus' axes. scene: frame S, metres, one mesh for each object. Error: a mesh without
  // triangles, numbers that are not finite, impossible stiffness or friction, a tool more than a million times as large as the scene.
  // friction: of each object of the scene; empty: none. team: shares the search for contacts; null: the calling thread does it alone.
  static Result<std::unique_ptr<ToolStep>> make(const TriangleMesh& tool, std::vector<std::shared_ptr<const TriangleMesh>> scene,
                                                const ToolCoupling& coupling, std::vector<SurfaceFriction> friction = {},
                                                std::unique_ptr<WorkerTeam> team = nullptr);

  ToolOutput step(const ToolInput& input) noexcept;
  void reset(const ToolInput& input) noexcept;

  // The parts of a step, for a slow and a fast task (held_tool.h). Pre of to_local: finite.
  Placement to_local(const ToolInput& input) const noexcept;
  // Force, torque and drawn pose for these poses of device and tool.
  ToolOutput felt_at(const ToolInput& input, const Placement& device, const Placement& proxy) const noexcept;
  ToolProxy& proxy() { return proxy_; }

  const ToolProxy& proxy() const { return proxy_; }
  const TouchGeometry& scene() const { return scene_; }
  const ObjectGeometry& tool() const { return tool_; }
  bool has_friction() const { return has_friction_; }
  const ToolCoupling& coupling() const { return coupling_; }  // with the rotational stiffness that is used
  // A few lines for users.
  std::string describe() const;

 private:
  ToolStep(const TriangleMesh& tool, std::vector<std::shared_ptr<const TriangleMesh>> scene, const ToolCoupling& coupling,
           std::vector<SurfaceFriction> friction, std::unique_ptr<WorkerTeam> team);
  ToolProxyStep follow(const Placement& device) noexcept;

  std::unique_ptr<WorkerTeam> team_;
  ToolCoupling coupling_;
  bool has_friction_ = false;
  TouchGeometry scene_;
  ObjectGeometry tool_;
  ToolProxy proxy_;
  // With friction only:
  ToolFriction friction_;
  LocalContacts local_;
  Placement last_;  // device
};

}  // namespace hapton
