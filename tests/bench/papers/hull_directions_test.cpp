#include "bench/papers/hull_directions.h"

#include <gtest/gtest.h>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

TEST(CompareHullDirections, MoreDirectionsThanABoxTestNoMoreTriangles) {
  const auto rows = compare_hull_directions({.seed = 1, .steps = 400, .budget = {.repetitions = 1, .seconds = 0.05}},
                                            Stopwatch::calibrate(), make_bumpy_sphere(0.045, 0.2, 5000, 1));
  ASSERT_TRUE(rows) << rows.error().what;
  ASSERT_EQ(rows->size(), 4U);
  const int directions[] = {6, 14, 18, 26};
  for (std::size_t i = 0; i < 4; ++i) {
    const HullDirections& h = (*rows)[i];
    EXPECT_EQ(h.directions, directions[i]);
    EXPECT_GT(h.local_set.p50_ns, 0.0);
    EXPECT_GE(h.triangles, 64.0) << "fewer than requested";
    EXPECT_EQ(h.structure.nearests.agree, h.structure.nearests.compared) << "wrong results are not a gain";
    EXPECT_EQ(h.structure.segments.agree, h.structure.segments.compared);
  }
  for (std::size_t i = 1; i < 4; ++i) EXPECT_LE((*rows)[i].triangles, 1.05 * (*rows)[0].triangles) << directions[i];
  EXPECT_GT((*rows)[3].structure.bytes, (*rows)[0].structure.bytes);
}

}  // namespace
}  // namespace hapton
