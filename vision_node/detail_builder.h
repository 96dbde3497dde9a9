#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <vector>

#include "vision_node/flat_level.h"

namespace hapton {

// Makes the levels of detail of a scene's meshes, in its own thread of low priority, for large meshes coarse ones first. Nothing waits for
// that thread: if the builder is destroyed, the thread drops the level that it is making, and ends. Threads: all calls from one. RT: no.
class DetailBuilder {
 public:
  // Meshes with fewer triangles are drawn as they are.
  static constexpr std::size_t kMinTriangles = 12'000;

  // Full levels, one for each object, in its frame U.
  // longest_wait: for begin().
  explicit DetailBuilder(std::vector<std::shared_ptr<const DetailLevel>> full, std::chrono::seconds longest_wait = std::chrono::seconds(1));
  ~DetailBuilder();
  DetailBuilder(const DetailBuilder&) = delete;
  DetailBuilder& operator=(const DetailBuilder&) = delete;

  struct Made {
    std::size_t object = 0;
    FlatLevel level;
    bool is_full = false;   // the mesh itself, divided into clusters
    bool is_rough = false;  // used until the object's first good level
  };
  // The levels made since the last call.
  std::vector<Made> take_made();
  // The first frame is drawn: begins now, and not a second later, as it would by itself. Until then the frame has the cores.
  void begin();
  // How much of all is made, 0 to 1.
  double progress() const;

 private:
  // Of the builder and its thread, which may outlive it.
  class Work;
  std::shared_ptr<Work> work_;
};

}  // namespace hapton
