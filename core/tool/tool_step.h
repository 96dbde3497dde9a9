#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/base/result.h"
#include "core/base/worker_team.h"
#include "core/tool/contact_damping.h"
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
  Pose X_WD = Pose::Identity();     // grip point and orientation of the stylus
  Pose X_WS = Pose::Identity();     // static scene in world (the view transform)
  std::span<const Pose> X_SO = {};  // of each part of the scene that moves: what its points at rest are moved by, frame S
  double dt_s = 0.0;                // since the step before; only damping of contacts needs it
};

// Of the last sample, for what depends on the motion of the hand past the scene.
struct ToolView {
  Pose X_WD = Pose::Identity();
  Pose X_WS = Pose::Identity();
};

struct ToolOutput {
  Vec3 force_n = Vec3::Zero();    // acts on the device at the grip point, frame W
  Vec3 torque_nm = Vec3::Zero();  // about the grip point, frame W
  Pose X_WP = Pose::Identity();   // the proxy: where the tool is drawn
  bool contact = false;           // the tool is held by a surface
  ToolProxyStep proxy;
};

// A tool and the scene that it touches, prepared before (prepared_objects.h).
struct PreparedTool {
  std::shared_ptr<const ContactSurface> tool;
  Vec3 grip = Vec3::Zero();         // the grip point, local units
  Quat q_DT = Quat::Identity();     // of the tool's axes, which are those of the scene, in the stylus
  double mean_squared_lever = 0.0;  // m^2, see ToolCoupling
  std::vector<std::shared_ptr<const ContactSurface>> scene;
  LocalFrame frame;          // of tool and scene
  std::vector<int> part_of;  // of each object of the scene, as ToolStep::make has parts
};

// Two thirds of the mean squared distance of the surface from the grip point: the mean squared lever about an axis through it. m^2.
double find_mean_squared_lever(const TriangleMesh& tool, const Vec3& grip = Vec3::Zero());

// The contacts that hold a tool, for damping. unit_force_n: of a multiplier of 1. Returns how many. RT: yes.
std::size_t list_drag_contacts(const LocalContacts& local, const LocalContacts::Solution& solution, double unit_force_n,
                               std::array<ContactDamping::Contact, ContactDamping::kMaxContacts>& contacts) noexcept;

// One haptic step of a rigid tool, shared by the live node, replay, tests and benches: the 6-DOF counterpart of TouchStep.
//   force  = stiffness * (p_WP - p_WD)
//   torque = rotational_stiffness * rotation vector from device to proxy
// RT: step and reset yes without a team, make set-up only.
class ToolStep {
 public:
  static constexpr int kMaxParts = 32;  // that move; each takes about 24 MB

  // tool: metres, from the grip point, along the stylus' axes. scene: frame S, metres, one mesh for each object. Error: a mesh without
  // triangles, numbers that are not finite, impossible stiffness or friction, a tool more than a million times as large as the scene.
  // friction: of each object of the scene; empty: none. team: shares the search for contacts; null: the calling thread does it alone.
  // parts: of each object, 0 where it stands still, else the number of the part that it moves with, from 1; empty: all stand still.
  static Result<std::unique_ptr<ToolStep>> make(const TriangleMesh& tool, std::vector<std::shared_ptr<const TriangleMesh>> scene,
                                                const ToolCoupling& coupling, std::vector<CoulombFriction> friction = {},
                                                std::unique_ptr<WorkerTeam> team = nullptr, const std::vector<int>& parts = {});

  // Of what was prepared before. friction: as above.
  static Result<std::unique_ptr<ToolStep>> make(const PreparedTool& prepared, const ToolCoupling& coupling,
                                                std::vector<CoulombFriction> friction = {}, std::unique_ptr<WorkerTeam> team = nullptr);

  // Damping of each object of the scene, in the order of make, at the contacts of the tool: adds to force and torque, and leaves the proxy
  // as it is (contact_damping.h). Before the first step. Error: a number that is negative or not finite. RT: set-up only.
  Result<void> damp(const std::vector<DampingCoefficients>& damping);

  // A part without a pose in the input, or with one that is not finite, stays where it was.
  ToolOutput step(const ToolInput& input) noexcept;
  void reset(const ToolInput& input) noexcept;

  // The parts of a step, for a slow and a fast task (held_tool.h). Pre of to_local: finite.
  Placement to_local(const ToolInput& input) const noexcept;
  // Of the parts that move: where the origin of the local frame goes.
  void to_local(std::span<const Pose> X_SO, std::span<Placement> parts) const noexcept;
  // For the drag of contacts, at each sample: where the scene was moved since the last one, that is not a motion of the hand.
  void note_view(const ToolInput& input, ToolView& last, ContactDamping& drag) const noexcept;
  std::size_t moving_count() const { return moving_.size(); }
  // Of an object that it was made of: 0 where it stands still, else the number of the part that it moves with.
  std::size_t part_of(std::size_t object) const noexcept;
  // The rotational stiffness changes in proportion, so the proxy goes to the same poses. Threads: the one of felt_at. RT: yes.
  void set_stiffness(double n_per_m) noexcept;
  // Force, torque and drawn pose for these poses of device and tool. The torque is that of the spring, of which torque_share() is felt.
  ToolOutput felt_at(const ToolInput& input, const Placement& device, const Placement& proxy) const noexcept;
  ToolProxy& proxy() { return proxy_; }

  const ToolProxy& proxy() const { return proxy_; }
  const TouchGeometry& scene() const { return scene_; }  // what stands still
  const TouchGeometry& moving(std::size_t part) const { return *moving_[part]; }
  const ObjectGeometry& tool() const { return tool_; }
  // A vertex of the tool, metres from the grip point, along the stylus' axes. Pre: made of a mesh.
  Vec3 vertex_m() const { return scene_.unit_m() * tool_.vertices().front(); }
  bool has_friction() const { return has_friction_; }
  const ContactDamping& drag() const { return drag_; }
  double unit_force_n() const { return coupling_.stiffness_n_per_m * scene_.unit_m(); }  // of a multiplier
  const ToolCoupling& coupling() const { return coupling_; }                             // with the rotational stiffness that is used
  // A few lines for users.
  std::string describe() const;

 private:
  // Objects that stand still, or move together.
  struct Objects {
    std::vector<std::shared_ptr<const TriangleMesh>> meshes = {};
    std::vector<CoulombFriction> friction = {};
  };
  // The first stand still. box: of all; empty: none of them moves.
  ToolStep(const TriangleMesh& tool, std::vector<Objects> parts, const Box& box, const ToolCoupling& coupling,
           std::unique_ptr<WorkerTeam> team);
  // Prepared objects that stand still, or move together.
  struct PreparedPart {
    std::vector<std::shared_ptr<const ContactSurface>> surfaces = {};
    std::vector<CoulombFriction> friction = {};
  };
  // The first stand still.
  ToolStep(const PreparedTool& prepared, std::vector<PreparedPart> parts, const ToolCoupling& coupling, std::unique_ptr<WorkerTeam> team);
  static Result<std::unique_ptr<ToolStep>> checked(std::unique_ptr<ToolStep> step);
  ToolProxyStep follow(const Placement& device) noexcept;
  void set_drag(const std::vector<DampingCoefficients>& damping);  // of each object; what is missing is not damped
  void add_drag(const ToolInput& input, ToolOutput& output) noexcept;

  std::unique_ptr<WorkerTeam> team_;
  ToolCoupling coupling_;
  double squared_lever_m2_;  // of the coupling: rotational stiffness over stiffness
  bool has_friction_ = false;
  std::optional<Quat> q_DT_;  // of the tool's axes in the stylus; none: they are the same
  TouchGeometry scene_;
  std::vector<std::unique_ptr<TouchGeometry>> moving_;
  std::vector<Placement> parts_;  // of these, at the last step
  std::vector<int> part_of_;      // of each object; empty: all stand still
  ObjectGeometry tool_;
  ToolProxy proxy_;
  // With friction only:
  ToolFriction friction_;
  LocalContacts local_;
  LocalContacts::Solution solution_;  // by these
  Placement last_;                    // device
  // With damping only:
  ContactDamping drag_;
  ToolView last_view_;
};

}  // namespace hapton
