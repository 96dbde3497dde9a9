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
  double crease_angle_rad = 40.0 * 3.14159265358979323846 / 180.0;  // faces that turn by more meet in a sharp edge
  double longest_edge = 1.0 / 16.0;                                 // of the box's diagonal: longer edges are halved; 0: never
  double simplify_error_m = 0.0;  // how far from the new surface merging small triangles may leave a vertex; 0: never
  double growth = 4.0;            // splitting stops before there are so many times the triangles (and 100,000 more)
};

// What each pass did.
struct SmoothSurfaceReport {
  RepairReport repair;
  SimplifyReport simplify;
  CornerNormalReport normals;
  NormalCheckReport check;
  SplitReport split;
  NormalFanReport fans;
  NormalCheckReport final_check;

  std::vector<std::string> lines() const;  // one a pass, in the order they ran
};

// What a triangle of a prepared surface is.
enum class SurfaceKind : std::uint8_t {
  face,        // a triangle
  edge_fan,    // fake: two different points (fdh-rendering.txt, fig. 1)
  corner_fan,  // fake: one point
};

// A mesh prepared for fdh-rendering.txt, section 4.1: repaired, every corner with its normal, large triangles split, fake triangles between
// normals that disagree. Faces first, then edge fans, then corner fans.
// The passes run in this order: repair (list of triangles, common edges), simplify, normals, check, split, fans, final check. The paper
// splits after it adds the fake triangles; here it is before, so that nothing fake needs splitting. The result is the same.
struct SmoothSurface {
  ShadedMesh mesh;
  std::size_t face_count = 0;
  std::vector<std::uint32_t> vertex_source;  // of the vertices that were not made by splitting: their index in the mesh as it came

  SurfaceKind kind(std::size_t triangle) const {
    if (triangle < face_count) return SurfaceKind::face;
    const Triangle& t = mesh.triangles[triangle];
    return t[0] == t[1] && t[1] == t[2] ? SurfaceKind::corner_fan : SurfaceKind::edge_fan;
  }

  // The vertices of the mesh as it came have moved: positions and normals follow; what is connected, sharp or split stays as it is.
  // Pre: as many vertices as it came with. RT: no (linear in the mesh), but no heap.
  void move_vertices(std::span<const Vec3> vertices);
};

// RT: set-up only. Pre: indices in range, coordinates finite. Error: an impossible setting; nothing left that has an area.
Result<SmoothSurface> make_smooth_surface(const TriangleMesh& mesh, const SmoothSurfaceSettings& settings, SmoothSurfaceReport& report);

}  // namespace hapton
