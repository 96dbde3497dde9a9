#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/force/common_proxy.h"
#include "core/force/touch_step.h"
#include "core/math/types.h"
#include "patch/announced_motion.h"
#include "patch/move_table.h"
#include "patch/patch_bodies.h"
#include "patch/patch_touch.h"

namespace hapton {

// Computes the force of a scene, in which objects may move, from patches of its bodies. Each body has a PatchTouch in its own frame, and
// where that is follows from the scene time alone: from its keyframes, or from the moves that are announced. So a body's patches stay valid
// while it moves, and past the edge of one the plane of the last contact moves with the body. The bodies have one proxy as in MovingMethod
// (CommonProxy): the force is that of the whole scene's method at the same scene time.
//
// Of a scene where nothing moves it is the one PatchTouch. The scene's effects are added to the force (FeltEffects).
//
// Frames: W and S as named. Units: SI. RT: all but construction. Threads: one.
class PatchChain {
 public:
  static constexpr std::size_t kLinks = PatchBody::kMaxBodies;

  PatchChain();

  // --- bodies. Before any are known the scene is one that stands still.
  // Those of the patches that come: returns what they replace. They begin where the proxy was: at the last step that was felt, or as
  // start_at() says, whichever is newer.
  std::unique_ptr<PatchBodies> take(std::unique_ptr<PatchBodies> bodies) noexcept;
  // The newest moves of commanded bodies that are known.
  void note_moves(const MoveTable& moves) noexcept;
  // Other materials from the next step on; returns what they replace.
  std::unique_ptr<PatchMaterials> take(std::unique_ptr<PatchMaterials> materials) noexcept;

  // --- each as PatchTouch has it
  std::unique_ptr<Patch> offer(std::size_t link, std::unique_ptr<Patch> patch) noexcept;
  std::unique_ptr<Patch> take_retired(std::size_t link) noexcept { return touches_[link].take_retired(); }
  bool take(std::size_t link, PatchShape& stage) noexcept { return touches_[link].take(stage); }
  void forget() noexcept;
  void set_generation(std::uint32_t generation) noexcept;
  // time_s: scene time then.
  void start_at(const Vec3& p_SP, const Vec3& outward, double age_s, double time_s) noexcept;
  bool has_arrived() const noexcept { return has_arrived_; }
  bool is_placed() const noexcept { return touches_[0].is_placed(); }

  // input.time_s: the scene time of the sample. None: as PatchTouch, for any body; or where a commanded body is, is not known.
  std::optional<PatchOutput> step(const TouchInput& input) noexcept;

  // Links in use: one for each body.
  std::size_t body_count() const noexcept { return bodies_ != nullptr ? bodies_->bodies.size() : 1; }
  bool is_in_use(std::size_t link) const noexcept { return link < body_count(); }
  // Calls visit(link) for each link that is or has been in use: in a scene that stands still, the one.
  template <class Visit>
  void for_each_link(Visit&& visit) const {
    for (std::size_t link = 0; link < most_bodies_; ++link) visit(link);
  }
  // Where the hand is for a link, in its frame, since the last step.
  PatchHandState hand_of(std::size_t link, std::int64_t time_ns, std::int64_t scene_time_ns = 0) const noexcept {
    PatchHandState hand = touches_[link].hand_at(p_OD_[link], time_ns);
    hand.scene_time_ns = scene_time_ns;
    return hand;
  }
  // X_SO of a body at a scene time.
  Pose pose_of(std::size_t body, double time_s) const noexcept;

  // Sums over the links.
  PatchTouch::Counts counts() const noexcept;
  // Moves that did not go as announced, as they came too late.
  std::uint64_t late_moves() const noexcept { return late_moves_; }

 private:
  class Felt;    // the bodies, in one sample
  class Places;  // likewise, for effects

  // A place of the proxy, frame S, at a scene time.
  struct Start {
    Vec3 p_SP = Vec3::Zero();
    Vec3 outward = Vec3::Zero();  // from the device to the proxy, unit; zero: no contact
    double time_s = 0.0;
  };

  void note_move(const ObjectMove& move) noexcept;
  bool is_ready() const noexcept;
  bool deforms(std::size_t body) const noexcept { return bodies_->bodies[body].deforms; }
  void start_new_bodies() noexcept;
  void start_body(std::size_t body, const Start& start, double age_s) noexcept;
  void note_single_proxy() noexcept;
  void note_proxy(const Vec3& p_SD, const MethodOutput& felt) noexcept;
  std::optional<PatchOutput> step_bodies(const TouchInput& input) noexcept;
  std::optional<PatchOutput> step_chain(const TouchInput& input) noexcept;

  std::vector<PatchTouch> touches_;
  std::array<Vec3, kLinks> p_OD_;  // the device of each link in the last step, in its frame
  std::array<AnnouncedMotion, PatchBody::kMaxBodies> commanded_;
  std::unique_ptr<PatchBodies> bodies_;
  std::unique_ptr<PatchMaterials> materials_;
  std::size_t most_bodies_ = 1;  // that there were at a time
  CommonProxy proxy_{kLinks, 1.0};
  std::optional<Start> start_;  // none: where the proxy is, is not known
  bool are_new_ = false;        // bodies have come that have not begun at start_ yet
  std::uint32_t generation_ = 0;
  bool has_arrived_ = false;
  std::array<bool, kLinks> has_force_ = {};  // each body, in this step
  std::array<bool, kLinks> had_force_ = {};  // and in the one before
  bool has_all_ = false;                     // in this step every link had a force
  double time_s_ = 0.0;                      // of the last step
  std::uint64_t late_moves_ = 0;
};

}  // namespace hapton
