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
  // About the grip point. 0: the stiffness times the tool's mean squared lever (find_mean_squared_lever), as for springs distributed over
  // the whole surface.
  double rotational_stiffness_nm_per_rad = 0.0;
};

// One device sample and the pose of the static scene. Frame W.
struct ToolInput {
  Pose X_WD = Pose::Identity();     // of the stylus, with the grip point as its origin
  Pose X_WS = Pose::Identity();     // static scene in world (the view transform)
  std::span<const Pose> X_SO = {};  // of each part that moves: takes its points from their places at rest to where they are, frame S
  double dt_s = 0.0;                // since the last step; used only by the damping of contacts
};

// Poses of the last sample, from which the motion of the hand relative to the scene is found.
struct ToolView {
  Pose X_WD = Pose::Identity();
  Pose X_WS = Pose::Identity();
};

struct ToolOutput {
  Vec3 force_n = Vec3::Zero();    // acts on the device at the grip point, frame W
  Vec3 torque_nm = Vec3::Zero();  // about the grip point, frame W
  Pose X_WP = Pose::Identity();   // the proxy: where the tool is drawn
  bool contact = false;           // a surface holds the tool away from the device's pose
  ToolProxyStep proxy;
};

// A tool and the scene that it touches, prepared in advance (prepared_objects.h).
struct PreparedTool {
  std::shared_ptr<const ContactSurface> tool;
  Vec3 grip = Vec3::Zero();         // the grip point, local units
  Quat q_DT = Quat::Identity();     // orientation of the tool's axes, which are those of the scene, in the stylus' frame
  double mean_squared_lever = 0.0;  // m^2, see ToolCoupling
  std::vector<std::shared_ptr<const ContactSurface>> scene;
  LocalFrame frame;          // of tool and scene
  std::vector<int> part_of;  // of each object of the scene: see `parts` of ToolStep::make
};

// Two thirds of the mean squared distance of the surface from the grip point: its squared lever, averaged over all axes through it. m^2.
double find_mean_squared_lever(const TriangleMesh& tool, const Vec3& grip = Vec3::Zero());

// Lists the contacts that hold a tool, for damping. unit_force_n: force of a multiplier of 1. Returns their number. RT: yes.
std::size_t list_damping_contacts(const LocalContacts& local, const LocalContacts::Solution& solution, double unit_force_n,
                                  std::array<ContactDamping::Contact, ContactDamping::kMaxContacts>& contacts) noexcept;

// One haptic step of a rigid tool, shared by the live node, replay, tests and benches: the 6-DOF counterpart of TouchStep.
//   force  = stiffness * (p_WP - p_WD)
//   torque = rotational_stiffness * rotation vector from device to proxy * torque_share(this vector); damping adds to both (damp)
// RT: step and reset yes without a team, make set-up only.
class ToolStep {
 public:
  static constexpr int kMaxParts = 32;  // parts that move; each takes about 24 MB

  // tool: metres, from the grip point, along the stylus' axes. scene: frame S, metres, one mesh for each object. Error: a mesh without
  // triangles, numbers that are not finite, impossible stiffness or friction, a tool more than a million times as large as the scene.
  // friction: of each object of the scene; empty: none. team: shares the search for contacts; null: the calling thread does it alone.
  // parts: of each object, 0 if it stands still, otherwise the number, from 1, of the part that it moves with; empty: all stand still.
  static Result<std::unique_ptr<ToolStep>> make(const TriangleMesh& tool, std::vector<std::shared_ptr<const TriangleMesh>> scene,
                                                const ToolCoupling& coupling, std::vector<CoulombFriction> friction = {},
                                                std::unique_ptr<WorkerTeam> team = nullptr, const std::vector<int>& parts = {});

  // The same, from a tool and a scene that were prepared in advance. friction, team: as above.
  static Result<std::unique_ptr<ToolStep>> make(const PreparedTool& prepared, const ToolCoupling& coupling,
                                                std::vector<CoulombFriction> friction = {}, std::unique_ptr<WorkerTeam> team = nullptr);

  // Sets the damping of each object of the scene, in the order of make, at the tool's contacts: it adds to force and torque, and does not
  // change the proxy (contact_damping.h). Pre: no step was made yet. Error: a number that is negative or not finite. RT: set-up only.
  Result<void> damp(const std::vector<DampingCoefficients>& damping);

  // A part without a pose in the input, or with one that is not finite, stays. If X_WD or X_WS is not finite, there is no force or motion.
  ToolOutput step(const ToolInput& input) noexcept;
  void reset(const ToolInput& input) noexcept;

  // The stages of a step, for a slow and a fast task (held_tool.h). to_local: the device in the local frame. Pre of it: finite poses.
  Placement to_local(const ToolInput& input) const noexcept;
  // The poses of the parts that move, converted to the local frame. Leaves those without a finite pose as they are.
  void to_local(std::span<const Pose> X_SO, std::span<Placement> parts) const noexcept;
  // For the damping of contacts, at each sample: if X_WS changed since the last one, that does not count as a motion of the hand.
  void note_view(const ToolInput& input, ToolView& last, ContactDamping& damping) const noexcept;
  std::size_t moving_count() const { return moving_.size(); }
  // Of an object of the scene, in the order of make: 0 if it stands still, otherwise the number of the part that it moves with.
  std::size_t part_of(std::size_t object) const noexcept;
  // The rotational stiffness changes in proportion, so the proxy goes to the same poses. Threads: the one that calls felt_at. RT: yes.
  void set_stiffness(double n_per_m) noexcept;
  // Force, torque and drawn pose for these poses of device and tool. The torque is the spring's: the caller multiplies by torque_share().
  ToolOutput felt_at(const ToolInput& input, const Placement& device, const Placement& proxy) const noexcept;
  ToolProxy& proxy() { return proxy_; }

  const ToolProxy& proxy() const { return proxy_; }
  const TouchGeometry& scene() const { return scene_; }  // what stands still
  const TouchGeometry& moving(std::size_t part) const { return *moving_[part]; }
  const ObjectGeometry& tool() const { return tool_; }
  // A vertex of the tool, metres from the grip point, along the stylus' axes. Pre: made from a mesh, not from a PreparedTool.
  Vec3 vertex_m() const { return scene_.unit_m() * tool_.vertices().front(); }
  bool has_friction() const { return has_friction_; }
  const ContactDamping& damping() const { return damping_; }
  double unit_force_n() const { return coupling_.stiffness_n_per_m * scene_.unit_m(); }  // of a multiplier of 1
  const ToolCoupling& coupling() const { return coupling_; }                             // with the rotational stiffness that is used
  // A few lines for users.
  std::string describe() const;

 private:
  // Objects that stand still, or move together.
  struct Objects {
    std::vector<std::shared_ptr<const TriangleMesh>> meshes = {};
    std::vector<CoulombFriction> friction = {};
  };
  // parts[0] stands still. box: bounding box of all objects, frame S; empty if none moves.
  ToolStep(const TriangleMesh& tool, std::vector<Objects> parts, const Box& box, const ToolCoupling& coupling,
           std::unique_ptr<WorkerTeam> team);
  // Prepared objects that stand still, or move together.
  struct PreparedPart {
    std::vector<std::shared_ptr<const ContactSurface>> surfaces = {};
    std::vector<CoulombFriction> friction = {};
  };
  // parts[0] stands still.
  ToolStep(const PreparedTool& prepared, std::vector<PreparedPart> parts, const ToolCoupling& coupling, std::unique_ptr<WorkerTeam> team);
  static Result<std::unique_ptr<ToolStep>> checked(std::unique_ptr<ToolStep> step);
  ToolProxyStep follow(const Placement& device) noexcept;
  void set_damping(const std::vector<DampingCoefficients>& damping);  // of each object; objects without an entry are not damped
  void add_damping(const ToolInput& input, ToolOutput& output) noexcept;

  std::unique_ptr<WorkerTeam> team_;
  ToolCoupling coupling_;
  double squared_lever_m2_;  // rotational stiffness over stiffness of the coupling
  bool has_friction_ = false;
  std::optional<Quat> q_DT_;  // see PreparedTool; nullopt: the tool's axes are those of the stylus
  TouchGeometry scene_;
  std::vector<std::unique_ptr<TouchGeometry>> moving_;
  std::vector<Placement> parts_;  // poses of moving_ in the last step
  std::vector<int> part_of_;      // of each object; empty: all stand still
  ObjectGeometry tool_;
  ToolProxy proxy_;
  // With friction only:
  ToolFriction friction_;
  LocalContacts local_;
  LocalContacts::Solution solution_;  // of local_, in the last step
  Placement last_device_;             // of the device, in the last step
  // With damping only:
  ContactDamping damping_;
  ToolView last_view_;
};

}  // namespace hapton
