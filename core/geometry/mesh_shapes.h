#pragma once

#include <cstdint>
#include <vector>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// Generated meshes: pure functions of their arguments, centred on the origin unless stated otherwise, normals outwards, vertices welded.
// All are closed except make_plane_grid. RT: set-up only. Pre: positive sizes and counts.

// Icosahedron subdivided `level` times: 20 * 4^level triangles, every vertex on the sphere.
TriangleMesh make_icosphere(double radius_m, int level);

// Box with cells x cells squares of two triangles on each side.
TriangleMesh make_box(const Vec3& size_m, int cells = 1);

// Prism over a regular polygon with its corners on the circle, axis z, capped by fans around the axis.
TriangleMesh make_cylinder(double radius_m, double height_m, int sides, int layers = 1);

// Torus about z with all vertices on the exact surface, around_axis of them around the axis times around_tube around the tube.
TriangleMesh make_torus(double ring_radius_m, double tube_radius_m, int around_axis, int around_tube);

// Open square sheet in z = 0, normal +z, cells x cells squares.
TriangleMesh make_plane_grid(double side_m, int cells);

// Icosphere of the lowest level with at least min_triangles triangles. Its radius varies with smooth waves, drawn from the seed, of the
// given height relative to the radius. For min_triangles = 1,000,000 it has 1,310,720 triangles.
TriangleMesh make_bumpy_sphere(double radius_m, double relative_height, std::size_t min_triangles, std::uint64_t seed);

// Icosphere of the lowest level with at least min_triangles triangles, roughened by eight waves of the same length in random directions,
// drawn from the seed, so that the root mean square of the normal curvatures of the surface is 1 / curvature_radius_m.
// With wave number k and height A a wave along the unit vector d bends the surface in direction u by A k^2 (d.u)^2 times a sine; the mean
// of (d.u)^4 over directions is 1/5, of the squared sine 1/2, so eight waves give A k^2 sqrt(8 / 10), and A = sqrt(10 / 8) curvature_radius
// / (curvature_radius k)^2. The root mean square slope is sqrt(10 / 6) / (curvature_radius k): below 1 for a wavelength below 4.8
// curvature_radius. Pre: wavelength_m and curvature_radius_m are small compared with radius_m.
TriangleMesh make_rough_sphere(double radius_m, double curvature_radius_m, double wavelength_m, std::size_t min_triangles,
                               std::uint64_t seed);

// A closed plate in the x-y plane, thin along z.
TriangleMesh make_thin_wall(double side_m, double thickness_m, int cells);

// Prism over a simple counter-clockwise polygon in x-y, of length_m along z in that many layers. Caps by ear clipping.
TriangleMesh make_prism(const std::vector<Eigen::Vector2d>& outline_m, double length_m, int layers);

// A block of side_m with a V groove along z in its top (+y) face: opening_rad between the walls, or less: at most 0.9 side_m wide.
TriangleMesh make_gutter(double side_m, double depth_m, double opening_rad, int layers);

// A block of side_m whose top is a flight of equal steps rising along x.
TriangleMesh make_staircase(double side_m, int steps, int layers);

// A block with a pit in its top (+z): a square pyramid upside down, whose four walls meet in a concave apex.
TriangleMesh make_pit(double side_m, double depth_m);

// The same mesh with every triangle flipped, and its authored normals reversed.
TriangleMesh flipped(TriangleMesh mesh);

// The same mesh scaled about the origin, then moved.
TriangleMesh scaled_and_moved(TriangleMesh mesh, double scale, const Vec3& move_m);

// Both meshes as one; vertices are not welded.
TriangleMesh joined(const TriangleMesh& first, const TriangleMesh& second);

}  // namespace hapton
