#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "core/collision/box.h"
#include "core/math/types.h"
#include "link/messages.h"

namespace hapton {

using GridPoint = std::array<std::uint32_t, 3>;

// The grid that tiles lie on, one for a scene. A step is a power of two in metres, and the origin a whole number of steps. Every vertex of
// the scene is rounded to the grid once, so that tiles join without cracks, however they arrive.
//
// The scene fills between a quarter and a half of the grid's width along its longest side, so a vertex moves by at most kLargestRounding of
// that side: 21 nm on a scene of 100 mm, 2e-5 N at 1,000 N/m.
// Frame: S. Units: m. RT: yes.
struct PatchGrid {
  static constexpr double kLargestRounding = 0x1p-22 * 0.8660254037844387;  // half a step along each axis, at least 2^22 steps a side

  Vec3 origin_m = Vec3::Zero();
  double step_m = 1.0;

  // Makes a grid centred on the box. Pre: the box is finite and not empty.
  static PatchGrid around(const Box& scene) {
    const double longest = (scene.high - scene.low).maxCoeff();
    PatchGrid grid;
    grid.step_m = longest > 0.0 ? std::ldexp(1.0, std::ilogb(longest) - (kPatchGridBits - 2)) : 1.0;
    const Vec3 middle = (scene.centre() / grid.step_m).array().round();
    grid.origin_m = grid.step_m * (middle - Vec3::Constant(std::ldexp(1.0, kPatchGridBits - 1)));
    return grid;
  }

  // The box of the whole grid. Every part of the scene is touched in this box's local frame, in which a contact offset is a 64th of a step.
  Box box() const noexcept { return {origin_m, origin_m + Vec3::Constant(std::ldexp(step_m, kPatchGridBits))}; }

  // The nearest point of the grid, also for a position outside of it.
  GridPoint round(const Vec3& p_S) const noexcept {
    const Vec3 steps = to_steps(p_S).array().round().max(0.0).min(std::ldexp(1.0, kPatchGridBits) - 1.0);
    return {static_cast<std::uint32_t>(steps.x()), static_cast<std::uint32_t>(steps.y()), static_cast<std::uint32_t>(steps.z())};
  }
  Vec3 to_steps(const Vec3& p_S) const noexcept { return (p_S - origin_m) / step_m; }
  Vec3 at(const GridPoint& g) const noexcept {
    return origin_m + step_m * Vec3(static_cast<double>(g[0]), static_cast<double>(g[1]), static_cast<double>(g[2]));
  }
};

inline Vec3 to_vector(const GridPoint& g) noexcept {
  return {static_cast<double>(g[0]), static_cast<double>(g[1]), static_cast<double>(g[2])};
}

// Write and read a vertex in the form in which PatchTile has it. RT: yes.
inline void write_vertex(PatchTile& tile, std::size_t vertex, const GridPoint& g) noexcept {
  std::uint8_t* byte = tile.vertices.data() + vertex * PatchTile::kVertexBytes;
  for (const std::uint32_t value : g) {
    for (int shift = 0; shift < kPatchGridBits; shift += 8) *byte++ = static_cast<std::uint8_t>(value >> shift);
  }
}
inline GridPoint read_vertex(const PatchTile& tile, std::size_t vertex) noexcept {
  const std::uint8_t* byte = tile.vertices.data() + vertex * PatchTile::kVertexBytes;
  GridPoint g = {};
  for (std::uint32_t& value : g) {
    for (int shift = 0; shift < kPatchGridBits; shift += 8) value |= static_cast<std::uint32_t>(*byte++) << shift;
  }
  return g;
}

// A cube of the octree over the grid. RT: yes.
struct CellKey {
  std::uint32_t level = 0;
  GridPoint index = {};

  std::uint64_t packed() const noexcept {
    std::uint64_t key = level;
    for (const std::uint32_t i : index) key = (key << kPatchDeepestLevel) | i;
    return key;
  }
  CellKey child(std::uint32_t octant) const noexcept {
    return {level + 1, {2 * index[0] + (octant & 1U), 2 * index[1] + ((octant >> 1) & 1U), 2 * index[2] + ((octant >> 2) & 1U)}};
  }
  CellKey parent() const noexcept { return {level - 1, {index[0] / 2, index[1] / 2, index[2] / 2}}; }
  std::uint32_t octant() const noexcept { return (index[0] & 1U) | ((index[1] & 1U) << 1) | ((index[2] & 1U) << 2); }
  // The bounds of the cube, in steps of the grid.
  Box bounds() const noexcept {
    const double width = std::ldexp(1.0, kPatchGridBits - static_cast<int>(level));
    const Vec3 low = width * Vec3(static_cast<double>(index[0]), static_cast<double>(index[1]), static_cast<double>(index[2]));
    return {low, low + Vec3::Constant(width)};
  }
};

}  // namespace hapton
