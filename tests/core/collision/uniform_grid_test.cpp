#include "core/collision/uniform_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>
#include <set>
#include <utility>

#include "core/collision/triangle_box.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

using Corners = std::array<Vec3, 3>;

std::vector<Corners> corners_of(const TriangleMesh& mesh) {
  std::vector<Corners> all;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    all.push_back({mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)});
  }
  return all;
}

// The nominal cell, grown (or shrunk) by a share of its size.
std::pair<Vec3, Vec3> cell_limits(const UniformGrid& grid, int x, int y, int z, double grow) {
  const Vec3 size = (grid.high() - grid.low()).cwiseQuotient(Vec3(grid.division()[0], grid.division()[1], grid.division()[2]));
  const Vec3 low = grid.low() + size.cwiseProduct(Vec3(x, y, z));
  return {low - grow * size, low + (1.0 + grow) * size};
}

// Long thin triangles between random points.
TriangleMesh slivers(std::uint64_t seed, std::uint32_t count) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i < count; ++i) {
    const Vec3 from(unit(random), unit(random), unit(random));
    mesh.vertices.insert(mesh.vertices.end(), {from, Vec3(unit(random), unit(random), unit(random)), from + Vec3(1e-4, 0.0, 0.0)});
    mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return mesh;
}

TEST(UniformGrid, ListsAreThoseOfAllTrianglesAgainstAllCells) {
  constexpr std::uint64_t kSeed = 21;
  RecordProperty("seed", std::to_string(kSeed));
  for (const auto& mesh :
       {made::soup(kSeed, 200, 1.0, 0.8), made::sphere(0.1, 12, 0.2), made::box(Vec3::Zero(), Vec3(1, 2, 3)), slivers(kSeed, 100)}) {
    const auto triangles = corners_of(mesh);
    const auto grid = UniformGrid::make(triangles, {7, 5, 9});
    ASSERT_TRUE(grid);
    std::size_t entries = 0;
    for (int z = 0; z < 9; ++z) {
      for (int y = 0; y < 5; ++y) {
        for (int x = 0; x < 7; ++x) {
          const auto listed = grid->triangles_in(x, y, z);
          entries += listed.size();
          ASSERT_TRUE(std::is_sorted(listed.begin(), listed.end()));
          ASSERT_EQ(std::set<std::uint32_t>(listed.begin(), listed.end()).size(), listed.size());
          const auto [tight_low, tight_high] = cell_limits(*grid, x, y, z, -1e-9);
          const auto [loose_low, loose_high] = cell_limits(*grid, x, y, z, 1e-9);
          for (std::uint32_t t = 0; t < triangles.size(); ++t) {
            const bool is_listed = std::binary_search(listed.begin(), listed.end(), t);
            if (may_touch(triangles[t], tight_low, tight_high)) {
              ASSERT_TRUE(is_listed) << "triangle " << t << " missing from " << x << ' ' << y << ' ' << z;
            }
            if (!may_touch(triangles[t], loose_low, loose_high)) {
              ASSERT_FALSE(is_listed) << "triangle " << t << " needlessly in " << x << ' ' << y << ' ' << z;
            }
          }
        }
      }
    }
    EXPECT_EQ(grid->occupancy().entries, entries);
  }
}

TEST(UniformGrid, EveryPointOfATriangleIsInACellThatListsIt) {
  constexpr std::uint64_t kSeed = 4;
  RecordProperty("seed", std::to_string(kSeed));
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (const double scale : {1e-6, 1.0, 1e6}) {
    auto mesh = made::soup(kSeed, 300, scale, scale);
    for (Vec3& v : mesh.vertices) {
      v += scale * Vec3(11.3, 0.7, -5.1);
    }
    const auto triangles = corners_of(mesh);
    const auto grid = UniformGrid::make(triangles, {32, 32, 32});
    ASSERT_TRUE(grid);
    std::size_t inside_count = 0;
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
      for (int i = 0; i < 100; ++i) {
        const double s = i < 3 ? 0.0 : unit(random);
        const double r = i < 3 ? 0.0 : (1 - s) * unit(random);
        const Vec3 p = i < 3 ? triangles[t][static_cast<std::size_t>(i)]
                             : Vec3(triangles[t][0] + s * (triangles[t][1] - triangles[t][0]) + r * (triangles[t][2] - triangles[t][0]));
        const CellBox box = grid->find_cells(p, p);
        if (box.end[0] == 0) {
          continue;  // p is outside the grid by rounding
        }
        ++inside_count;
        const auto listed = grid->triangles_in(box.begin[0], box.begin[1], box.begin[2]);
        ASSERT_TRUE(std::binary_search(listed.begin(), listed.end(), t)) << "triangle " << t << " scale " << scale;
      }
    }
    EXPECT_GT(inside_count, 99 * triangles.size()) << "of 100 points of each triangle, nearly all are inside the grid";
  }
}

TEST(UniformGrid, OccupancyOfAKnownScene) {
  // A sheet in z = 0 with a lone triangle above it, so that the sheet fills the lowest of four layers.
  auto mesh = made::sheet(1.0, 0.0, 1);
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), {Vec3(0.9, 0.9, 4.0), Vec3(0.95, 0.9, 4.0), Vec3(0.9, 0.95, 4.0)});
  mesh.triangles.push_back({first, first + 1, first + 2});
  const auto grid = UniformGrid::make(corners_of(mesh), {2, 2, 4});
  ASSERT_TRUE(grid);
  // The diagonal of the sheet runs through two of the lowest cells and touches a corner of the other two.
  EXPECT_EQ(grid->occupancy().cells, 16U);
  EXPECT_EQ(grid->occupancy().occupied_cells, 5U);
  EXPECT_EQ(grid->occupancy().max_triangles_a_cell, 2U);
  EXPECT_EQ(grid->occupancy().entries, 9U);  // the two triangles of the sheet in four cells each, and the lone one
  EXPECT_DOUBLE_EQ(grid->occupancy().mean_triangles_a_cell(), 9.0 / 5.0);
  EXPECT_DOUBLE_EQ(grid->occupancy().occupied_share(), 5.0 / 16.0);
}

TEST(UniformGrid, FlatSceneHasOneLayer) {
  const auto grid = UniformGrid::make(corners_of(made::sheet(1.0, 0.5, 4)), {8, 8, 8});
  ASSERT_TRUE(grid);
  EXPECT_EQ(grid->division(), (std::array<int, 3>{8, 8, 1}));
  const CellBox box = grid->find_cells({0.1, 0.1, 0.4}, {0.1, 0.1, 0.6});
  EXPECT_EQ(box.end[2] - box.begin[2], 1);
  EXPECT_FALSE(grid->triangles_in(box.begin[0], box.begin[1], 0).empty());
}

TEST(UniformGrid, CoversExactlyTheCellsOfABox) {
  const auto grid = UniformGrid::make(corners_of(made::box(Vec3::Zero(), Vec3::Ones())), {10, 10, 10});
  ASSERT_TRUE(grid);
  const CellBox some = grid->find_cells({0.15, 0.25, 0.35}, {0.16, 0.45, 0.95});
  EXPECT_EQ(some.begin, (std::array<int, 3>{1, 2, 3}));
  EXPECT_EQ(some.end, (std::array<int, 3>{2, 5, 10}));
  const CellBox all = grid->find_cells(Vec3::Constant(-1e300), Vec3::Constant(1e300));
  EXPECT_EQ(all.begin, (std::array<int, 3>{0, 0, 0}));
  EXPECT_EQ(all.end, (std::array<int, 3>{10, 10, 10}));
  const CellBox none = grid->find_cells({1.1, 0, 0}, {1.2, 1, 1});
  EXPECT_EQ(none.begin, none.end);
}

// The triangle runs from corner to corner of 256 x 256 x 16 cells. It touches some hundreds of the million cells in its bounding box.
TEST(UniformGrid, ALongThinTriangleCostsTheCellsThatItTouches) {
  const std::vector<Corners> diagonal = {{Vec3(0, 0, 0), Vec3(1, 1, 1), Vec3(1e-3, 0, 0)}};
  const auto grid = UniformGrid::make(diagonal, {256, 256, 16});
  ASSERT_TRUE(grid);
  const std::size_t listings = grid->occupancy().entries;
  EXPECT_GT(listings, 256U);
  EXPECT_LT(listings, 2048U);
  // The triangle is counted and listed: each time at most both halves are tested for each listing, at each of the 20 halvings.
  EXPECT_LE(grid->work(), 2 * (1 + 2 * 20 * listings));
}

TEST(UniformGrid, AnInfiniteBoxHasAllCells) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const auto& mesh : {made::sheet(1.0, 0.5, 4), made::box(Vec3::Zero(), Vec3::Ones())}) {
    const auto grid = UniformGrid::make(corners_of(mesh), {8, 8, 8});
    ASSERT_TRUE(grid);
    const CellBox all = grid->find_cells(Vec3::Constant(-kInfinity), Vec3::Constant(kInfinity));
    EXPECT_EQ(all.begin, (std::array<int, 3>{0, 0, 0}));
    EXPECT_EQ(all.end, grid->division());
  }
}

TEST(UniformGrid, OneCellHoldsWhatIsTooSmallToDivide) {
  const double tiny = 0x1p-1040;
  const std::vector<Corners> small = {{Vec3(0, 0, 0), Vec3(tiny, 0, 0), Vec3(0, tiny, tiny)},
                                      {Vec3(tiny, tiny, tiny), Vec3(0, 0, 0), Vec3(tiny, 0, 0)}};
  const auto grid = UniformGrid::make(small, {8, 8, 8});
  ASSERT_TRUE(grid);
  EXPECT_EQ(grid->division(), (std::array<int, 3>{1, 1, 1}));
  EXPECT_EQ(grid->triangles_in(0, 0, 0).size(), 2U);
}

TEST(UniformGrid, ABoxThatIsNotANumberHasNoCells) {
  const auto grid = UniformGrid::make(corners_of(made::box(Vec3::Zero(), Vec3::Ones())), {10, 10, 10});
  ASSERT_TRUE(grid);
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  for (int axis = 0; axis < 3; ++axis) {
    for (const auto& [low, high] : {std::pair(kNan, 0.6), std::pair(0.4, kNan), std::pair(kNan, kNan)}) {
      Vec3 from = Vec3::Constant(0.4);
      Vec3 to = Vec3::Constant(0.6);
      from[axis] = low;
      to[axis] = high;
      const CellBox none = grid->find_cells(from, to);
      EXPECT_EQ(none.begin, none.end) << "axis " << axis << ": " << low << " to " << high;
    }
  }
}

TEST(UniformGrid, RejectsInvalidDivisionsAndAnEmptyScene) {
  const auto triangles = corners_of(made::box(Vec3::Zero(), Vec3::Ones()));
  EXPECT_FALSE(UniformGrid::make(triangles, {0, 32, 32}));
  EXPECT_FALSE(UniformGrid::make(triangles, {32, 1025, 32}));
  EXPECT_FALSE(UniformGrid::make(triangles, {1024, 1024, 1024}));
  EXPECT_FALSE(UniformGrid::make({}, {32, 32, 32}));
}

}  // namespace
}  // namespace hapton
