#include <cstddef>
#include <cstdint>
#include <span>

#include "haptics_node/reply_loop.h"

// The part of ReplyLoop that handles objects that the stylus picks up.
namespace hapton {
namespace {

constexpr std::size_t kMaxPoseRepeats = 16;  // poses of objects that are sent again with each setup

}  // namespace

// Called before each step and before anything is sent, because steps are rare while the hub computes the force. The hub's parts of the
// scene have each object at its place of rest. So an object may leave that place only once the hub has dropped its parts, and the hub gets
// parts again only of the scene in use. A hub of an earlier version gets none: it would use parts with the old place, even late ones.
void ReplyLoop::withdraw_parts() noexcept {
  Grasp* grasp = step_.grasp();
  if (patch_sender_ == nullptr || grasp == nullptr) return;
  const bool is_object_away = grasp->is_object_away(!patch_sender_->is_requested(hub_.session()));
  const bool is_placed = patch_sender_->revision() == scene_revision_;
  const bool is_safe = patch_sender_->has_numbered_requests();
  patch_sender_->set_withdrawn(is_object_away || !is_placed || !is_safe, static_cast<std::uint32_t>(step_.counts().method_changes));
  grasp->set_may_leave(patch_sender_->is_withdrawn(hub_.session()));
}

// Sends the pose that changed last, and up to kMaxPoseRepeats poses in turn: a datagram may be lost, and a vision node may come from
// another session.
void ReplyLoop::send_poses() noexcept {
  if (step_.grasp() == nullptr) return;
  const std::span<const ObjectPose> poses = step_.grasp()->poses();
  for (const ObjectPose& pose : poses) {
    if (pose.serial == step_.grasp()->pose_serial() && pose.serial > 1) hub_.send(pose);
  }
  std::size_t sent = 0;
  for (std::size_t looked = 0; looked < poses.size() && sent < kMaxPoseRepeats; ++looked) {
    const ObjectPose& pose = poses[next_pose_];
    next_pose_ = (next_pose_ + 1) % poses.size();
    if (pose.serial == 0) continue;
    hub_.send(pose);
    ++sent;
  }
}

// A method that is built while the stylus holds an object computes no force, and so is not shown, until the object is put down.
void ReplyLoop::show_method_in_use() noexcept {
  const bool holds_object = step_.grasp() != nullptr && step_.holds_tool();
  show_method(holds_object ? step_.grasp()->method() : method_text_);
}

// While the stylus holds an object, the setup names another method. A pose that has changed is sent at once.
void ReplyLoop::report_grasp() noexcept {
  Grasp* grasp = step_.grasp();
  if (grasp == nullptr) return;
  if (const PlacedScene* placed = grasp->take_placed()) placed_scene_ = placed;
  if (placed_scene_ != nullptr && placed_scene_->revision == scene_revision_) {
    describe_scene(placed_scene_->hash, placed_scene_->facts);
    placed_scene_ = nullptr;
    send_setup_soon();
  }
  if (grasp->pose_serial() == pose_serial_) return;
  pose_serial_ = grasp->pose_serial();
  if (step_.holds_tool()) {
    show_method(grasp->method());
  } else if (!grasp->is_busy()) {
    show_method(method_text_);
  }
  send_setup_soon();
}

}  // namespace hapton
