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
  std::size_t normals = 0;      // different ones
  std::size_t sharp_edges = 0;  // of two triangles, with a larger angle between their normals than the crease angle
  std::size_t creased = 0;      // vertices with more than one normal
  std::string describe() const;
};

// Computes the normals of every corner. At a vertex, triangles joined over edges that are not sharp share one normal, the mean of their
// face normals weighted by their angles at the vertex (Thuermer & Wuethrich 1998). Boundary edges and edges of more than two triangles are
// sharp. Triangles without area do not contribute; they get the normal of the fan that they lie in. crease_angle: radians, 0..pi: the angle
// between the normals of two faces above which their edge is sharp. Pre: welded vertices, consistent orientation where there is one. RT:
// set-up only. Source: FDH paper, 4.1: "with respect to sharp edges fix or fill missing vertex normals".
ShadedMesh fill_corner_normals(const TriangleMesh& mesh, std::span<const std::uint32_t> source, double crease_angle,
                               CornerNormalReport& report);

// The same for vertices that have moved: the sharing of normals is kept, the normals are recomputed. faces: number of triangles of the mesh
// itself; the fans that follow them do not contribute. Pre: mesh.vertices are the new ones. RT: no (linear in the mesh), but no heap.
void update_corner_normals(ShadedMesh& mesh, std::size_t faces);

struct AuthoredNormalReport {
  std::size_t given = 0;  // corners with an authored normal
  std::size_t used = 0;   // of them: finite, not zero, less than 85 degrees off the outer side of their face
  std::string describe() const;
};

// The report that use_authored_normals would return.
AuthoredNormalReport count_authored_normals(const TriangleMesh& mesh);

// Gives each corner its authored normal where that is valid; the others keep theirs from fill_corner_normals. Equal ones at a vertex are
// shared. A triangle without area has no outer side and keeps the computed ones. Pre: shaded has the mesh's triangles, in order. RT: set-up
// only.
AuthoredNormalReport use_authored_normals(const TriangleMesh& mesh, ShadedMesh& shaded);

// Midway between two normals; the first if they are opposite.
Vec3 middle_normal_of(const ShadedMesh& mesh, const std::array<std::uint32_t, 2>& between);

struct NormalCheckReport {
  std::size_t not_unit = 0;     // not finite or not of length one; replaced by the face's
  std::size_t turned_away = 0;  // 85 degrees or more off its own face; replaced by the face's
  std::size_t repaired() const { return not_unit + turned_away; }
  std::string describe() const;
};

// Final check of the normals: a corner's normal that is not finite, not of length one or not on its own face's side is replaced by the
// face's. faces: number of triangles that have a side; the fans that follow them need unit normals only. RT: set-up only. Source:
// FDH paper, 4.1: "final validation of normal vectors".
NormalCheckReport check_corner_normals(ShadedMesh& mesh, std::size_t faces = ~std::size_t{0});

}  // namespace hapton
