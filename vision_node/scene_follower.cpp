#include "vision_node/scene_follower.h"

#include <utility>

namespace hapton {

void SceneFollower::offer(Scene scene, std::int64_t now_ns) {
  waiting_scene_ = std::move(scene);
  waiting_since_ns_ = now_ns;
  is_reported_ = false;
}

bool SceneFollower::is_due() const {
  if (!waiting_scene_) return false;
  const std::uint64_t next = waiting_scene_->given_hash;
  return next == shown_hash_ || next == felt_hash_ || felt_hash_ == 0 || felt_hash_ != shown_hash_;
}

std::optional<Scene> SceneFollower::take_due() {
  if (!is_due()) return std::nullopt;
  shown_hash_ = waiting_scene_->given_hash;
  return std::exchange(waiting_scene_, std::nullopt);
}

bool SceneFollower::take_overdue(std::int64_t now_ns) {
  if (!waiting_scene_ || is_reported_ || now_ns - waiting_since_ns_ < kReportAfterNs) return false;
  is_reported_ = true;
  return true;
}

}  // namespace hapton
