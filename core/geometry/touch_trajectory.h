#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/triangle_mesh.h"

namespace hapton {

// A prescribed motion of the device for replays and benches, one row every 1 / rate_hz. All lengths scale with the mesh: "mm" below means a
// hundredth of its longest side, which is 1 mm for a mesh of 100 mm.
struct TrajectorySettings {
  std::uint64_t seed = 1;
  std::size_t rows = 20000;
  double rate_hz = 1000.0;
};

struct TouchTrajectory {
  std::vector<Vec3> p_SD;       // device, frame S, metres
  std::size_t reset_every = 0;  // contact is reset before rows 0, n, 2n ...; 0: only before row 0
};

// Segments of 4 s: 200 ms approach from 5 mm outside to 1.5 mm inside a random position, then a walk over the surface at 100 mm/s with the
// target 1 to 2 mm deep (a sine of 0.8 s) along the inward normal, low-passed with 20 ms. Error: no triangle has an area.
Result<TouchTrajectory> make_slide_trajectory(const TriangleMesh& mesh, const TrajectorySettings& settings);

// Orbits around the mesh in 4 s, without contact: 1 to 11 mm outside all vertices within 11 mm of the plane of the orbit.
Result<TouchTrajectory> make_free_trajectory(const TriangleMesh& mesh, const TrajectorySettings& settings);

// Taps of 40 ms at 500 mm/s: from 5 mm outside straight to 1.5 mm inside and back. The first third at random positions, then at vertices,
// then at edge midpoints. Contact is reset between taps.
Result<TouchTrajectory> make_tap_trajectory(const TriangleMesh& mesh, const TrajectorySettings& settings);

// A smooth random walk through a box a fifth larger than the mesh's, up to about 500 mm/s, in and out at random.
Result<TouchTrajectory> make_random_walk(const TriangleMesh& mesh, const TrajectorySettings& settings);

}  // namespace hapton
