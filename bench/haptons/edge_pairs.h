#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/collision/triangle_pair.h"

namespace hapton {

// Pairs of triangles for counting haptons, the memo's unit (docs/glossary.md). The scale is that of a scanned mesh of 100 mm with triangles
// of 1 mm; the other numbers are free choices.
struct EdgePairSettings {
  std::uint64_t seed = 1;
  std::size_t count = 4096;
  double size_m = 1e-3;      // longest edge of each triangle
  double spread_m = 0.1;     // a pair's position is drawn between - and + this along each axis
  double shallowest = 1e-3;  // shortest contact, as a share of size_m; the logarithm of the length is drawn uniformly
  double deepest = 1e-1;     // longest contact, as a share of size_m
};

// Pairs of random triangles that collide on edge: an edge of one has passed through an edge of the other, so that each pierces the other
// triangle just inside its boundary, and the contact is short. Memo 3.0: "the triangles should be colliding on edge since this is the most
// stressing case". Checked in extended precision: exactly one edge of each triangle pierces the other. No angle of a triangle and no angle
// between the two planes is below 10 degrees: a free choice that excludes nearly degenerate triangles. Frame: any. RT: no. Threads: any.
std::vector<TrianglePair> make_edge_pairs(const EdgePairSettings& settings);

}  // namespace hapton
