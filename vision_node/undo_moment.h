#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/sculpt/carve_list.h"
#include "scene/annotations.h"

namespace hapton {

// When something was done among the carves, of which a vision node knows two lists: that of haptics_node, in which a serial says when a
// carve was made, and the presses of the annotation file, in the order in which they were made. Only the latter outlives both programs.
struct UndoMoment {
  std::size_t saved = 0;     // so many presses of the file were made before
  std::uint32_t source = 0;  // of haptics_node's list then (Carves); 0: none had come
  std::uint32_t serial = 0;  // the newest in it

  friend bool operator==(const UndoMoment&, const UndoMoment&) = default;
};

// Moments among the carves of haptics_node's list. RT: no.
class CarveMoments {
 public:
  // source: of the list. saved: the presses of the file; they are found in the list by their places. Time: that of both lists, if the file
  // has presses.
  CarveMoments(const CarveList& list, std::uint32_t source, const std::vector<CarvedPress>& saved);

  // The largest serial in the list of what was carved before that moment; 0: nothing was.
  std::uint32_t find_serial(const UndoMoment& moment) const;

 private:
  std::uint32_t source_;
  std::vector<std::uint32_t> serials_;  // by presses of the file: the last one of that many
};

}  // namespace hapton
