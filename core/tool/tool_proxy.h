#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/tool/least_motion.h"
#include "core/tool/local_contacts.h"
#include "core/tool/motion_energy.h"
#include "core/tool/round_progress.h"
#include "core/tool/scene_part.h"

namespace hapton {

// One active contact of the tool.
struct ToolContact {
  Vec3 point = Vec3::Zero();   // on the scene, local frame
  Vec3 normal = Vec3::Zero();  // unit, from the scene to the tool
  double multiplier = 0.0;     // of the constraint; times the stiffness it is the contact's force
  std::uint32_t tool_triangle = 0;
  std::uint32_t scene_triangle = 0;  // of the part's scene
  int part = 0;                      // 0: what stands still; others in the order of add_part
};

// What a step of the proxy did.
struct ToolProxyStep {
  bool is_blocked = false;   // the tool overlaps the scene since it was placed there; the proxy follows the device, and gives no force
  bool converged = true;     // the proxy is as near to the device as the contacts allow; otherwise the next steps continue the motion
  bool is_squeezed = false;  // the tool has no room where a part of the scene moves: it feels that part where it still has
  bool is_frozen = false;    // the proxy has not moved, as more pairs are near than it considers; so it stays, whatever the device does
  int rounds = 0;
  int carries = 0;                // rounds in which parts of the scene have moved
  int haptons = 0;                // pairs of triangles in contact (a unit of the memo, section 5)
  std::size_t feature_count = 0;  // most pairs of features in a round
};

// The 6-DOF god-object: a rigid tool that follows the device's placement and never penetrates the scene.
//
// A step moves the proxy towards the device in rounds. The first collects the pairs of features within reach, and each further one begins
// with those that the last one knew, measured anew, as all that its motion came near are among them. A round finds the motion that brings
// the proxy nearest to the device with every local minimum of the distance kept at the contact offset (Gauss' principle of least
// constraint; Ortega, Redon & Coquillart 2007, section 4), corrects it for the curvature of the rotation, and makes as much of it as
// certainly keeps every pair at kFloor of the offset, over the whole motion (conservative advancement). It ends when the motion left is
// below kConverged of the offset (rest_radius), after kMaxRounds, or when its rounds get no nearer (RoundProgress).
//
// Nearest is meant in the energy of the coupling: the squared distance of the grip points plus the squared turn times turn_length^2. At the
// end the coupling's force and torque are then exactly the sum of what frictionless contacts give.
//
// Parts of the scene may move (add_part). A step first moves them to where they should be, and the tool out of their way, by the least
// motion, in rounds of the same kind: the motions of tool and parts together keep every pair at kFloor of the offset. Then it moves the
// tool towards the device, while the parts stand still. Where the tool has no room, between a part that moves and something that does not
// yield, the part stays behind (is_squeezed), and catches up once there is room, no faster than kCatchUp allows. So a part never enters
// the tool, and the force never depends on how far one would have.
//
// Frames: the scene's local one; the tool's mesh is in local units from its grip point, along its axes. RT: step and reset yes with
// one worker, construction set-up only. Pre: geometries and team outlive this; the scene is built at once; 0 < turn_length.
class ToolProxy {
 public:
  // Local units, where the scene's diagonal is 1 to 2: 0.5 to 1 um in a scene of a metre. Far above the rounding of a distance, 2^-50.
  static constexpr double kContactOffset = 0x1p-20;
  static constexpr double kTolerance = kContactOffset * 0x1p-7;  // of a bound
  static constexpr double kFloor = 0.75;                         // of the offset: no pair comes nearer by a motion
  static constexpr double kMinGap = 0.5;                         // of the offset: where the proxy may be
  static constexpr double kConverged = 0.25;                     // of the offset
  static constexpr int kMaxRounds = 24;
  static constexpr int kMaxCarries = 16;    // rounds in which all parts move, and as many for each part that was kept back
  static constexpr double kCatchUp = 64.0;  // offsets a step, beyond twice the part's own motion
  static constexpr double kMinLocalReach = 64.0 * kContactOffset;

  // friction: of the scene's objects, for find_local_contacts; empty: none. team: shares the search for contacts; steps are the same to the
  // bit with any number of workers.
  ToolProxy(const ObjectGeometry& tool, const TouchGeometry& scene, double turn_length, std::vector<CoulombFriction> friction = {},
            WorkerTeam& team = calling_thread());
  // The same, of what was made of tool and scene before.
  ToolProxy(const ObjectGeometry& tool, std::shared_ptr<const ToolSurface> tool_surface, const TouchGeometry& scene,
            std::shared_ptr<const SceneSurface> scene_surface, double turn_length, std::vector<CoulombFriction> friction, WorkerTeam& team);
  // Another part of the scene, in the same local frame, which moves. Before the first step. RT: set-up only. Pre: the scene is built at
  // once and outlives this; the surface is of it.
  void add_part(const TouchGeometry& scene, std::shared_ptr<const SceneSurface> scene_surface, std::vector<CoulombFriction> friction = {});
  std::size_t moving_count() const { return parts_.size() - 1; }

  // Puts the tool there, as if it were new: steps from here on are the same to the bit. If it overlaps the scene, or nearly touches it,
  // steps are blocked until the device has left.
  // parts: where each part is that moves, in the order of add_part, from where it was built: where the origin of the local frame goes;
  // too few: the rest stays.
  void reset(const Placement& device, std::span<const Placement> parts = {}) noexcept;
  ToolProxyStep step(const Placement& device, std::span<const Placement> parts = {}) noexcept;

  const Placement& placement() const { return proxy_; }
  // Where the tool feels a part: where it should be, unless is_squeezed. Pre: i < moving_count().
  const Placement& part_placement(std::size_t i) const { return parts_[i + 1]->at(); }
  // How far the parts of the scene have moved past the tool from step to step, at most.
  double travel() const { return travel_; }
  double radius() const { return parts_[0]->near().radius(); }  // of the tool about its grip point
  // The reach for find_local_contacts; `moved`: how far the device has moved since the last call. At the same speed the device stays within
  // it until the next call, unless radius() / 64 limits it. A longer reach would find contacts earlier, but the search would take longer.
  double local_reach(double moved) const { return std::min(std::max(kMinLocalReach, 2.0 * moved), radius() / 64.0); }
  // How far the parts of the scene move past the tool from where they should be now, if they should be at `parts` next. Local units.
  double travel_to(std::span<const Placement> parts) const noexcept;
  // For the fast task, until the next step: what keeps the tool out within `reach` of where it is now. If that is more than fits, what
  // holds it with the device and the parts of the scene there (contact_choice.h), and the nearest. The bounds are of where the parts are
  // now: LocalContacts::follow moves them. The reach is shortened, as far as kMinLocalReach, where surfaces that nearly fit into each
  // other would give so many pairs that the search takes far longer than a step; from call to call, as the number of pairs tells.
  void find_local_contacts(const Placement& device, std::span<const Placement> parts, double reach, LocalContacts& local) noexcept;
  // Of the last find_local_contacts: the one that was asked for, or a shorter one.
  double last_local_reach() const { return last_local_reach_; }
  // Of the last step.
  std::span<const ToolContact> contacts() const { return {contacts_.all.data(), static_cast<std::size_t>(contacts_.count)}; }

 private:
  static constexpr double kLargestTilt = 0.05;  // rad: of what may become a minimum in a round
  static constexpr double kShrinkage = 0.125;   // of a reach within which there are more pairs than fit

  using Parts = std::vector<std::unique_ptr<ScenePart>>;

  struct BoundPair {
    std::uint32_t part;
    std::uint32_t feature;  // of the part's features
  };

  void set_targets(std::span<const Placement> parts) noexcept;
  // Of all parts: see NearFeatures.
  bool collect(const Placement& placement, double distance, double turn) noexcept;
  bool extend(const RigidMotion& motion, double distance) noexcept;
  void follow(const Placement& placement, double turn) noexcept;
  std::size_t feature_count() const noexcept;
  const NearFeature& near_of(const BoundPair& pair) const noexcept { return parts_[pair.part]->near().features()[pair.feature]; }
  // True if some pair is nearer than kMinGap, or some triangles intersect.
  bool overlaps(const Placement& placement) noexcept;
  void place(const Placement& device) noexcept;
  // To that of the active contacts (sequential quadratic programming).
  void update_curvature() noexcept;
  void make_bounds() noexcept;
  RigidMotion cut_to(double reach, const RigidMotion& motion) const noexcept;
  // The motion nearest to the goal within the bounds; those that cannot all be met are lowered to zero, or what a part's motion asks for.
  // False: none was found.
  bool solve(const Vec6& goal, LeastMotion& least) noexcept;
  RigidMotion constrain(const RigidMotion& wanted, double reach) noexcept;
  bool correct_bounds(const RigidMotion& motion) noexcept;
  // Adds the pairs that the motion brings together, and finds it again, until it crosses none. False if there are more than fit.
  // A motion far longer than `tried` is likely to cross one early, and may come near very many later on: its beginning is searched first.
  // Ends early if the tool is at rest, unless the reach is infinite.
  bool extend_until_clear(const RigidMotion& wanted, double reach, double tried, RigidMotion& motion) noexcept;
  bool is_at_rest() const noexcept;  // the contacts let the proxy get no nearer to the device
  // At which a motion is measured against kConverged: a stiff turn has a large torque where the surface hardly moves.
  double rest_radius() const noexcept { return std::max(radius(), energy_.turn_length()); }
  void note_known() noexcept;  // the features that is_crossed leaves out
  bool is_crossed(const RigidMotion& motion) const noexcept;
  double find_safe_share(const RigidMotion& motion) const noexcept;
  void note_contacts(ToolProxyStep& report) noexcept;
  void return_to_best() noexcept;  // of this step's rounds
  bool round(const Placement& device, ToolProxyStep& report) noexcept;
  // Moves the parts from `first` on, before `last`, to their targets.
  void carry(std::size_t first, std::size_t last, ToolProxyStep& report) noexcept;
  void carry_all(ToolProxyStep& report) noexcept;
  // Moves the parts that are aimed, no farther than `length` past the tool, and it out of their way. Returns the share that was made.
  double carry_round(double length) noexcept;
  bool find_push(RigidMotion& motion) noexcept;  // false: there is no room
  void limit_local_reach() noexcept;
  void find_minima() noexcept;
  MotionBound local_bound(const BoundPair& pair) const noexcept;
  LocalContact local_contact(const BoundPair& pair) const noexcept;
  void choose_local_contacts(const Placement& device, std::span<const Placement> parts, double reach, LocalContacts& local) noexcept;
  bool is_squeezed_by(const RigidMotion& motion) const noexcept;

  struct Contacts {
    std::array<ToolContact, 6> all;
    int count = 0;
  };

  MotionEnergy energy_;
  RoundProgress progress_;
  WorkerTeam* team_;
  Parts parts_;  // the first stands still, the others move
  Placement proxy_;
  Placement last_;      // the proxy before the last step
  double reach_ = 0.0;  // no point of the tool moves farther in a round
  double tried_ = 0.0;  // the reach that this step began with, or the longest motion that it has made
  bool is_blocked_ = true;
  double local_limit_ = 0.0;  // of the reach for local contacts; 0: none
  double last_local_reach_ = 0.0;
  std::size_t most_followed_ = 0;    // with more pairs the next round searches again
  bool follows_ = false;             // the next round begins with the pairs of this one, which has made the motion of the last extend
  std::vector<MotionBound> bounds_;  // of the minima of the distance
  std::vector<BoundPair> bound_pairs_;
  std::vector<double> yields_;      // of each bound: what it asks for as its part moves
  std::vector<std::size_t> known_;  // by part: features that were there before the last extend
  double travel_ = 0.0;             // past the tool, of where a part should be, since the step before
  std::size_t bound_count_ = 0;
  LeastMotion least_;
  Contacts contacts_;
  Contacts best_contacts_;  // of progress_.best()
};

}  // namespace hapton
