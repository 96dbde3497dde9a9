#pragma once

#include <memory>
#include <optional>

#include "vision_node/teach_shapes.h"

namespace hapton {

// Makes the shapes of teaching views, and what they are made from, in a thread of its own: no frame waits for it, nor does the end of the
// builder. The thread then ends after what it is making. Threads: all calls from one. RT: no.
class TeachBuilder {
 public:
  // The objects as the scene file has them.
  explicit TeachBuilder(TouchScene scene);
  ~TeachBuilder();
  TeachBuilder(const TeachBuilder&) = delete;
  TeachBuilder& operator=(const TeachBuilder&) = delete;

  // Only the newest request counts. Pre: not off.
  void request(const TeachChoice& choice, const TeachProbe& probe);
  // A request has not got a reply yet.
  bool is_busy();
  // The shapes made since the last call; empty: none.
  std::optional<TeachShapes> take_made();
  // Levels of the tree; 0: not built yet.
  int tree_depth();

 private:
  // Of the builder and its thread, which may outlive it.
  class Work;
  std::shared_ptr<Work> work_;
  bool is_started_ = false;
};

}  // namespace hapton
