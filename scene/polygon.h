#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// Largest number of corners of a polygon that is not convex, because ear clipping takes quadratic time.
constexpr std::size_t kMaxPolygonCorners = 1024;

// Appends corners.size() - 2 triangles that cover the polygon, with its winding: a fan if it is convex, otherwise by ear clipping. One that
// cannot be clipped, because it crosses itself or has no area, gets a fan with as many triangles. False, and nothing appended: not convex,
// with more than kMaxPolygonCorners corners. work: null, or raised by the number of tests of a corner against a triangle, at most 4
// corners.size()^2. Pre: corners.size() >= 3, every corner < vertices.size(). RT: set-up only.
bool triangulate_polygon(std::span<const std::uint32_t> corners, std::span<const Vec3> vertices, std::vector<Triangle>& into,
                         std::size_t* work = nullptr);

}  // namespace hapton
