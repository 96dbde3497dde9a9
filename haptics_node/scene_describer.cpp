#include "haptics_node/scene_describer.h"

#include <utility>

#include "haptic_step/scene_facts.h"
#include "runtime/start_thread.h"
#include "scene/scene_hash.h"

namespace hapton {

PlacedScene describe_placed(const Scene& scene, std::uint32_t revision) {
  return {revision, hash_scene(scene.touch_scene()), make_scene_facts(scene)};
}

SceneDescriber::SceneDescriber(Mailbox<PlacedScene>& placed, Describe describe)
    : placed_(placed), describe_(std::move(describe)), thread_(start_thread([this] { run(); })) {}

SceneDescriber::~SceneDescriber() {
  {
    const std::lock_guard lock(mutex_);
    stops_ = true;
  }
  changed_.notify_one();
  thread_.join();
}

void SceneDescriber::describe(const Scene& scene, std::uint32_t revision) {
  {
    const std::lock_guard lock(mutex_);
    next_request_.emplace(Request{scene, revision});
  }
  changed_.notify_one();
}

void SceneDescriber::run() {
  while (true) {
    std::optional<Request> request;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return stops_ || next_request_.has_value(); });
      if (stops_) return;
      request = std::exchange(next_request_, std::nullopt);
    }
    placed_.publish(describe_(request->scene, request->revision));
  }
}

}  // namespace hapton
