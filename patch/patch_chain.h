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

// Computes the force of a scene, in which objects may move, from patches of its bodies. Each body has a PatchTouch in its own frame, whose
// pose follows from the scene time alone: from its keyframes, or from the moves that are announced. So a body's patches stay valid while it
// moves, and past the edge of a patch the plane of the last contact moves with the body. The bodies share one proxy as in MovingMethod
// (CommonProxy): the force is that of the whole scene's method at the same scene time.
//
// If nothing in the scene moves, only one PatchTouch computes the force. The scene's effects are added to the force (FeltEffects).
//
// Frames: W and S as named. Units: SI. RT: yes, except construction. Threads: one.
class PatchChain {
 public:
  static constexpr std::size_t kLinks = PatchBody::kMaxBodies;

  PatchChain();

  // --- bodies. Before any are known, the scene is one body that stands still.
  // Takes the bodies of the patches that come from now on; returns those that they replace. They begin where the proxy was: at the last
  // step that was felt, or as start_at() says, whichever is newer.
  std::unique_ptr<PatchBodies> take(std::unique_ptr<PatchBodies> bodies) noexcept;
  // Takes the newest known moves of commanded bodies.
  void note_moves(const MoveTable& moves) noexcept;
  // Uses these materials from the next step on; returns those that they replace.
  std::unique_ptr<PatchMaterials> take(std::unique_ptr<PatchMaterials> materials) noexcept;

  // --- these do the same as in PatchTouch: for one body where `link` is given, else for all
  std::unique_ptr<Patch> offer(std::size_t link, std::unique_ptr<Patch> patch) noexcept;
  std::unique_ptr<Patch> take_retired(std::size_t link) noexcept { return touches_[link].take_retired(); }
  bool take(std::size_t link, PatchShape& stage) noexcept { return touches_[link].take(stage); }
  void forget() noexcept;
  void set_generation(std::uint32_t generation) noexcept;
  // time_s: the scene time at which the proxy was there, age_s ago.
  void start_at(const Vec3& p_SP, const Vec3& outward, double age_s, double time_s) noexcept;
  bool has_arrived() const noexcept { return has_arrived_; }
  bool is_placed() const noexcept { return touches_[0].is_placed(); }

  // input.time_s: the scene time of the sample. None: PatchTouch has none for one of the bodies, or it is not known where all bodies are.
  std::optional<PatchOutput> step(const TouchInput& input) noexcept;

  // The number of bodies; the links in use are one for each body.
  std::size_t body_count() const noexcept { return bodies_ != nullptr ? bodies_->bodies.size() : 1; }
  bool is_in_use(std::size_t link) const noexcept { return link < body_count(); }
  // Calls visit(link) for each link that is or has been in use: only link 0 if no scene so far has moved.
  template <class Visit>
  void for_each_link(Visit&& visit) const {
    for (std::size_t link = 0; link < most_bodies_; ++link) visit(link);
  }
  // Where the hand was in the last step, in the frame of a link.
  PatchHandState hand_of(std::size_t link, std::int64_t time_ns, std::int64_t scene_time_ns = 0) const noexcept {
    PatchHandState hand = touches_[link].hand_at(p_OD_[link], time_ns);
    hand.scene_time_ns = scene_time_ns;
    return hand;
  }
  // The pose X_SO of a body at a scene time.
  Pose pose_of(std::size_t body, double time_s) const noexcept;

  // The counts of all links together.
  PatchTouch::Counts counts() const noexcept;
  // The number of moves that did not go as announced, because they came too late.
  std::uint64_t late_moves() const noexcept { return late_moves_; }

 private:
  class ChainParts;  // the bodies, in one sample
  class Places;      // likewise, for effects

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
  std::array<Vec3, kLinks> p_OD_;  // the device in the last step, in the frame of each link
  std::array<AnnouncedMotion, PatchBody::kMaxBodies> commanded_;
  std::unique_ptr<PatchBodies> bodies_;
  std::unique_ptr<PatchMaterials> materials_;
  std::size_t most_bodies_ = 1;  // the most bodies that there were at a time
  CommonProxy proxy_{kLinks, 1.0};
  std::optional<Start> start_;   // none: it is not known where the proxy is
  bool has_new_bodies_ = false;  // bodies have come that have not begun at start_ yet
  std::uint32_t generation_ = 0;
  bool has_arrived_ = false;
  std::array<bool, kLinks> has_force_ = {};  // whether each body had a force in this step
  std::array<bool, kLinks> had_force_ = {};  // and in the one before
  bool has_all_forces_ = false;              // in this step every link had a force
  double time_s_ = 0.0;                      // of the last step
  std::uint64_t late_moves_ = 0;
};

}  // namespace hapton
