#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/base/mailbox.h"
#include "core/tool/held_tool.h"
#include "link/messages.h"

namespace hapton {

// A request of the step to the slow task.
struct GraspOrder {
  enum class Kind : std::uint8_t { pick_up, let_go, put_down };

  std::uint32_t serial = 0;  // counts orders, from 1
  Kind kind = Kind::let_go;
  int object = -1;                // of the scene
  Pose X_SD = Pose::Identity();   // pick_up: the stylus when the object was picked up
  Pose moved = Pose::Identity();  // of the object, frame S: the transform of its points from where the scene file places them
};

// The reply of the slow task: the tool of a pick_up, which the step holds until its next order. Null: there is none; the log says why.
struct GraspReply {
  std::uint32_t serial = 0;  // of the order
  HeldTool* tool = nullptr;
  HapticsSetup::Text method = {};  // as HapticsSetup has it
};

// What is said of a scene in which an object was put down. It is known some time after the scene is felt, as it takes the longer the larger
// the scene is.
struct PlacedScene {
  std::uint32_t revision = 0;  // NewScene::revision
  std::uint64_t hash = 0;      // hash_scene
  SceneFacts facts;
};

// Between the step and the slow task. RT: yes. Threads: one on each side.
struct GraspLink {
  Mailbox<GraspOrder> orders;
  Mailbox<GraspReply> replies;
  Mailbox<PlacedScene> placed;
};

// The step's side of picking up movable objects. If a button of the stylus is pressed while a movable object is touched, that object
// becomes the tool that the stylus holds, and collides with all others. When the button is released, the object stays where it is, and can
// be touched there as soon as the slow task has built the scene again. A hand that has gone more than kResumeReachM from where it pressed
// the button before the object could be picked up leaves it where it is. RT: yes. Threads: the step's.
class Grasp {
 public:
  // movable: by object. buttons: one of these picks up.
  Grasp(GraspLink& link, const std::vector<bool>& movable, std::uint32_t buttons);

  // An object lies elsewhere at the start: X_SO. Set-up only. Pre: of the scene, and movable.
  void place(int object, const Pose& X_SO);

  // Requests to move an object from its pose of that serial to this one. update() does so, unless an object is being picked up, held or put
  // down, the serial is not the object's newest, or the object is not movable: then it ignores the request, and the sender repeats it.
  void request(const ObjectPose& pose) noexcept { requested_ = pose; }

  // Whether an object may leave its place at the next update(): nobody else computes forces with it there. Otherwise what is to be picked
  // up, and what is requested, wait. In the beginning they may.
  void set_free(bool is_free) noexcept { is_free_ = is_free; }
  // An object is to leave its place, or is not felt yet where it was put down, as far as the slow task has replied. is_early: also while it
  // is not certain that it can be picked up.
  bool is_leaving(bool is_early) noexcept;

  enum class Change : std::uint8_t {
    none,
    picked_up,
    put_down,
    returned  // it could not be put down: the object is where it was before, and the scene is the one before
  };
  // Before the force of a sample. touched: the object in contact at the sample before, -1: none. visual_offset_m: of that sample, frame W.
  Change update(const DeviceState& state, const Pose& X_WS, int touched, const Vec3& visual_offset_m) noexcept;
  // In place of update() where no sample was before: what is touched is not known yet. Everything waits for the next sample, also a button
  // that is pressed in this one.
  void wait_a_sample(const DeviceState& state) noexcept;

  // What the stylus holds; null: nothing.
  HeldTool* tool() const noexcept { return tool_; }
  int object() const noexcept { return order_.object; }
  // Of what the stylus holds, as HapticsSetup has it.
  const HapticsSetup::Text& method() const noexcept { return link_.replies.value().method; }
  // After each step of the tool: where it is drawn.
  void note_pose(const Pose& X_WP, const Pose& X_WS) noexcept;

  // An object has been put down, and the scene is not built again yet: there is no force.
  bool is_waiting() const noexcept { return phase_ == Phase::waiting; }
  // An object is picked up, held or put down: no other method may come into use.
  bool is_busy() const noexcept { return phase_ != Phase::idle; }
  // The scene was built for that order: the next method starts where the stylus touches the object.
  void note_built(std::uint32_t serial) noexcept;
  // Once after note_built, or Change::returned: in frame W, where the probe was on the object as it was picked up, and the direction off
  // its surface.
  struct Start {
    Vec3 p_W = Vec3::Zero();
    Vec3 outward = Vec3::Zero();
  };
  std::optional<Start> take_start(const Pose& X_WS) noexcept;

  // Once for each scene; stays until the next one. Null: there is no new one.
  const PlacedScene* take_placed() noexcept { return link_.placed.take() ? &link_.placed.value() : nullptr; }

  // By object; a serial of 0: it is not movable.
  std::span<const ObjectPose> poses() const noexcept { return poses_; }
  // Counts the changes of the poses, from 1.
  std::uint32_t pose_serial() const noexcept { return pose_serial_; }

 private:
  enum class Phase : std::uint8_t { idle, asked, held, waiting };

  bool is_down(const DeviceState& state) const noexcept { return (state.buttons & buttons_) != 0; }
  bool has_reply() noexcept;
  bool has_tool() noexcept { return has_reply() && link_.replies.value().tool != nullptr; }
  bool has_gone(const DeviceState& state, const Pose& X_WS) const noexcept;
  bool may_move(const ObjectPose& pose) const noexcept;
  void move(const ObjectPose& pose) noexcept;
  void note_stylus(const DeviceState& state, const Pose& X_WS, const Vec3& visual_offset_m) noexcept;
  void begin(const DeviceState& state, const Pose& X_WS, int object, const Vec3& visual_offset_m) noexcept;
  void send(GraspOrder::Kind kind) noexcept;
  void set_pose(const Pose& pose, bool is_held) noexcept;

  GraspLink& link_;
  std::vector<bool> movable_;
  std::uint32_t buttons_;
  Phase phase_ = Phase::idle;
  bool is_free_ = true;
  bool was_early_ = false;  // is_leaving() was since the button was pressed
  bool was_down_ = true;    // a button held down since before the start picks up nothing
  GraspOrder order_;
  HeldTool* tool_ = nullptr;
  Vec3 p_DP_ = Vec3::Zero();      // the probe on the object when it was picked up, frame of the stylus
  Pose X_SP_ = Pose::Identity();  // the tool's pose, frame S
  bool has_start_ = false;
  std::optional<ObjectPose> requested_;
  std::vector<Pose> moved_;         // by object
  Pose before_ = Pose::Identity();  // of the object, before it was picked up or moved
  std::vector<ObjectPose> poses_;
  std::uint32_t pose_serial_ = 1;
};

}  // namespace hapton
