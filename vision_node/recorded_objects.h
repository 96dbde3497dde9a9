#pragma once

#include <cstddef>

#include "session/session_index.h"
#include "vision_node/moved_objects.h"

namespace hapton {

// Puts the objects of the scene where they were at a moment of a recording, forwards or backwards. RT: no.
class RecordedObjects {
 public:
  // Pre: both outlive this; nothing else moves the objects.
  RecordedObjects(const SessionIndex& index, MovedObjects& moved) : index_(index), moved_(moved) {}

  // scene_time_ns: of the sample shown. True: the picture has changed.
  bool show(double t_s, std::int64_t scene_time_ns);

 private:
  const SessionIndex& index_;
  MovedObjects& moved_;
  std::size_t poses_ = 0;  // so many are known
  std::size_t moves_ = 0;
};

}  // namespace hapton
