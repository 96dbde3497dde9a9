#include "tools/dynamics/dynamics_driver.h"

#include <algorithm>
#include <cmath>

#include "core/effects/bounded_force.h"
#include "core/math/rigid_pose.h"
#include "haptic_step/material_tuning.h"
#include "haptic_step/method_text.h"
#include "runtime/clock.h"

namespace hapton::dynamics {
namespace {

constexpr std::int64_t kStepNs = static_cast<std::int64_t>(1e9 * DynamicsWorld::kStepS);
// The longest time between two states that is simulated. In the rest of a longer time the bodies stand still. Otherwise a program that is
// late would become even later by simulating what it missed.
constexpr std::int64_t kMaxGapNs = 100 * kNanosecondsPerMillisecond;
// A request without a reply is repeated after this time, since one of the two may be lost.
constexpr std::int64_t kRepeatNs = 50 * kNanosecondsPerMillisecond;
// The pose of a body is requested again once one of its points has moved by more than this: a tenth of an encoder step of a stylus.
constexpr double kMinTravelM = 2e-6;
// The delay before the first measurement, and the largest one that is used for the damping, which would otherwise all but stop the bodies.
// Free choices.
constexpr double kFirstDelayS = 0.02;
constexpr double kLongestDelayS = 0.2;
// The delay is the largest one measured; it decreases by this share with each reply: at 200 replies a second by 63 % in a second.
constexpr double kDelayDecayShare = 0.005;

}  // namespace

Result<DynamicsDriver> DynamicsDriver::make(const Scene& scene, const Settings& settings) {
  auto world = DynamicsWorld::make(scene, settings.friction);
  if (!world) return tl::unexpected(world.error());
  return DynamicsDriver(scene, settings, std::move(*world));
}

DynamicsDriver::DynamicsDriver(const Scene& scene, const Settings& settings, std::unique_ptr<DynamicsWorld> world)
    : scene_(&scene), settings_(settings), world_(std::move(world)), last_request_(settings.first_request) {
  for (const int object : world_->bodies()) bodies_.emplace_back().object = object;
  period_s_ = 1.0 / kRequestRateHz;
  delay_s_ = kFirstDelayS;
  world_->set_gravity(settings_.gravity_W);
  materials_ = tuned_materials(scene_->touch_scene(), MaterialState(), 0.0);
}

void DynamicsDriver::take(const ProbeState& state) {
  const auto push = find_push(state);
  counts_.pushes += push ? 1 : 0;
  world_->press(push);
  advance_to(state.scene_time_ns);
}

// The proxy's position and the force may belong to samples a few apart; the damping at the contact is enough for that difference, too.
std::optional<Push> DynamicsDriver::find_push(const ProbeState& state) const {
  if (!state.contact || !world_->is_body(state.object)) return std::nullopt;
  const Pose X_SW = X_WS_.inverse(Eigen::Isometry);
  if (tool_) return find_tool_push(state, X_SW);
  const double stiffness = materials_[static_cast<std::size_t>(state.object)].stiffness_n_per_m;
  return Push{.object = state.object,
              .p_S = X_SW * (state.p_WD + state.visual_offset_m),
              .force_n = X_SW.linear() * -state.force_n,
              .damping_ns_per_m = settings_.damping_share * stiffness * delay_s_};
}

// The force acts along a line. The body is damped at the point of this line nearest to the grip point, but no farther from the grip point
// than the body reaches: where the forces of several contacts and friction nearly cancel, their line may be anywhere.
Push DynamicsDriver::find_tool_push(const ProbeState& state, const Pose& X_SW) const {
  const ObjectPush push = state.push.value_or(ObjectPush());
  const Vec3 force_n = X_SW.linear() * push.force_n;
  const Vec3 torque_nm = X_SW.linear() * push.torque_nm;
  const Vec3 grip_S = X_SW * (state.p_WD + state.visual_offset_m);
  const double most_m =
      (grip_S - world_->place(state.object).p_S).norm() + scene_->objects[static_cast<std::size_t>(state.object)].commanded->radius_m();
  const double force_squared = force_n.squaredNorm();
  const Vec3 arm = force_squared > 0.0 ? bounded_force(force_n.cross(torque_nm) / force_squared, most_m) : Vec3(Vec3::Zero());
  const double damping_time_s = settings_.damping_share * delay_s_;
  return {.object = state.object,
          .p_S = grip_S + arm,
          .force_n = force_n,
          .damping_ns_per_m = tool_->stiffness_n_per_m * damping_time_s,
          .torque_nm = torque_nm - arm.cross(force_n),
          .damping_nms_per_rad = tool_->rotational_stiffness_nm_per_rad * damping_time_s};
}

void DynamicsDriver::advance_to(std::int64_t scene_time_ns) {
  interval_ns_ = scene_time_ns_ < 0 ? 0 : scene_time_ns - scene_time_ns_;
  if (interval_ns_ < 0) {
    // Scene time went back, so the haptics node is a new one, with the bodies and materials as in the scene file.
    ++counts_.restarts;
    for (Body& body : bodies_) body.is_pose_sent = false;
    materials_ = tuned_materials(scene_->touch_scene(), MaterialState(), 0.0);
  }
  if (scene_time_ns_ < 0 || interval_ns_ < 0) world_time_ns_ = scene_time_ns;
  scene_time_ns_ = scene_time_ns;
  const std::int64_t left_out_ns = std::max<std::int64_t>(scene_time_ns - world_time_ns_ - kMaxGapNs, 0);
  counts_.left_out_ns += left_out_ns;
  world_time_ns_ += left_out_ns;
  for (; world_time_ns_ + kStepNs <= scene_time_ns; world_time_ns_ += kStepNs) {
    move_obstacles(1e-9 * static_cast<double>(world_time_ns_ + kStepNs));
    world_->step();
    ++counts_.steps;
    const auto fallen = world_->fallen();
    fallen_.insert(fallen_.end(), fallen.begin(), fallen.end());
    counts_.fallen += fallen.size();
  }
}

void DynamicsDriver::move_obstacles(double time_s) {
  for (std::size_t i = 0; i < scene_->objects.size(); ++i) {
    const SceneObject& object = scene_->objects[i];
    const int number = static_cast<int>(i);
    if (object.motion != nullptr) world_->move_obstacle(number, object.motion->pose_at(time_s));
    if (object.commanded == nullptr || world_->is_body(number)) continue;
    if (const auto placed = moves_.find(number, time_s)) world_->move_obstacle(number, pose_of(placed->at, object.commanded->pivot()));
  }
}

void DynamicsDriver::take(const MaterialState& state) { materials_ = tuned_materials(scene_->touch_scene(), state, 0.0); }

void DynamicsDriver::take(const HapticsSetup& setup) {
  tool_ = parse_tool_text(setup.method.data());
  const auto X_WS = find_rigid_pose(setup.X_WS);
  if (!X_WS || X_WS->matrix() == X_WS_.matrix()) return;
  X_WS_ = *X_WS;
  world_->set_gravity(X_WS_.linear().transpose() * settings_.gravity_W);
}

// A pose that a newer one overtook is ignored: its object may have been put down since. All poses are sent repeatedly.
void DynamicsDriver::take(const ObjectPose& pose, Arrival arrival) {
  const auto object = static_cast<std::size_t>(pose.object);
  if (arrival == Arrival::reordered || pose.object < 0 || object >= scene_->objects.size() || !scene_->objects[object].is_movable) return;
  if (pose.is_held) return world_->pick_up_obstacle(pose.object);
  Pose X_SO = Pose::Identity();
  X_SO.translation() = pose.p_m;
  X_SO.linear() = pose.q.normalized().toRotationMatrix();
  world_->put_down_obstacle(pose.object, X_SO);
}

void DynamicsDriver::take(const MoveReply& reply) {
  const auto body = std::ranges::find_if(bodies_, [&](const Body& b) { return b.pending && b.pending->request == reply.request; });
  if (body == bodies_.end()) return;
  body->pending.reset();
  if (reply.rejection[0] != '\0') {
    rejection_ = reply.rejection.data();
    body->is_pose_sent = false;
    body->not_before_ns = body->sent_ns + kRepeatNs;
    return;
  }
  const double measured =
      1e-9 * static_cast<double>(scene_time_ns_ - body->sent_scene_ns + std::max<std::int64_t>(interval_ns_, 0)) + period_s_;
  delay_s_ = std::clamp(std::max(measured, (1.0 - kDelayDecayShare) * delay_s_), 0.0, kLongestDelayS);
}

// True if the haptics node may have a different pose of the body than the dynamics has.
bool DynamicsDriver::is_pose_outdated(const Body& body) const {
  if (!body.is_pose_sent) return true;
  const double radius = scene_->objects[static_cast<std::size_t>(body.object)].commanded->radius_m();
  return most_travel_m(body.requested, world_->place(body.object), radius) > kMinTravelM;
}

bool DynamicsDriver::is_due(const Body& body, std::int64_t now_ns) const {
  if (now_ns < body.not_before_ns) return false;
  return is_pose_outdated(body) || (body.pending && now_ns - body.sent_ns >= kRepeatNs);
}

MoveRequest DynamicsDriver::make_request(Body& body) {
  if (body.pending && !is_pose_outdated(body)) return *body.pending;
  body.requested = world_->place(body.object, period_s_);
  const ObjectPlace place = scene_->objects[static_cast<std::size_t>(body.object)].commanded->find_place(body.requested);
  body.sent_scene_ns = scene_time_ns_;
  body.is_pose_sent = true;
  last_request_ = std::max(last_request_ + 1, 1U);
  return body.pending.emplace(
      MoveRequest{.request = last_request_, .number = body.object, .p_m = place.p_FM, .q = place.q_FM, .over_s = period_s_});
}

std::optional<MoveRequest> DynamicsDriver::next_request(std::int64_t now_ns) {
  if (scene_time_ns_ < 0 || now_ns < next_request_ns_) return std::nullopt;
  std::size_t due_count = 0;
  for (const Body& body : bodies_) due_count += is_due(body, now_ns) ? 1 : 0;
  if (due_count == 0) return std::nullopt;
  period_s_ = static_cast<double>(due_count) / kRequestRateHz;
  while (!is_due(bodies_[next_body_], now_ns)) next_body_ = (next_body_ + 1) % bodies_.size();
  Body& body = bodies_[next_body_];
  next_body_ = (next_body_ + 1) % bodies_.size();
  const MoveRequest request = make_request(body);
  body.sent_ns = now_ns;
  next_request_ns_ = now_ns + static_cast<std::int64_t>(1e9 / kRequestRateHz);
  ++counts_.requests;
  return request;
}

std::string DynamicsDriver::take_rejection() { return std::exchange(rejection_, {}); }

std::vector<int> DynamicsDriver::take_fallen() { return std::exchange(fallen_, {}); }

}  // namespace hapton::dynamics
