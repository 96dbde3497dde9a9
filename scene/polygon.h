#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// A polygon that is not convex may have this many corners: cutting ears off is at least quadratic.
constexpr std::size_t kMaxPolygonCorners = 1024;

// Appends corners.size() - 2 triangles that cover the polygon with its own winding: a fan when it is convex, ears cut off
// otherwise. A polygon that crosses itself or has no area still gives that many triangles, a fan.
// False, and nothing appended, when it has too many corners. Pre: corners.size() >= 3, every corner < vertices.size().
// RT: set-up only.
bool triangulate_polygon(std::span<const std::uint32_t> corners, std::span<const Vec3> vertices, std::vector<Triangle>& into);

}  // namespace hapton
