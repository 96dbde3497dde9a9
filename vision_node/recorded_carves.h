#pragma once

#include <cstddef>

#include "recording/recording_index.h"
#include "vision_node/carved_objects.h"

namespace hapton {

// Shows the carved objects of the scene as they were at a moment of a recording; moments may come in any order. RT: no. Threads: one.
class RecordedCarves {
 public:
  // Pre: both outlive this; nothing else carves the objects.
  RecordedCarves(const RecordingIndex& index, CarvedObjects& carved) : index_(index), carved_(carved) {}

  void show(double t_s);

 private:
  const RecordingIndex& index_;
  CarvedObjects& carved_;
  std::size_t applied_carves_ = 0;  // how many of RecordingIndex::carves() have been applied
};

}  // namespace hapton
