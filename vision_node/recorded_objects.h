#pragma once

#include <cstddef>

#include "recording/recording_index.h"
#include "vision_node/moved_objects.h"

namespace hapton {

// Places the objects of the scene as they were at a moment of a recording; moments may come in any order. RT: no. Threads: one.
class RecordedObjects {
 public:
  // Moves are applied this long before they were recorded, since in scene time one may begin shortly before. Too early does no harm.
  static constexpr double kAheadS = 0.2;

  // Pre: both outlive this; nothing else moves the objects.
  RecordedObjects(const RecordingIndex& index, MovedObjects& moved) : index_(index), moved_(moved) {}

  // scene_time_ns: of the sample that is shown. True: the picture has changed.
  bool show(double t_s, std::int64_t scene_time_ns);

 private:
  const RecordingIndex& index_;
  MovedObjects& moved_;
  std::size_t applied_poses_ = 0;  // how many of RecordingIndex::poses() have been applied
  std::size_t applied_moves_ = 0;  // ... and how many of moves()
};

}  // namespace hapton
