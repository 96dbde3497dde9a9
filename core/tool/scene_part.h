#pragma once

#include <memory>
#include <vector>

#include "core/tool/local_contacts.h"
#include "core/tool/near_features.h"
#include "core/tool/placement.h"

namespace hapton {

// Objects of the scene that stand still, or move together, and what of them is near the tool. A part that moves has a frame that moves
// along, in which it is built once and the tool moves; where both move, the motion of the tool in that frame is taken as straight
// (RigidMotion). Frame: the scene's local one, where nothing else is said. RT: all but construction.
class ScenePart {
 public:
  // friction: by object; empty: none. Pre: the scene, all of whose objects are the part's, outlives this; the surfaces are of tool and
  // scene.
  ScenePart(const ObjectGeometry& tool, std::shared_ptr<const ToolSurface> tool_surface, const TouchGeometry& scene,
            std::shared_ptr<const SceneSurface> scene_surface, std::vector<CoulombFriction> friction, WorkerTeam& team);
  // Another part of the same scene, which moves, and is at rest where it was built.
  ScenePart(const ScenePart& first, const TouchGeometry& scene, std::shared_ptr<const SceneSurface> scene_surface,
            std::vector<CoulombFriction> friction, WorkerTeam& team);

  NearFeatures& near() { return near_; }
  const NearFeatures& near() const { return near_; }
  CoulombFriction friction_of(std::uint32_t object) const noexcept;

  // Where the part is for the tool. The origin of the local frame is the part's, too.
  const Placement& at() const { return at_; }
  // Where it should be. It is elsewhere only during a step, and where the tool keeps it back.
  const Placement& target() const { return target_; }
  void set_target(const Placement& target) noexcept { target_ = target; }
  bool is_arrived() const noexcept { return !moves_ || at_ == target_; }
  // Puts it there at once.
  void put_at_target() noexcept;

  // The next motions are of tool and part: until arrive(), or stay().
  void aim(double share) noexcept;  // at a share of its path to its target
  // Once the tool has moved to `tool`, by the share of `motion` over which both stay apart.
  void advance(const RigidMotion& motion, double share, const Placement& tool) noexcept;
  void stay() noexcept { is_moving_ = false; }
  bool is_moving() const { return is_moving_; }

  // Of the tool in the part's frame.
  Placement own(const Placement& tool) const noexcept { return moves_ ? at_.inverse() * tool : tool; }
  RigidMotion own(const RigidMotion& motion) const noexcept;
  Placement own_end(const RigidMotion& motion) const noexcept;

  // From the part's frame.
  bool moves() const { return moves_; }
  Vec3 direction(const Vec3& own) const noexcept { return moves_ ? Vec3(turn_ * own) : own; }
  Vec3 point(const Vec3& own) const noexcept { return moves_ ? at_.at(own) : own; }
  Mat6 curvature(const Mat6& own) const noexcept;

 private:
  void put_at(const Placement& at) noexcept;

  NearFeatures near_;
  std::vector<CoulombFriction> friction_;
  bool moves_ = false;
  bool is_moving_ = false;
  Placement at_;
  Placement target_;
  Placement next_;  // where it is at the end of the motion
  Mat3 turn_ = Mat3::Identity();
};

}  // namespace hapton
