#pragma once

#include <cstdint>
#include <optional>

#include "scene/scene_file.h"

namespace hapton {

// Decides when a scene whose file was saved replaces the one shown: at the same time as the one felt. haptics_node may need longer to build
// it, or reject it, so the picture stays until haptics_node announces the same hash (Scene::given_hash). A scene is shown at once if it
// changes no mesh and no pose, if it is not known what is felt, or if another scene than the one shown is felt anyway. Times: any
// monotonic clock, ns. Threads: one. RT: no.
class SceneFollower {
 public:
  // How long a scene waits before a person is told.
  static constexpr std::int64_t kReportAfterNs = 5'000'000'000;

  // shown_hash: Scene::given_hash of the scene that is shown.
  explicit SceneFollower(std::uint64_t shown_hash) : shown_hash_(shown_hash) {}

  // Offers the scene of the file as it was saved; it replaces one that still waits.
  void offer(Scene scene, std::int64_t now_ns);
  // Sets the hash of the scene that haptics_node has, as it announces it.
  void set_felt(std::uint64_t given_hash) { felt_hash_ = given_hash; }

  // The scene to be shown from now on; none: the present one stays.
  std::optional<Scene> take_due();
  // Sets the hash of the scene that is shown: call it if the scene of take_due() could not be shown.
  void set_shown(std::uint64_t given_hash) { shown_hash_ = given_hash; }

  // True once for each scene that has waited for kReportAfterNs.
  bool take_overdue(std::int64_t now_ns);
  // Whether such a scene still waits.
  bool is_overdue() const { return waiting_scene_ && is_reported_; }

 private:
  bool is_due() const;

  std::uint64_t shown_hash_;
  std::uint64_t felt_hash_ = 0;  // 0: not known
  std::optional<Scene> waiting_scene_;
  std::int64_t waiting_since_ns_ = 0;
  bool is_reported_ = false;
};

}  // namespace hapton
