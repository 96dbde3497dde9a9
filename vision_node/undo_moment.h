#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/sculpt/carve_list.h"
#include "scene/annotations.h"

namespace hapton {

// The moment of an action: which carves were made before it. A vision node knows two lists of carves: that of haptics_node, ordered by
// serials, and the presses of the annotation file, in the order in which they were made. Only the file outlives both programs.
struct UndoMoment {
  std::size_t saved_presses = 0;  // number of presses of the file that were made before
  std::uint32_t source = 0;       // Carves::source of haptics_node's list at that moment; 0: no list had arrived
  std::uint32_t serial = 0;       // the newest serial in that list at that moment

  friend bool operator==(const UndoMoment&, const UndoMoment&) = default;
};

// Finds where moments lie in haptics_node's list of carves. RT: no.
class CarveMoments {
 public:
  // source: Carves::source of the list. saved: the presses of the file; they are recognised in the list by object and beginning of a carve.
  // Takes time in proportion to both lists if the file has presses.
  CarveMoments(const CarveList& list, std::uint32_t source, const std::vector<CarvedPress>& saved);

  // The largest serial in the list among the carves made before that moment; 0: there is none.
  std::uint32_t find_serial(const UndoMoment& moment) const;

 private:
  std::uint32_t source_;
  std::vector<std::uint32_t> serials_;  // [n]: the last serial of the first n presses of the file; 0: none
};

}  // namespace hapton
