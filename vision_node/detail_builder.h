#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "vision_node/flat_level.h"

namespace hapton {

// Makes the levels of detail of a scene's meshes, in its own thread of low priority, for large meshes coarse ones first. Threads: all calls
// from one. RT: no.
class DetailBuilder {
 public:
  // Meshes with fewer triangles are drawn as they are.
  static constexpr std::size_t kLeastTriangles = 12'000;

  // Full levels, one for each object, in its frame U. Pre: they outlive the builder.
  explicit DetailBuilder(std::vector<const DetailLevel*> full);
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
  // How much of all is made, 0 to 1.
  // The first frame is drawn: begins now, and not a second later, as it would by itself. Until then the frame has the cores.
  void begin();
  double progress() const { return progress_.load(std::memory_order_relaxed); }

 private:
  void run();
  void wait_for_begin();
  void build(std::size_t object);
  void offer(Made made);

  std::vector<const DetailLevel*> full_;
  double total_ = 0.0;  // triangles to work through
  std::atomic<bool> stop_{false};
  std::atomic<double> progress_{0.0};
  std::mutex mutex_;
  std::condition_variable begun_;
  bool has_begun_ = false;
  std::vector<Made> made_;
  std::thread thread_;
};

}  // namespace hapton
