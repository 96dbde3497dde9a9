#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/corner_normals.h"
#include "core/geometry/normal_fans.h"
#include "core/geometry/repair_mesh.h"
#include "core/geometry/shaded_mesh.h"
#include "core/geometry/simplify_small.h"
#include "core/geometry/split_large.h"

namespace hapton {

struct SmoothSurfaceSettings {
  double crease_angle_rad = 40.0 * 3.14159265358979323846 / 180.0;  // a larger angle between two faces' normals makes their edge sharp
  double longest_edge = 1.0 / 16.0;                                 // as a share of the box's diagonal: longer edges are halved; 0: never
  double simplify_error_m = 0.0;  // largest distance by which merging may move a vertex off the surface; 0: no merging
  double growth = 4.0;            // splitting stops at this multiple of the triangles (plus 100,000)
};

// The report of each pass.
struct SmoothSurfaceReport {
  RepairReport repair;
  SimplifyReport simplify;
  CornerNormalReport normals;
  NormalCheckReport check;
  SplitReport split;
  NormalFanReport fans;
  NormalCheckReport final_check;

  std::vector<std::string> lines() const;  // one line for each pass, in order
};

// Kinds of triangles of a prepared surface.
enum class SurfaceKind : std::uint8_t {
  face,        // a triangle
  edge_fan,    // degenerate: two different points (FDH paper, fig. 1)
  corner_fan,  // degenerate: one point
};

// A mesh prepared as in section 4.1 of the FDH paper: repaired, with a normal at every corner, large triangles split, and degenerate
// triangles (the "fake triangles" of the paper) between normals that differ. Faces come first, then edge fans, then corner fans. Order of
// the passes: repair (list of triangles, common edges), simplify, normals, check, split, fans, final check. The paper splits after it adds
// the degenerate triangles; here splitting comes first, so that none of them needs splitting. The result is the same.
struct SmoothSurface {
  ShadedMesh mesh;
  std::size_t face_count = 0;
  std::vector<std::uint32_t> vertex_source;  // for each vertex not made by splitting: its number in the original mesh

  SurfaceKind kind(std::size_t triangle) const {
    if (triangle < face_count) return SurfaceKind::face;
    const Triangle& t = mesh.triangles[triangle];
    return t[0] == t[1] && t[1] == t[2] ? SurfaceKind::corner_fan : SurfaceKind::edge_fan;
  }

  // Moves the vertices to new positions of the vertices of the original mesh; normals follow. What is connected, sharp or split stays so.
  // Pre: `vertices` has as many as the original mesh. RT: no, because time is linear in the mesh; but no heap.
  void move_vertices(std::span<const Vec3> vertices);
};

// Error: an impossible setting, or no triangle is left after repair. Pre: indices in range, coordinates finite. RT: set-up only.
Result<SmoothSurface> make_smooth_surface(const TriangleMesh& mesh, const SmoothSurfaceSettings& settings, SmoothSurfaceReport& report);

}  // namespace hapton
