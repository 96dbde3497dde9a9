#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>

#include "core/base/mailbox.h"
#include "haptic_step/grasp.h"
#include "scene/scene_file.h"

namespace hapton {

// Hash and facts of the scene.
PlacedScene describe_placed(const Scene& scene, std::uint32_t revision);

// Describes scenes in which an object was put down, in a thread of its own: it takes the longer the larger the scene is, and what the
// stylus picks up next does not wait for it. Scenes that are replaced before their turn are left out.
// Threads: describe from one thread. RT: no.
class SceneDescriber {
 public:
  using Describe = std::function<PlacedScene(const Scene& scene, std::uint32_t revision)>;

  // Publishes there, and is its only writer. Pre: placed outlives this.
  explicit SceneDescriber(Mailbox<PlacedScene>& placed, Describe describe = describe_placed);
  // Waits for the description in progress.
  ~SceneDescriber();
  SceneDescriber(const SceneDescriber&) = delete;
  SceneDescriber& operator=(const SceneDescriber&) = delete;

  // Returns at once. revision: as PlacedScene has it.
  void describe(const Scene& scene, std::uint32_t revision);

 private:
  struct Request {
    Scene scene;  // shares the meshes
    std::uint32_t revision = 0;
  };

  void run();

  Mailbox<PlacedScene>& placed_;
  Describe describe_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<Request> next_;
  bool stops_ = false;
  std::thread thread_;
};

}  // namespace hapton
