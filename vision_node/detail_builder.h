#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <vector>

#include "vision_node/flat_level.h"

namespace hapton {

// Makes the levels of detail of a scene's meshes, in a thread of low priority; of large meshes, first a rough level. Nothing waits for that
// thread: if the builder is destroyed, the thread drops the level that it is making, and ends. Threads: all calls from one. RT: no.
class DetailBuilder {
 public:
  // Meshes with fewer triangles get no other levels.
  static constexpr std::size_t kMinTriangles = 12'000;

  // full: the full level of each object, in its frame U.
  // longest_wait: time after which the work begins even if begin() was not called.
  explicit DetailBuilder(std::vector<std::shared_ptr<const DetailLevel>> full, std::chrono::seconds longest_wait = std::chrono::seconds(1));
  ~DetailBuilder();
  DetailBuilder(const DetailBuilder&) = delete;
  DetailBuilder& operator=(const DetailBuilder&) = delete;

  struct MadeLevel {
    std::size_t object = 0;
    FlatLevel level;
    bool is_full = false;   // the mesh itself, divided into clusters
    bool is_rough = false;  // used until the object's first good level
  };
  // Returns the levels made since the last call.
  std::vector<MadeLevel> take_levels();
  // To be called when the first picture is drawn: work begins now, not only after longest_wait. Before, that picture can use all cores.
  void begin();
  // The share of all work that is done, 0 to 1.
  double progress() const;

 private:
  // The state of the builder and its thread; the thread may outlive the builder.
  class Work;
  std::shared_ptr<Work> work_;
};

}  // namespace hapton
