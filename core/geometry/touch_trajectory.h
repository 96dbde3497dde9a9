#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/triangle_mesh.h"

namespace hapton {

// A prescribed motion of the device for replays and benches, one row every 1 / rate_hz. All lengths scale with the mesh: "mm" below means a
// hundredth of its longest side, which is 1 mm for a mesh of 100 mm. Error of all: no triangle has an area. RT: set-up only.
struct TrajectorySettings {
  std::uint64_t seed = 1;
  std::size_t rows = 20000;
  double rate_hz = 1000.0;
};

struct TouchTrajectory {
  std::vector<Vec3> p_SD;       // position of the device in frame S, metres
  std::size_t reset_every = 0;  // contact is reset before rows 0, n, 2n ...; 0: only before row 0
};

// Segments of 4 s: an approach of 200 ms from 5 mm outside to 1.5 mm inside a random position, then a walk over the surface at 100 mm/s
// with the device 1 to 2 mm deep (a sine of 0.8 s) along the inward normal, which is low-pass filtered with a time constant of 20 ms.
Result<TouchTrajectory> make_slide_trajectory(const TriangleMesh& mesh, const TrajectorySettings& settings);

// Orbits of 4 s around the mesh, without contact: 1 to 11 mm outside a smooth outline of all triangles within 12 mm of the orbit's plane.
Result<TouchTrajectory> make_free_trajectory(const TriangleMesh& mesh, const TrajectorySettings& settings);

// Taps of 40 ms at 500 mm/s: from 5 mm outside straight to 1.5 mm inside and back. The first third is at random positions, the second at
// vertices, the last at midpoints of edges. Contact is reset between taps.
Result<TouchTrajectory> make_tap_trajectory(const TriangleMesh& mesh, const TrajectorySettings& settings);

// A smooth random walk, at 250 mm/s r.m.s. along each axis, in a box a fifth larger than the mesh's and 5 mm more on each side.
Result<TouchTrajectory> make_random_walk(const TriangleMesh& mesh, const TrajectorySettings& settings);

}  // namespace hapton
