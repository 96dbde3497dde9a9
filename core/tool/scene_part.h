#pragma once

#include <memory>
#include <vector>

#include "core/tool/local_contacts.h"
#include "core/tool/near_features.h"
#include "core/tool/placement.h"

namespace hapton {

// Objects of the scene that stand still, or move together, with their features that are near the tool. A part that moves has its own frame,
// which moves with it: the part is built once in that frame, and the tool moves in it. If part and tool both move, the tool's motion in
// that frame is approximated by a RigidMotion. Frame: the scene's local one unless stated otherwise. RT: all but construction.
class ScenePart {
 public:
  // friction: by object; empty: none. Pre: all objects of `scene` belong to the part; tool, scene and team outlive this; the surfaces are
  // those of tool and scene.
  ScenePart(const ObjectGeometry& tool, std::shared_ptr<const ToolSurface> tool_surface, const TouchGeometry& scene,
            std::shared_ptr<const SceneSurface> scene_surface, std::vector<CoulombFriction> friction, WorkerTeam& team);
  // A part that moves, in contact with the tool of `first`. `scene` has the part's objects, in their places at rest. Pre: as above.
  ScenePart(const ScenePart& first, const TouchGeometry& scene, std::shared_ptr<const SceneSurface> scene_surface,
            std::vector<CoulombFriction> friction, WorkerTeam& team);

  NearFeatures& near() { return near_; }
  const NearFeatures& near() const { return near_; }
  CoulombFriction friction_of(std::uint32_t object) const noexcept;

  // The pose of the part's frame with which the tool is in contact; at rest it is the identity: the local frame.
  const Placement& at() const { return at_; }
  // The pose that the part should have. at() differs from it only during a step, and while the tool keeps the part back.
  const Placement& target() const { return target_; }
  void set_target(const Placement& target) noexcept { target_ = target; }
  bool is_arrived() const noexcept { return !moves_ || at_ == target_; }
  // Sets at() to target() at once.
  void put_at_target() noexcept;

  // Begins a motion of the part: until advance() or stay(), motions are of tool and part together.
  void aim(double share) noexcept;  // to this share of the path from at() to target()
  // Moves the part, too, after the tool has moved to `tool` by this share of `motion`, and ends the part's motion.
  void advance(const RigidMotion& motion, double share, const Placement& tool) noexcept;
  void stay() noexcept { is_moving_ = false; }
  bool is_moving() const { return is_moving_; }

  // Placement, motion and end of the motion of the tool, converted to the part's frame. While is_moving(): relative to the moving part.
  Placement in_part_frame(const Placement& tool) const noexcept { return moves_ ? at_.inverse() * tool : tool; }
  RigidMotion in_part_frame(const RigidMotion& motion) const noexcept;
  Placement end_in_part_frame(const RigidMotion& motion) const noexcept;

  // Conversions from the part's frame (identities if it stands still).
  bool moves() const { return moves_; }
  Vec3 direction(const Vec3& in_part) const noexcept { return moves_ ? Vec3(turn_ * in_part) : in_part; }
  Vec3 point(const Vec3& in_part) const noexcept { return moves_ ? at_.at(in_part) : in_part; }
  Mat6 curvature(const Mat6& in_part) const noexcept;

 private:
  void put_at(const Placement& at) noexcept;

  NearFeatures near_;
  std::vector<CoulombFriction> friction_;
  bool moves_ = false;
  bool is_moving_ = false;
  Placement at_;
  Placement target_;
  Placement next_;                // at() at the end of the motion
  Mat3 turn_ = Mat3::Identity();  // orientation of at_
};

}  // namespace hapton
