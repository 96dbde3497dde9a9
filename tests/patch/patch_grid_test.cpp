#include "patch/patch_grid.h"

#include <gtest/gtest.h>

#include <random>

namespace hapton {
namespace {

TEST(PatchGrid, MovesAVertexByNoMoreThanItsLargestRounding) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (int trial = 0; trial < 2000; ++trial) {
    const double longest = std::pow(10.0, 18.0 * unit(random) - 9.0);
    const Vec3 low = longest * 100.0 * Vec3(unit(random), unit(random), unit(random));
    const Box box{low, low + longest * Vec3(1.0, unit(random), unit(random))};
    const PatchGrid grid = PatchGrid::around(box);
    for (int n = 0; n < 20; ++n) {
      const Vec3 p = box.low + (box.high - box.low).cwiseProduct(Vec3(unit(random), unit(random), unit(random)));
      const GridPoint g = grid.round(p);
      for (const std::uint32_t value : g) ASSERT_LT(value, 1U << kPatchGridBits);
      ASSERT_LE((grid.at(g) - p).norm(), PatchGrid::kLargestRounding * (box.high - box.low).maxCoeff() * (1.0 + 1e-6));
      ASSERT_EQ(grid.round(grid.at(g)), g) << "what lies on it stays";
    }
  }
}

// Every vertex that a tile can hold lies in the box of the grid, so it can be a part of the scene.
TEST(PatchGrid, ItsBoxHoldsAllThatTilesCanHold) {
  const PatchGrid grid = PatchGrid::around({Vec3(0.1, 0.2, 0.3), Vec3(0.13, 0.21, 0.5)});
  constexpr std::uint32_t kLast = (1U << kPatchGridBits) - 1;
  for (const GridPoint& g : {GridPoint{0, 0, 0}, GridPoint{kLast, kLast, kLast}, GridPoint{0, kLast, 77}}) {
    EXPECT_EQ(grid.box().distance_squared(grid.at(g)), 0.0);
  }
}

TEST(PatchGrid, AroundOnePointItKeepsThatPoint) {
  const Vec3 p(1.0, -2.0, 3.0);
  const PatchGrid grid = PatchGrid::around({p, p});
  EXPECT_EQ(grid.at(grid.round(p)), p);
}

TEST(PatchGrid, AVertexComesBackFromItsBytes) {
  PatchTile tile;
  const GridPoint g = {0x123456, 0, 0xFFFFFF};
  write_vertex(tile, PatchTile::kMaxVertices - 1, g);
  EXPECT_EQ(read_vertex(tile, PatchTile::kMaxVertices - 1), g);
}

TEST(CellKey, ChildrenFillTheirParent) {
  const CellKey parent{3, {1, 7, 2}};
  double volume = 0.0;
  for (std::uint32_t octant = 0; octant < 8; ++octant) {
    const CellKey child = parent.child(octant);
    EXPECT_EQ(child.octant(), octant);
    EXPECT_EQ(child.parent().packed(), parent.packed());
    EXPECT_NE(child.packed(), parent.packed());
    EXPECT_TRUE((child.bounds().low.array() >= parent.bounds().low.array()).all());
    EXPECT_TRUE((child.bounds().high.array() <= parent.bounds().high.array()).all());
    volume += (child.bounds().high - child.bounds().low).prod();
  }
  EXPECT_EQ(volume, (parent.bounds().high - parent.bounds().low).prod());
}

}  // namespace
}  // namespace hapton
