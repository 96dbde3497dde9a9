#include "haptic_step/grasp.h"

#include <utility>

#include "core/math/contact_resumption.h"

namespace hapton {
namespace {

Pose pose_of(const DeviceState& state) {
  Pose X_WD = Pose::Identity();
  X_WD.translation() = state.p_WD;
  X_WD.linear() = state.q_WT.normalized().toRotationMatrix();
  return X_WD;
}

Pose relative(const Pose& X_WS, const Pose& X_WD) { return X_WS.inverse(Eigen::Isometry) * X_WD; }

// Keeps the rotation of a product of many poses a rotation, despite rounding errors.
Pose rigid(const Pose& pose) {
  Pose normalized = pose;
  normalized.linear() = Quat(pose.linear()).normalized().toRotationMatrix();
  return normalized;
}

}  // namespace

Grasp::Grasp(GraspLink& link, const std::vector<bool>& movable, std::uint32_t buttons)
    : link_(link), movable_(movable), buttons_(buttons), displacements_(movable.size(), Pose::Identity()), poses_(movable.size()) {
  for (std::size_t o = 0; o < poses_.size(); ++o) {
    poses_[o].object = static_cast<std::int32_t>(o);
    if (movable_[o]) poses_[o].serial = 1;
  }
}

void Grasp::place(int object, const Pose& X_SO) {
  displacements_[static_cast<std::size_t>(object)] = X_SO;
  set_pose(object, X_SO, false);
}

Grasp::Change Grasp::update(const DeviceState& state, const Pose& X_WS, int touched, const Vec3& visual_offset_m) noexcept {
  const bool is_held_down = is_down(state);
  const bool is_pressed = !std::exchange(was_down_, is_held_down) && is_held_down;
  const bool is_replied = has_reply();
  const std::optional<ObjectPose> request = std::exchange(requested_pose_, std::nullopt);
  switch (phase_) {
    case Phase::idle:
      if (request && may_move(*request) && !may_leave_) {
        requested_pose_ = request;
      } else if (request && may_move(*request)) {
        note_stylus(state, X_WS, touched >= 0 ? visual_offset_m : Vec3(Vec3::Zero()));
        move(*request);
        return Change::put_down;
      }
      if (is_pressed && touched >= 0 && static_cast<std::size_t>(touched) < movable_.size() &&
          movable_[static_cast<std::size_t>(touched)]) {
        begin(state, X_WS, touched, visual_offset_m);
      }
      return Change::none;
    case Phase::requested:
      if (!is_held_down || has_hand_left(state, X_WS) || (is_replied && !has_tool())) {
        send(GraspRequest::Kind::cancel_pick_up);
        phase_ = Phase::idle;
        return Change::none;
      }
      if (!has_tool() || !may_leave_) return Change::none;
      tool_ = link_.replies.value().tool;
      phase_ = Phase::held;
      set_pose(request_.object, request_.X_SD.inverse(Eigen::Isometry) * request_.displacement, true);
      return Change::picked_up;
    case Phase::held:
      if (is_held_down) return Change::none;
      tool_ = nullptr;
      request_.displacement = rigid(X_SP_ * request_.X_SD.inverse(Eigen::Isometry) * request_.displacement);
      displacements_[static_cast<std::size_t>(request_.object)] = request_.displacement;
      set_pose(request_.object, request_.displacement, false);
      send(GraspRequest::Kind::put_down);
      phase_ = Phase::waiting;
      return Change::put_down;
    case Phase::waiting:
      if (!is_replied) return Change::none;
      // A reply to put_down means that the scene could not be built.
      displacements_[static_cast<std::size_t>(request_.object)] = displacement_before_;
      set_pose(request_.object, displacement_before_, false);
      phase_ = Phase::idle;
      has_resume_contact_ = true;
      return Change::returned;
  }
  return Change::none;
}

bool Grasp::is_object_away(bool is_early) noexcept {
  was_early_ = phase_ == Phase::requested && (was_early_ || is_early);
  if (phase_ == Phase::idle) return requested_pose_ && may_move(*requested_pose_);
  return phase_ != Phase::requested || was_early_ || has_tool();
}

// A button released in this sample may be pressed again in the next one, and update() would miss the release: cancels the request.
void Grasp::skip_sample(const DeviceState& state) noexcept {
  was_down_ = was_down_ && is_down(state);
  if (phase_ != Phase::requested || is_down(state)) return;
  send(GraspRequest::Kind::cancel_pick_up);
  phase_ = Phase::idle;
}

// Whether the reply to the last request has arrived.
bool Grasp::has_reply() noexcept {
  (void)link_.replies.take();
  return link_.replies.value().serial == request_.serial;
}

// Whether the hand has moved or turned too far: the object would follow it through whatever is in between.
bool Grasp::has_hand_left(const DeviceState& state, const Pose& X_WS) const noexcept {
  const Pose X_SD = relative(X_WS, pose_of(state));
  return (X_SD.translation() - request_.X_SD.translation()).norm() > kResumeReachM ||
         turn_between(Quat(request_.X_SD.linear()), Quat(X_SD.linear())).norm() > kResumeTurnRad;
}

bool Grasp::may_move(const ObjectPose& pose) const noexcept {
  const auto object = static_cast<std::size_t>(pose.object);
  return pose.object >= 0 && object < movable_.size() && movable_[object] && !pose.is_held && pose.serial == poses_[object].serial;
}

// Moves an object as if the stylus had held it and put it down there. The probe continues from its present position.
void Grasp::move(const ObjectPose& pose) noexcept {
  request_.object = pose.object;
  displacement_before_ = displacements_[static_cast<std::size_t>(pose.object)];
  request_.displacement = Pose::Identity();
  request_.displacement.translation() = pose.p_m;
  request_.displacement.linear() = pose.q.normalized().toRotationMatrix();
  displacements_[static_cast<std::size_t>(pose.object)] = request_.displacement;
  set_pose(request_.object, request_.displacement, false);
  send(GraspRequest::Kind::put_down);
  phase_ = Phase::waiting;
}

void Grasp::note_stylus(const DeviceState& state, const Pose& X_WS, const Vec3& visual_offset_m) noexcept {
  request_.X_SD = relative(X_WS, pose_of(state));
  X_SP_ = request_.X_SD;
  p_DP_ = state.q_WT.conjugate() * visual_offset_m;
}

void Grasp::begin(const DeviceState& state, const Pose& X_WS, int object, const Vec3& visual_offset_m) noexcept {
  request_.object = object;
  request_.displacement = displacement_before_ = displacements_[static_cast<std::size_t>(object)];
  note_stylus(state, X_WS, visual_offset_m);
  was_early_ = false;
  send(GraspRequest::Kind::pick_up);
  phase_ = Phase::requested;
}

void Grasp::send(GraspRequest::Kind kind) noexcept {
  ++request_.serial;
  request_.kind = kind;
  link_.requests.publish(request_);
}

void Grasp::set_pose(int object, const Pose& pose, bool is_held) noexcept {
  ObjectPose& announced = poses_[static_cast<std::size_t>(object)];
  announced.serial = ++pose_serial_;
  announced.is_held = is_held;
  announced.p_m = pose.translation();
  announced.q = Quat(pose.linear()).normalized();
}

void Grasp::note_pose(const Pose& X_WP, const Pose& X_WS) noexcept {
  if (tool_ != nullptr && tool_->is_known()) X_SP_ = relative(X_WS, X_WP);
}

void Grasp::note_built(std::uint32_t serial) noexcept {
  if (phase_ != Phase::waiting || serial != request_.serial) return;
  phase_ = Phase::idle;
  has_resume_contact_ = true;
}

std::optional<Grasp::ResumeContact> Grasp::take_resume_contact(const Pose& X_WS) noexcept {
  if (!std::exchange(has_resume_contact_, false) || p_DP_.isZero(0.0)) return std::nullopt;
  const Pose X_WP = X_WS * X_SP_;
  return ResumeContact{X_WP * p_DP_, (X_WP.linear() * p_DP_).normalized()};
}

}  // namespace hapton
