#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "vision_node/teach_shapes.h"

namespace hapton {

// Makes the shapes of teaching views, and what they are made from, in a thread of its own: no frame waits for it. Threads: all calls from
// one. RT: no.
class TeachBuilder {
 public:
  // The objects as the scene file has them.
  explicit TeachBuilder(TouchScene scene);
  ~TeachBuilder();
  TeachBuilder(const TeachBuilder&) = delete;
  TeachBuilder& operator=(const TeachBuilder&) = delete;

  // Only the newest request counts. Pre: not off.
  void request(const TeachChoice& choice, const TeachProbe& probe);
  // A request has not been answered yet.
  bool is_busy();
  // The shapes made since the last call; empty: none.
  std::optional<TeachShapes> take_made();
  // Levels of the tree; 0: not built yet.
  int tree_depth();

 private:
  struct Request {
    TeachChoice choice;
    TeachProbe probe;
  };
  void run();
  TeachShapes make(const Request& request);
  TeachShapes make_of_tree(const Request& request);

  TouchScene scene_;
  // The thread's own, made when first needed.
  std::unique_ptr<SmoothScene> smooth_;
  std::unique_ptr<UniformGrid> grid_;
  std::unique_ptr<TeachCurvature> curvature_;

  std::mutex mutex_;
  std::condition_variable wake_;
  std::optional<Request> request_;
  std::optional<TeachShapes> made_;
  bool is_working_ = false;
  bool stop_ = false;
  int depth_ = 0;
  std::thread thread_;
};

}  // namespace hapton
