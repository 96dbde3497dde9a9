#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/collision/triangle_pair.h"

namespace hapton {

// Pairs for measuring the memo's unit.
struct EdgePairSettings {
  std::uint64_t seed = 1;
  std::size_t count = 4096;
  double size_m = 1e-3;      // longest edge of each triangle
  double spread_m = 0.1;     // where in the scene a pair lies, in each axis
  double shallowest = 1e-3;  // how long the contact is, as a part of size, evenly over its logarithm
  double deepest = 1e-1;
};

// Pairs of random triangles that collide on edge: an edge of one has passed through an edge of the other, so that each pierces the other
// triangle just inside its boundary, and the contact is short. Memo 3.0: "the triangles should be colliding on edge since this is the most
// stressing case". Checked in extended precision: exactly one piercing edge of each. No angle of a triangle is below 10 degrees and the
// planes cross at 10 degrees or more. RT: no.
std::vector<TrianglePair> make_edge_pairs(const EdgePairSettings& settings);

}  // namespace hapton
