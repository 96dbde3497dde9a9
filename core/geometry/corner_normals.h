#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "core/geometry/shaded_mesh.h"

namespace hapton {

struct CornerNormalReport {
  double crease_angle_rad = 0.0;
  std::size_t filled = 0;       // corners given a normal
  std::size_t normals = 0;      // number of different normals
  std::size_t sharp_edges = 0;  // edges of two triangles whose normals differ by more than the crease angle or whose windings are opposite
  std::size_t creased = 0;      // vertices with more than one normal
  std::string describe() const;
};

// Computes the normals of every corner. At a vertex, triangles joined over edges that are not sharp share one normal, the mean of their
// face normals weighted by their angles there (Thuermer & Wuethrich 1998). Boundary edges, edges of more than two triangles and edges with
// opposite windings are sharp. Triangles without area do not contribute; they get the normal of the fan they lie in. crease_angle: radians,
// 0..pi: the angle between two face normals above which an edge is sharp. Pre: welded vertices, consistent orientation if possible. RT:
// set-up only. Source: FDH paper, 4.1: "with respect to sharp edges fix or fill missing vertex normals".
ShadedMesh fill_corner_normals(const TriangleMesh& mesh, std::span<const std::uint32_t> source, double crease_angle,
                               CornerNormalReport& report);

// The same for vertices that have moved: the sharing of normals is kept, the normals are recomputed. faces: number of triangles of the mesh
// itself; the triangles of fans after them do not contribute. Where the face normals cancel, corners share that of their first face;
// without a face that has an area, the z axis. Pre: mesh.vertices are the new ones. RT: no (linear), but no heap.
void update_corner_normals(ShadedMesh& mesh, std::size_t faces);

struct AuthoredNormalReport {
  std::size_t given = 0;  // corners with an authored normal
  std::size_t used = 0;   // how many of them are finite, not zero, and less than 85 degrees off the outer side of their face
  std::string describe() const;
};

// The report that use_authored_normals would return.
AuthoredNormalReport count_authored_normals(const TriangleMesh& mesh);

// Gives each corner its authored normal where that is valid; the others keep theirs from fill_corner_normals. Equal authored normals at a
// vertex are shared. A triangle without area has no outer side and keeps the computed ones. Pre: shaded has the mesh's triangles, in order.
// RT: set-up only.
AuthoredNormalReport use_authored_normals(const TriangleMesh& mesh, ShadedMesh& shaded);

// The unit vector midway between two normals of the mesh; the first normal if they are opposite.
Vec3 middle_normal_of(const ShadedMesh& mesh, const std::array<std::uint32_t, 2>& between);

struct NormalCheckReport {
  std::size_t not_unit = 0;     // not finite or not of length one; replaced by the face's normal
  std::size_t turned_away = 0;  // 85 degrees or more off the face's normal; replaced by it
  std::size_t repaired() const { return not_unit + turned_away; }
  std::string describe() const;
};

// Final check of the normals: a corner's normal that is not finite, not of length one or not on its face's side is replaced by the normal
// of the face, or by the z axis where there is none. faces: number of triangles that have a side; the triangles of fans after them need
// unit normals only. RT: set-up only. Source: FDH paper, 4.1: "final validation of normal vectors".
NormalCheckReport repair_corner_normals(ShadedMesh& mesh, std::size_t faces = ~std::size_t{0});

}  // namespace hapton
