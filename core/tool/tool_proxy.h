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
  Vec3 point = Vec3::Zero();   // on the scene's surface, local frame
  Vec3 normal = Vec3::Zero();  // unit, from the scene to the tool
  double multiplier = 0.0;     // of the constraint; times ToolStep::unit_force_n() it is the contact's force
  std::uint32_t tool_triangle = 0;
  std::uint32_t scene_triangle = 0;  // TouchGeometry's number, in the scene of the part
  int part = 0;                      // 0: what stands still; from 1: the parts that move, in the order of add_part
};

// What a step of the proxy did.
struct ToolProxyStep {
  bool is_blocked = false;   // the tool overlaps the scene since reset() placed it there: the proxy follows the device, without force
  bool converged = true;     // the proxy is as near to the device as the contacts allow; otherwise the next steps continue the motion
  bool is_squeezed = false;  // the tool has no room where a part of the scene should be: the part is kept back where there still is room
  bool is_frozen = false;    // the proxy has not moved because too many pairs are near it; it stays, whatever the device does
  int rounds = 0;
  int carries = 0;                // rounds in which parts of the scene have moved
  int haptons = 0;                // pairs in contact (a unit of the memo): local minima of the distance below 2 offsets
  std::size_t feature_count = 0;  // largest number of pairs of features in a round
};

// The 6-DOF god-object: a rigid tool that follows the device's placement and never penetrates the scene.
//
// A step moves the proxy towards the device in rounds. The first round collects the pairs of features within reach; each later one begins
// with the pairs of the last one, measured again, because these include all that the last motion came near. A round finds the motion that
// brings the proxy nearest to the device with every local minimum of the distance kept at the contact offset (Gauss' principle of least
// constraint; Ortega, Redon & Coquillart 2007, section 4), corrects it for the curvature of the rotation, and makes the part of it over
// which every pair certainly stays at its floor (kFloor; conservative advancement). The step ends when the remaining motion is below
// kConverged of the offset (see rest_radius), after kMaxRounds, or when its rounds no longer get nearer (RoundProgress).
//
// Nearest is meant in the energy of the coupling: the squared distance of the grip points plus the squared turn times turn_length^2. So at
// the local minimum the coupling's force and torque are exactly the sum of the forces and torques of frictionless contacts.
//
// Parts of the scene may move (add_part). A step first moves the parts to where they should be, and moves the tool out of their way by the
// least motion, in rounds of the same kind: the motions of tool and parts together keep every pair at its floor. Then it moves the tool
// towards the device, while the parts stand still. If the tool has no room, between a part that moves and something that does not yield,
// the part stays behind (is_squeezed), and catches up once there is room, no faster than kCatchUp allows. So a part never enters the tool,
// and the force never depends on how deep a part would have entered it.
//
// Frames: the scene's local one; the tool's mesh is in local units from its grip point, along its axes. RT: step and reset yes with
// one worker, construction set-up only. Pre: geometries and team outlive this; the scenes are built at once; 0 < turn_length.
class ToolProxy {
 public:
  // Local units; the scene's diagonal is 0.5 to 3.5 of them. So 0.5 to 2 um for a diagonal of 1 m; rounding of a distance: 2^-50.
  static constexpr double kContactOffset = 0x1p-20;
  static constexpr double kTolerance = kContactOffset * 0x1p-7;  // by which a motion may violate a bound
  static constexpr double kFloor = 0.75;                         // of the offset: floor of a pair; less where find_safe_share says so
  static constexpr double kMinGap = 0.5;                         // of the offset: least distance of a pair where the tool may be placed
  static constexpr double kConverged = 0.25;                     // of the offset: a shorter motion is not made
  static constexpr int kMaxRounds = 24;
  static constexpr int kMaxCarries = 16;    // rounds in which all parts move together, and as many again for each part that was kept back
  static constexpr double kCatchUp = 64.0;  // offsets: most that a part catches up in a step, on top of twice the travel() of the step
  static constexpr double kMinLocalReach = 64.0 * kContactOffset;  // see local_reach

  // turn_length: see above, local units. friction: of the scene's objects, only passed on to find_local_contacts; empty: none. team: shares
  // the search for contacts; steps are the same to the bit with any number of workers.
  ToolProxy(const ObjectGeometry& tool, const TouchGeometry& scene, double turn_length, std::vector<CoulombFriction> friction = {},
            WorkerTeam& team = calling_thread());
  // The same, with surfaces that were made before. Pre: they are those of this tool and this scene.
  ToolProxy(const ObjectGeometry& tool, std::shared_ptr<const ToolSurface> tool_surface, const TouchGeometry& scene,
            std::shared_ptr<const SceneSurface> scene_surface, double turn_length, std::vector<CoulombFriction> friction, WorkerTeam& team);
  // Adds a part that moves; `scene` has its objects at rest, in the same local frame. RT: set-up only. Pre: no step or reset was made yet;
  // `scene` is built at once and outlives this; the surface is that of `scene`.
  void add_part(const TouchGeometry& scene, std::shared_ptr<const SceneSurface> scene_surface, std::vector<CoulombFriction> friction = {});
  std::size_t moving_count() const { return parts_.size() - 1; }

  // Puts the tool at `device` and forgets all earlier steps: later steps do not depend on them, to the bit. If the tool overlaps the scene
  // there, or nearly touches it (kMinGap), steps are blocked until the device is at a free placement.
  // parts: pose of each part that moves, in the order of add_part, relative to the place where it was built, local frame: a point x at rest
  // goes to parts[i].at(x). If there are too few, the other parts stay.
  void reset(const Placement& device, std::span<const Placement> parts = {}) noexcept;
  ToolProxyStep step(const Placement& device, std::span<const Placement> parts = {}) noexcept;

  const Placement& placement() const { return proxy_; }
  // The pose of a part with which the tool is in contact: that of the last step's `parts`, unless is_squeezed. Pre: i < moving_count().
  const Placement& part_placement(std::size_t i) const { return parts_[i + 1]->at(); }
  // Bound of how far any part moved relative to the tool when step or reset was last given `parts`. Local units.
  double travel() const { return travel_; }
  double radius() const { return parts_[0]->near().radius(); }  // of the tool about its grip point
  // The reach for find_local_contacts; `moved`: how far device and parts have moved since the last call. At the same speed the motion until
  // the next call is within the reach, unless radius() / 64 limits it. A longer one finds contacts earlier, but the search takes longer.
  double local_reach(double moved) const { return std::min(std::max(kMinLocalReach, 2.0 * moved), radius() / 64.0); }
  // Bound of how far any part moves relative to the tool from its present target to that in `parts`. Local units.
  double travel_to(std::span<const Placement> parts) const noexcept;
  // For the fast task, until the next step: the contacts within `reach` of placement(). If they are more than LocalContacts holds: those
  // that hold the tool with the device at `device` and the parts at `parts` (contact_choice.h), and the nearest others. The bounds are for
  // part_placement(); LocalContacts::follow moves them. If surfaces that nearly fit give so many pairs that the search would take far
  // longer than a step, later calls have a shorter reach (at least kMinLocalReach); this call, too, if it finds more than kMaxFeatures.
  void find_local_contacts(const Placement& device, std::span<const Placement> parts, double reach, LocalContacts& local) noexcept;
  // The reach of the last find_local_contacts that returned contacts: the requested one, or a shorter one.
  double last_local_reach() const { return last_local_reach_; }
  // The active contacts of the last step.
  std::span<const ToolContact> contacts() const { return {contacts_.all.data(), static_cast<std::size_t>(contacts_.count)}; }

 private:
  static constexpr double kLargestTilt = 0.05;  // rad: largest `turn` for NearFeatures::collect and follow
  static constexpr double kShrinkage = 0.125;   // factor of a reach within which there are more pairs than fit

  using Parts = std::vector<std::unique_ptr<ScenePart>>;

  struct BoundPair {
    std::uint32_t part;
    std::uint32_t feature;  // index into NearFeatures::features() of the part
  };

  void set_targets(std::span<const Placement> parts) noexcept;
  // The functions of NearFeatures with the same names, for all parts.
  bool collect(const Placement& placement, double distance, double turn) noexcept;
  bool extend(const RigidMotion& motion, double distance) noexcept;
  void follow(const Placement& placement, double turn) noexcept;
  std::size_t feature_count() const noexcept;
  const NearFeature& near_of(const BoundPair& pair) const noexcept { return parts_[pair.part]->near().features()[pair.feature]; }
  // True if some pair is nearer than kMinGap, or some triangles intersect.
  bool overlaps(const Placement& placement) noexcept;
  void place(const Placement& device) noexcept;
  // Sets the curvature of energy_ to that of coupling and active contacts (sequential quadratic programming).
  void update_curvature() noexcept;
  void make_bounds() noexcept;
  RigidMotion cut_to(double reach, const RigidMotion& motion) const noexcept;
  // The motion nearest to the goal within the bounds. If they cannot all be met, `least` of each bound is lowered to part_motions_ (zero
  // for a part that does not move) where it is larger. False: no motion was found.
  bool solve(const Vec6& goal, LeastMotion& least) noexcept;
  RigidMotion constrain(const RigidMotion& wanted, double reach) noexcept;
  bool correct_bounds(const RigidMotion& motion) noexcept;
  // Adds the pairs that the motion brings together, and finds the motion again, until it crosses no added pair. False: more than fit.
  // A motion far longer than `searched_length` is likely to cross a pair early, and may come near very many later: its beginning is
  // searched first. Ends early if the tool is at rest, unless the reach is infinite.
  bool extend_until_clear(const RigidMotion& wanted, double reach, double searched_length, RigidMotion& motion) noexcept;
  bool is_at_rest() const noexcept;  // the contacts let the proxy come no nearer to the device
  // Radius for the length of a motion that is compared with kConverged: a stiff turn has a large torque where the surface hardly moves.
  double rest_radius() const noexcept { return std::max(radius(), energy_.turn_length()); }
  void count_known() noexcept;  // is_crossed ignores the features that are known now
  bool is_crossed(const RigidMotion& motion) const noexcept;
  double find_safe_share(const RigidMotion& motion) const noexcept;
  void note_contacts(ToolProxyStep& report) noexcept;
  void return_to_best() noexcept;  // to the placement nearest to the device in this step's rounds
  bool round(const Placement& device, ToolProxyStep& report) noexcept;
  // Moves the parts in [first, last) towards their targets.
  void carry(std::size_t first, std::size_t last, ToolProxyStep& report) noexcept;
  void carry_all(ToolProxyStep& report) noexcept;
  // Moves the parts that is_moving(), by at most `length` relative to the tool, and the tool out of their way. Returns the share made.
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
  Placement last_proxy_;          // the proxy before the last step
  double reach_ = 0.0;            // largest motion of a point of the tool in a round
  double searched_length_ = 0.0;  // the larger of the reach at the start of this step and the longest motion that it has made
  bool is_blocked_ = true;
  double local_reach_limit_ = 0.0;  // of the reach of find_local_contacts; 0: no limit
  double last_local_reach_ = 0.0;
  std::size_t max_followed_ = 0;     // with more pairs than this the next round calls collect
  bool follows_ = false;             // the next round calls NearFeatures::follow: this one has made the motion of its last extend
  std::vector<MotionBound> bounds_;  // of the minima of the distance
  std::vector<BoundPair> bound_pairs_;
  std::vector<double> part_motions_;       // of each bound: the part of `least` that is due to the motion of its part
  std::vector<std::size_t> known_counts_;  // by part: number of features before the last extend
  double travel_ = 0.0;                    // see travel()
  std::size_t bound_count_ = 0;
  LeastMotion least_;
  Contacts contacts_;
  Contacts best_contacts_;  // of progress_.best()
};

}  // namespace hapton
