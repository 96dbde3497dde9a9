#pragma once

#include <algorithm>
#include <cstdint>
#include <set>

#include <gtest/gtest.h>

#include "core/collision/touch_geometry.h"

namespace hapton {

// Checks by brute force that the trees find every triangle whose box overlaps the cube of side 0.2 around p (local), and the nearest.
inline void expect_found_in_trees(const TouchGeometry& geometry, std::uint32_t triangles, const Vec3& p) {
  const Box query = Box{p, p}.inflated(0.1);
  std::set<std::uint32_t> found;
  geometry.for_each_overlapping(query, [&](std::uint32_t id) { found.insert(id); });
  constexpr double kFar = 1e300;
  double nearest = kFar;
  for (std::uint32_t id = 0; id < triangles; ++id) {
    Box box;
    for (int k = 0; k < 3; ++k) box.grow(geometry.corner(id, k));
    if (box.overlaps(query)) {
      EXPECT_TRUE(found.contains(id)) << id;
    }
    nearest = std::min(nearest, geometry.separation(id, p).distance);
  }
  double by_tree = kFar;
  geometry.visit_nearest(p, kFar, [&](std::uint32_t id, double) {
    by_tree = std::min(by_tree, geometry.separation(id, p).distance);
    return by_tree * by_tree;
  });
  EXPECT_EQ(by_tree, nearest);
}

}  // namespace hapton
