#include "patch/tile_partition.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>

#include "patch/patch_store.h"
#include "tests/patch/patch_stage.h"

namespace hapton {
namespace {

using Corners = std::array<GridPoint, 3>;

std::multiset<Corners> triangles_of(const std::vector<PatchTile>& tiles) {
  std::multiset<Corners> all;
  for (const PatchTile& tile : tiles) {
    for (std::size_t t = 0; t < tile.triangle_count; ++t) {
      const std::uint8_t* v = tile.triangles.data() + 3 * t;
      all.insert({read_vertex(tile, v[0]), read_vertex(tile, v[1]), read_vertex(tile, v[2])});
    }
  }
  return all;
}

std::multiset<Corners> triangles_of(const TouchScene& scene, const PatchGrid& grid) {
  std::multiset<Corners> all;
  for (const TouchObject& object : scene.objects) {
    for (const Triangle& t : object.mesh->triangles) {
      const Corners c = {grid.round(object.mesh->vertices[t[0]]), grid.round(object.mesh->vertices[t[1]]),
                         grid.round(object.mesh->vertices[t[2]])};
      if (c[0] != c[1] && c[1] != c[2] && c[2] != c[0]) all.insert(c);
    }
  }
  return all;
}

TouchScene two_objects() {
  TouchScene scene = scene_of(wavy_sheet(0.05, 40), {.stiffness_n_per_m = 700.0, .friction_static = 0.4, .friction_dynamic = 0.3});
  scene.objects.push_back({made::shared(made::soup(3, 500, 0.05, 0.02)), {.damping_ns_per_m = 2.0, .two_sided = false}});
  return scene;
}

TEST(TilePartition, EveryTriangleIsInOneTile) {
  const TouchScene scene = two_objects();
  const TiledScene tiled = make_tiles(scene);
  EXPECT_EQ(triangles_of(tiled.tiles), triangles_of(scene, tiled.grid));
}

TEST(TilePartition, TilesFitAndKnowTheirObject) {
  const TouchScene scene = two_objects();
  const TiledScene tiled = make_tiles(scene);
  std::size_t full_tiles = 0;
  for (std::size_t n = 0; n < tiled.tiles.size(); ++n) {
    const PatchTile& tile = tiled.tiles[n];
    EXPECT_EQ(tile.tile, n);
    ASSERT_LE(tile.vertex_count, PatchTile::kMaxVertices);
    ASSERT_LE(tile.triangle_count, PatchTile::kMaxTriangles);
    ASSERT_GT(tile.triangle_count, 0);
    const Material& material = scene.objects.at(tile.object).material;
    EXPECT_EQ(tile.stiffness_n_per_m, material.stiffness_n_per_m);
    EXPECT_EQ(tile.damping_ns_per_m, material.damping_ns_per_m);
    EXPECT_EQ(tile.friction_static, material.friction_static);
    EXPECT_EQ(tile.friction_dynamic, material.friction_dynamic);
    EXPECT_EQ(tile.two_sided, material.two_sided);
    full_tiles += tile.object == 0 && tile.triangle_count == PatchTile::kMaxTriangles ? 1 : 0;
  }
  // The sheet has 40 x 40 x 2 triangles.
  EXPECT_GE(full_tiles, std::size_t{3200 / 64 - 2}) << "tiles of a mesh are full, but for a few";
}

// A patch relies on the cells: the list of a cell must have the tile of every triangle in it.
TEST(TilePartition, ACellListsEveryTileThatReachesIntoIt) {
  const TiledScene tiled = make_tiles(scene_of(wavy_sheet(0.05, 100)));
  ASSERT_GT(tiled.cells.size(), 10U);
  double listed = 0.0;
  for (const TileCell& cell : tiled.cells) {
    for (std::uint32_t tile = 0; tile < tiled.tiles.size(); ++tile) {
      const bool is_listed = std::binary_search(cell.tiles.begin(), cell.tiles.end(), tile);
      ASSERT_EQ(is_listed, tiled.tile_bounds[tile].overlaps(cell.key.bounds()));
    }
    listed += static_cast<double>(cell.tiles.size());
  }
  EXPECT_LT(listed / static_cast<double>(tiled.tiles.size()), 12.0) << "a tile is in few cells";
}

TEST(TilePartition, CellsAndEmptyChildrenCoverAllSpace) {
  const TiledScene tiled = make_tiles(scene_of(wavy_sheet(0.05, 100)));
  double volume = 0.0;
  std::set<std::uint64_t> empty;
  for (const TileCell& cell : tiled.cells) {
    volume += (cell.key.bounds().high - cell.key.bounds().low).prod();
    for (CellKey above = cell.key; above.level > 0;) {
      above = above.parent();
      for (std::uint32_t octant = 0; octant < 8; ++octant) {
        const CellKey child = above.child(octant);
        if (((cell.empty_children[above.level] >> octant) & 1U) != 0 && empty.insert(child.packed()).second) {
          volume += (child.bounds().high - child.bounds().low).prod();
        }
      }
    }
  }
  EXPECT_EQ(volume, std::ldexp(1.0, 3 * kPatchGridBits));
}

// What deforms is felt only once all of it has been received, so no cell lists it. A body without tiles has no root either.
TEST(TilePartition, OnlyABodyThatKeepsItsShapeHasCells) {
  const auto square = [](double z) {
    TouchObject object{made::shared(made::sheet(0.01, z, 4)), Material()};
    return object;
  };
  const auto deforming = [&](double z) {
    TouchObject object = square(z);
    object.deformation = std::make_shared<const MeshDeformation>(std::vector<MorphTarget>{{{0}, {Vec3(0, 0, 0.001)}}},
                                                                 std::vector<MorphKey>{{0.0, {0.0}}, {1.0, {1.0}}}, false);
    return object;
  };
  TouchObject streamed = square(0.04);
  streamed.stream_reach_m = 0.002;
  TouchObject commanded = square(0.06);
  commanded.command_pivot = Vec3(0, 0, 0.06);
  const TiledScene tiled = make_tiles({.objects = {deforming(0.0), commanded, streamed, deforming(0.08)}});
  ASSERT_EQ(tiled.bodies.size(), 5U);
  std::size_t with_root = 0;
  for (const TileBody& body : tiled.bodies) {
    const bool is_commanded = body.group.objects == std::vector<int>{1};
    EXPECT_EQ(body.root >= 0, is_commanded);
    EXPECT_EQ(body.deforms(), !is_commanded && !body.group.objects.empty());
    EXPECT_EQ(body.tile_count > 0, !body.group.objects.empty());
    with_root += body.root >= 0 ? 1 : 0;
  }
  EXPECT_EQ(with_root, 1U);
  EXPECT_TRUE(tiled.bodies.front().group.objects.empty()) << "nothing stands still";
  ASSERT_EQ(tiled.cells.size(), 1U);
  EXPECT_EQ(tiled.nodes.size(), 1U);
  for (const std::uint32_t tile : tiled.cells.front().tiles) EXPECT_EQ(tiled.tiles[tile].object, 1U);
}

TEST(TilePartition, AnEmptySceneHasNoTilesAndNoCells) {
  const TiledScene tiled = make_tiles({});
  EXPECT_TRUE(tiled.tiles.empty());
  EXPECT_TRUE(tiled.cells.empty());
}

// Long slivers cross one another. In the middle the bounds of all tiles overlap, so no cell there has few tiles.
TEST(TilePartition, TilesThatLieAcrossEachOtherDoNotFillTheMemory) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> coordinate(-0.05, 0.05);
  TriangleMesh mesh;
  for (std::uint32_t n = 0; n < 6000; ++n) {
    const Vec3 from(coordinate(random), coordinate(random), coordinate(random));
    const Vec3 to(coordinate(random), coordinate(random), coordinate(random));
    for (const Vec3& v : {from, to, Vec3(to + Vec3(1e-5, 2e-5, 1e-5))}) mesh.vertices.push_back(v);
    mesh.triangles.push_back({3 * n, 3 * n + 1, 3 * n + 2});
  }
  const TiledScene tiled = make_tiles(scene_of(std::move(mesh)));
  EXPECT_LE(tiled.nodes.size(), PatchStore::kMaxCells);
  EXPECT_GT(tiled.cells.size(), 0U);
  std::size_t listed = 0;
  for (const TileCell& cell : tiled.cells) listed += cell.tiles.size();
  EXPECT_LE(listed, PatchStore::kMaxCells * PatchCell::kMaxTiles / 4);
}

}  // namespace
}  // namespace hapton
