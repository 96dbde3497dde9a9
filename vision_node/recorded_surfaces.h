#pragma once

#include <cstdint>
#include <vector>

#include "recording/recording_index.h"
#include "recording/recording_shapes.h"
#include "vision_node/moved_objects.h"

namespace hapton {

// Gives the objects that programs deform the shapes that they had at a moment of a recording; moments may come in any order. Vertices are
// read from the file when they are needed. RT: no. Threads: one.
class RecordedSurfaces {
 public:
  // Pre: all outlive this; nothing else gives the objects their shapes; index and shapes are of the same file.
  RecordedSurfaces(const RecordingIndex& index, RecordingShapes& shapes, MovedObjects& moved);

  // Call it before MovedObjects::set_time(), with the same time: the scene time of the sample that is shown.
  void show(double t_s, std::int64_t scene_time_ns);

 private:
  void load(const IndexedShape& shape);

  const RecordingIndex& index_;
  RecordingShapes& shapes_;
  MovedObjects& moved_;
  std::vector<const IndexedShape*> shown_shapes_;  // the shape of each object; null: at rest
};

}  // namespace hapton
