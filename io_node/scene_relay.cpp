#include "io_node/scene_relay.h"

#include <array>
#include <span>
#include <utility>

namespace hapton {

static_assert(Device::kMaxAims == SceneFacts::kMaxPoints);  // a hand knows every point that a scene reports

void SceneRelay::accept(const SceneFacts& scene, NodeRole role, const std::optional<ViewTransform>& view) noexcept {
  if (role != NodeRole::haptics) {
    peers_.send_to_role(NodeRole::haptics, scene);
    return;
  }
  peers_.send_to_role(NodeRole::vision, scene);
  const bool is_new = !scene_ || scene_->given_hash != scene.given_hash || scene_->points_m != scene.points_m;
  scene_ = scene;
  stats_.scene_given_hash = scene.given_hash;
  if (is_new) place(view);
}

void SceneRelay::place(const std::optional<ViewTransform>& view) noexcept {
  if (!scene_) return;
  const Pose X_WS = view ? pose_of(*view) : Pose(Pose::Identity());
  std::array<Vec3, SceneFacts::kMaxPoints> p_WA;
  for (std::size_t i = 0; i < scene_->point_count; ++i) p_WA[i] = point_in_world(*scene_, X_WS, i);
  loop_.aim_hand(std::span(p_WA).first(scene_->point_count));
  const SceneReach before = std::exchange(reach_, find_reach(*scene_, X_WS, loop_.limits()));
  stats_.reach = reach_;
  if (reach_ == before) return;
  if (reach_ == SceneReach::out_of_reach) notify(ServoEvent::Kind::out_of_reach);
  if (reach_ == SceneReach::too_small) notify(ServoEvent::Kind::too_small);
  const bool was_lost = before == SceneReach::out_of_reach || before == SceneReach::too_small;
  if (was_lost && reach_ == SceneReach::in_reach) notify(ServoEvent::Kind::in_reach);
}

ProbeStatus find_probe_status(const DeviceSide& side, bool has_haptics, SceneReach reach, bool is_hand_inside) noexcept {
  if (side.governor.fault != SafetyFault::none) return ProbeStatus::fault_latched;
  if (side.status == DeviceStatus::away || side.status == DeviceStatus::fault) return ProbeStatus::device_away;
  if (side.status == DeviceStatus::calibrating) return ProbeStatus::calibrating;
  if (!has_haptics || side.has_timed_out) return ProbeStatus::no_haptics;
  if (reach == SceneReach::out_of_reach) return ProbeStatus::out_of_reach;
  if (reach == SceneReach::too_small) return ProbeStatus::too_small;
  return is_hand_inside ? ProbeStatus::hand_inside : ProbeStatus::ok;
}

}  // namespace hapton
