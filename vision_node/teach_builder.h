#pragma once

#include <memory>
#include <optional>

#include "vision_node/teach_shapes.h"

namespace hapton {

// Makes the shapes of teaching views, and the data that they need, in a thread of its own. No frame waits for that thread, nor does the
// destructor: the thread then ends once it has finished the shapes that it is making. Threads: all calls from one thread. RT: no.
class TeachBuilder {
 public:
  // scene: the objects where the scene file places them.
  explicit TeachBuilder(TouchScene scene);
  ~TeachBuilder();
  TeachBuilder(const TeachBuilder&) = delete;
  TeachBuilder& operator=(const TeachBuilder&) = delete;

  // Requests shapes. A request that has not begun yet is replaced. Pre: choice.view is not off.
  void request(const TeachChoice& choice, const TeachProbe& probe);
  // True: a request waits, or its shapes are being made.
  bool is_busy();
  // The newest shapes made since the last call; empty: none.
  std::optional<TeachShapes> take_shapes();
  // Levels of the tree; 0: not built yet.
  int tree_depth();

 private:
  // Shared by the builder and its thread, which may outlive the builder.
  class Work;
  std::shared_ptr<Work> work_;
  bool is_started_ = false;
};

}  // namespace hapton
