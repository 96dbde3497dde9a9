#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/base/mailbox.h"
#include "core/tool/held_tool.h"
#include "link/messages.h"

namespace hapton {

// Frames: W world, S static scene, D device (the stylus), P probe or tool, O an object from its place in the scene file.

// A request of the haptic step to the slow task.
struct GraspRequest {
  enum class Kind : std::uint8_t { pick_up, cancel_pick_up, put_down };

  std::uint32_t serial = 0;  // counts requests, from 1
  Kind kind = Kind::cancel_pick_up;
  int object = -1;                       // the object's number in the scene
  Pose X_SD = Pose::Identity();          // pick_up: the stylus when the object was picked up
  Pose displacement = Pose::Identity();  // where the object is, frame S: the transform of its points from where the scene file places them
};

// The reply of the slow task: to a pick_up the tool, which the step holds until its next request. Null: there is none; the log says why.
struct GraspReply {
  std::uint32_t serial = 0;  // that of the request
  HeldTool* tool = nullptr;
  HapticsSetup::Text method = {};  // the tool as text, as in HapticsSetup::method
};

// Hash and facts of a scene in which an object was put down. They are known some time after the scene is in use: the larger the scene, the
// longer they take.
struct PlacedScene {
  std::uint32_t revision = 0;  // NewScene::revision
  std::uint64_t hash = 0;      // hash_scene
  SceneFacts facts;
};

// The exchange between the step and the slow task. RT: yes. Threads: one on each side.
struct GraspLink {
  Mailbox<GraspRequest> requests;
  Mailbox<GraspReply> replies;
  Mailbox<PlacedScene> placed;
};

// The step's side of picking up movable objects. If a button of the stylus is pressed while a movable object is touched, that object
// becomes the tool that the stylus holds, and collides with all others. When the button is released, the object stays where it is, and can
// be touched there as soon as the slow task has built the scene again. If the hand moves more than kResumeReachM, or turns more than
// kResumeTurnRad, from where it pressed the button before the object can be picked up, the object stays where it is. RT: yes. Threads: the
// step's.
class Grasp {
 public:
  // movable: for each object of the scene, whether it is movable. buttons: a mask of the buttons that pick up.
  Grasp(GraspLink& link, const std::vector<bool>& movable, std::uint32_t buttons);

  // Places an object at the start: X_SO moves it from where the scene file has it. Set-up only. Pre: it is in the scene, and movable.
  void place(int object, const Pose& X_SO);

  // Requests that an object moves to this pose. The serial is that of the object's present pose. The next update() moves the object; it
  // ignores the request, which the sender then repeats, if an object is being picked up, held or put down, if the serial is not the
  // object's newest, or if the object is not movable.
  void request_pose(const ObjectPose& pose) noexcept { requested_pose_ = pose; }

  // Whether objects may leave their places at the next update(): not while a hub computes forces with parts of the scene in which they are
  // still there. Until they may, picking up and requested moves wait. True at the start.
  void set_may_leave(bool may_leave) noexcept { may_leave_ = may_leave; }
  // Whether an object is about to leave its place, has left it, or was put down and gives no force at its new place yet. An object that is
  // to be picked up counts as about to leave from the slow task's reply on, or with is_early from the press of the button on, when it is
  // not certain that it can be picked up.
  bool is_object_away(bool is_early) noexcept;

  enum class Change : std::uint8_t {
    none,
    picked_up,
    put_down,
    returned  // it could not be put down: the object is where it was before, and the scene is the one before
  };
  // To be called before the force of each sample is computed. touched: the object in contact at the sample before, -1: none.
  // visual_offset_m: of that sample, frame W.
  Change update(const DeviceState& state, const Pose& X_WS, int touched, const Vec3& visual_offset_m) noexcept;
  // To be called in place of update() at a sample without a step before it, when it is not known yet what the probe touches. Nothing is
  // picked up or moved then. A button that is pressed in this sample counts as pressed in the next one.
  void skip_sample(const DeviceState& state) noexcept;

  // The tool that the stylus holds; null: none.
  HeldTool* tool() const noexcept { return tool_; }
  int object() const noexcept { return request_.object; }
  // The tool that the stylus holds as text, as in HapticsSetup::method.
  const HapticsSetup::Text& method() const noexcept { return link_.replies.value().method; }
  // Keeps the drawn pose of the tool. To be called after each of its steps.
  void note_pose(const Pose& X_WP, const Pose& X_WS) noexcept;

  // An object has been put down, and the scene is not built again yet: no object gives a force.
  bool is_waiting() const noexcept { return phase_ == Phase::waiting; }
  // An object is picked up, held or put down: no other method may come into use.
  bool is_busy() const noexcept { return phase_ != Phase::idle; }
  // The scene for the put_down request with this serial has been built: the next method starts where the stylus touches the object.
  void note_built(std::uint32_t serial) noexcept;
  // Available once after note_built or Change::returned, frame W: the point of the object at which the probe touched it when it was picked
  // up, and the direction away from its surface.
  struct ResumeContact {
    Vec3 p_W = Vec3::Zero();
    Vec3 outward = Vec3::Zero();
  };
  std::optional<ResumeContact> take_resume_contact(const Pose& X_WS) noexcept;

  // Each scene is returned once, and stays valid until the next one. Null: there is no new one.
  const PlacedScene* take_placed() noexcept { return link_.placed.take() ? &link_.placed.value() : nullptr; }

  // The poses of all objects, in the order of the scene; serial 0: the object is not movable.
  std::span<const ObjectPose> poses() const noexcept { return poses_; }
  // The serial of the newest pose: counts the changes of all poses, from 1.
  std::uint32_t pose_serial() const noexcept { return pose_serial_; }

 private:
  enum class Phase : std::uint8_t { idle, requested, held, waiting };

  bool is_down(const DeviceState& state) const noexcept { return (state.buttons & buttons_) != 0; }
  bool has_reply() noexcept;
  bool has_tool() noexcept { return has_reply() && link_.replies.value().tool != nullptr; }
  bool has_hand_left(const DeviceState& state, const Pose& X_WS) const noexcept;
  bool may_move(const ObjectPose& pose) const noexcept;
  void move(const ObjectPose& pose) noexcept;
  void note_stylus(const DeviceState& state, const Pose& X_WS, const Vec3& visual_offset_m) noexcept;
  void begin(const DeviceState& state, const Pose& X_WS, int object, const Vec3& visual_offset_m) noexcept;
  void send(GraspRequest::Kind kind) noexcept;
  void set_pose(int object, const Pose& pose, bool is_held) noexcept;

  GraspLink& link_;
  std::vector<bool> movable_;
  std::uint32_t buttons_;
  Phase phase_ = Phase::idle;
  bool may_leave_ = true;
  bool was_early_ = false;  // is_object_away() was called with is_early since the button was pressed
  bool was_down_ = true;    // a button held down since before the start picks up nothing
  GraspRequest request_;
  HeldTool* tool_ = nullptr;
  Vec3 p_DP_ = Vec3::Zero();      // from the device point to the probe when the object was picked up, frame of the stylus
  Pose X_SP_ = Pose::Identity();  // the tool's pose, frame S
  bool has_resume_contact_ = false;
  std::optional<ObjectPose> requested_pose_;
  std::vector<Pose> displacements_;              // of each object, as GraspRequest::displacement
  Pose displacement_before_ = Pose::Identity();  // the same of request_.object, before it was picked up or moved
  std::vector<ObjectPose> poses_;
  std::uint32_t pose_serial_ = 1;
};

}  // namespace hapton
