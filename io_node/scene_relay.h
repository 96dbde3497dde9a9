#pragma once

#include <optional>

#include "io_node/device_loop.h"
#include "io_node/event_ring.h"
#include "io_node/scene_reach.h"
#include "io_node/servo_stats.h"
#include "link/hub_peers.h"
#include "link/messages.h"

namespace hapton {

// Relays what the haptics node and the vision nodes state about their scenes, so that each can compare, and checks whether the device can
// reach the scene at its pose. It gives the simulated hand points of the surface to go to. RT: yes. Threads: the network side's.
class SceneRelay {
 public:
  // Pre: all outlive this.
  SceneRelay(DeviceLoop& loop, HubPeers& peers, EventRing& events, ServoStats& stats) noexcept
      : loop_(loop), peers_(peers), events_(events), stats_(stats) {}

  // view: the newest view transform; none: the pose of the scene is the identity.
  void accept(const SceneFacts& scene, NodeRole role, const std::optional<ViewTransform>& view) noexcept;
  // Call after the scene was turned or moved.
  void place(const std::optional<ViewTransform>& view) noexcept;
  SceneReach reach() const noexcept { return reach_; }
  // Whether the hand has been inside a body since the haptics node began, as that node reports.
  bool is_hand_inside() const noexcept { return scene_ && scene_->is_hand_inside; }

 private:
  void notify(ServoEvent::Kind kind) noexcept { events_.push({kind, NodeRole::haptics, {}, 0.0, {}, {}}); }

  DeviceLoop& loop_;
  HubPeers& peers_;
  EventRing& events_;
  ServoStats& stats_;
  std::optional<SceneFacts> scene_;  // of the haptics node
  SceneReach reach_ = SceneReach::unknown;
};

// Why there is no force, or why the scene cannot be felt as it should; of several causes the one to fix first. RT: yes.
ProbeStatus find_probe_status(const DeviceSide& side, bool has_haptics, SceneReach reach, bool is_hand_inside = false) noexcept;

}  // namespace hapton
