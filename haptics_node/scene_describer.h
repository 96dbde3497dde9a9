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

// Computes hash and facts of a scene. RT: no.
PlacedScene describe_placed(const Scene& scene, std::uint32_t revision);

// Describes scenes in which an object was put down, in a thread of its own: the larger the scene, the longer this takes, and picking up the
// next object must not wait for it. A scene that is replaced before its description begins is not described.
// Threads: describe from one thread. RT: no.
class SceneDescriber {
 public:
  using Describe = std::function<PlacedScene(const Scene& scene, std::uint32_t revision)>;

  // Publishes the descriptions in `placed`. Pre: placed outlives this and has no other writer.
  explicit SceneDescriber(Mailbox<PlacedScene>& placed, Describe describe = describe_placed);
  // Waits for the description in progress.
  ~SceneDescriber();
  SceneDescriber(const SceneDescriber&) = delete;
  SceneDescriber& operator=(const SceneDescriber&) = delete;

  // Requests a description, and returns at once. revision: NewScene::revision.
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
  std::optional<Request> next_request_;
  bool stops_ = false;
  std::thread thread_;
};

}  // namespace hapton
