#pragma once

#include <cstdint>
#include <optional>

#include "scene/scene_file.h"

namespace hapton {

// Decides when a scene whose file was saved takes the place of the one shown: together with the one felt. haptics_node may need longer to
// build it, or reject it, so until it announces the same hash (Scene::given_hash) the picture stays. At once: what changes no mesh and no
// pose; and if what is felt is not known, or is another scene than the one shown anyway. Times: any monotonic clock, ns. Threads: one.
// RT: no.
class SceneFollower {
 public:
  // How long a scene waits before a person is told.
  static constexpr std::int64_t kReportAfterNs = 5'000'000'000;

  // shown_hash: of the scene that is shown.
  explicit SceneFollower(std::uint64_t shown_hash) : shown_hash_(shown_hash) {}

  // The file was saved with this content; it takes the place of one that waits.
  void offer(Scene scene, std::int64_t now_ns);
  // What haptics_node has, as it announces it.
  void set_felt(std::uint64_t given_hash) { felt_hash_ = given_hash; }

  // The scene to be shown from now on; none: the present one.
  std::optional<Scene> take_due();
  // The hash of what is shown, after a change that did not succeed as well.
  void set_shown(std::uint64_t given_hash) { shown_hash_ = given_hash; }

  // True once for each scene that has waited too long.
  bool take_overdue(std::int64_t now_ns);
  // Such a scene still waits.
  bool is_overdue() const { return waiting_ && is_reported_; }

 private:
  bool is_due() const;

  std::uint64_t shown_hash_;
  std::uint64_t felt_hash_ = 0;  // 0: not known
  std::optional<Scene> waiting_;
  std::int64_t waiting_since_ns_ = 0;
  bool is_reported_ = false;
};

}  // namespace hapton
