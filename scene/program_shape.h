#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/triangle_mesh.h"
#include "core/math/types.h"
#include "scene/scene_fit.h"

namespace hapton {

struct ObjectSpec;
struct SealReport;

// An object of a scene that a program deforms (`deformed_by` of the scene file): conversion of its shapes to S. A shape has a displacement
// from rest for each vertex, in m, in the frame of the mesh, before scale and pose. All nodes compute the same vertices, to the bit. RT:
// no. Threads: const calls from any number.
struct ProgramShape {
  static constexpr std::size_t kMaxObjects = 8;        // largest number of such objects in a scene
  static constexpr std::size_t kMaxVertices = 10'000;  // of an object: a shape with this many vertices is prepared for touch in 150 ms

  double reach_m = 0.0;              // largest distance of a vertex from its place at rest; m, in S
  Mat3 to_scene = Mat3::Identity();  // from displacements of a shape to displacements in S

  // The vertices of a shape, in S, from those at rest. Pre: as many displacements as vertices at rest.
  std::vector<Vec3> vertices_of(std::span<const Vec3> rest, std::span<const std::array<float, 3>> displacements_m) const {
    std::vector<Vec3> vertices(rest.begin(), rest.end());
    for (std::size_t v = 0; v < vertices.size(); ++v) {
      const auto& d = displacements_m[v];
      vertices[v] += to_scene * Vec3(d[0], d[1], d[2]);
    }
    return vertices;
  }

  friend bool operator==(const ProgramShape& a, const ProgramShape& b) { return a.reach_m == b.reach_m && a.to_scene == b.to_scene; }
};

// The program shape of an object of a scene file; null: programs do not deform it. mesh: as it is touched at rest, in S after `fit`. RT:
// no. Error: one line with the line in the file: too many vertices; cracks were sealed, so the vertices are not those of the file.
Result<std::shared_ptr<const ProgramShape>> make_program_shape(const ObjectSpec& object, const std::string& name, const SceneFit& fit,
                                                               const TriangleMesh& mesh, const SealReport& sealed);

}  // namespace hapton
