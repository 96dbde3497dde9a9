#pragma once

#include <cstddef>

#include "session/session_index.h"
#include "vision_node/carved_objects.h"

namespace hapton {

// Carves the objects of the scene as they were carved at a moment of a recording, forwards or backwards. RT: no.
class RecordedCarves {
 public:
  // Pre: both outlive this; nothing else carves the objects.
  RecordedCarves(const SessionIndex& index, CarvedObjects& carved) : index_(index), carved_(carved) {}

  void show(double t_s);

 private:
  const SessionIndex& index_;
  CarvedObjects& carved_;
  std::size_t carves_ = 0;  // so many messages are applied
};

}  // namespace hapton
