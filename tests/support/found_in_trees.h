#pragma once

#include <algorithm>
#include <cstdint>
#include <set>

#include <gtest/gtest.h>

#include "core/collision/touch_geometry.h"

namespace hapton {

// Checks by brute force that the trees find every triangle whose box overlaps the cube of side 0.2 around p (local), and the nearest.
inline void expect_found_in_trees(const TouchGeometry& geometry, std::uint32_t triangle_count, const Vec3& p) {
  const Box query = Box{p, p}.inflated(0.1);
  std::set<std::uint32_t> found;
  geometry.for_each_overlapping(query, [&](std::uint32_t id) { found.insert(id); });
  constexpr double kFar = 1e300;
  double nearest = kFar;
  for (std::uint32_t id = 0; id < triangle_count; ++id) {
    Box box;
    for (int k = 0; k < 3; ++k) box.grow(geometry.corner(id, k));
    if (box.overlaps(query)) {
      EXPECT_TRUE(found.contains(id)) << id;
    }
    nearest = std::min(nearest, geometry.separation(id, p).distance);
  }
  double nearest_by_tree = kFar;
  geometry.visit_nearest(p, kFar, [&](std::uint32_t id, double) {
    nearest_by_tree = std::min(nearest_by_tree, geometry.separation(id, p).distance);
    return nearest_by_tree * nearest_by_tree;
  });
  EXPECT_EQ(nearest_by_tree, nearest);
}

}  // namespace hapton
