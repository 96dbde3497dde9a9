#include "core/collision/deforming_geometry.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/support/found_in_trees.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

constexpr int kBands = 12;

std::shared_ptr<const MeshDeformation> make_waves(const TriangleMesh& mesh, bool loops) {
  std::vector<MorphTarget> targets(2);
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
    const Vec3& p = mesh.vertices[v];
    targets[0].vertices.push_back(v);
    targets[0].displacements.push_back(0.2 * p);
    if (p.z() <= 0.0) continue;
    targets[1].vertices.push_back(v);
    targets[1].displacements.push_back({0.0, 0.5 * p.z(), 0.2 * p.z()});
  }
  return std::make_shared<const MeshDeformation>(
      std::move(targets), std::vector<MorphKey>{{0.0, {0.0, 0.0}}, {0.3, {1.0, 0.2}}, {0.35, {0.5, 1.0}}, {1.0, {0.0, 0.0}}}, loops);
}

struct DeformingObject {
  explicit DeformingObject(TriangleMesh of) : mesh(made::shared(std::move(of))), deformation(make_waves(*mesh, true)) {
    geometry = std::make_unique<TouchGeometry>(std::vector<std::shared_ptr<const TriangleMesh>>{mesh}, BuildPolicy::to_deform, std::nullopt,
                                               bounds_of_all_shapes(*mesh, *deformation));
    deforming = std::make_unique<DeformingGeometry>(*geometry, mesh, deformation);
  }
  std::shared_ptr<const TriangleMesh> mesh;
  std::shared_ptr<const MeshDeformation> deformation;
  std::unique_ptr<TouchGeometry> geometry;
  std::unique_ptr<DeformingGeometry> deforming;
};

TEST(DeformingGeometry, MeanEdgeOfARightTriangleAndOfNothing) {
  EXPECT_DOUBLE_EQ(compute_mean_edge({.vertices = {Vec3::Zero(), Vec3(3, 0, 0), Vec3(0, 4, 0)}, .triangles = {{0, 1, 2}}}), 4.0);
  EXPECT_EQ(compute_mean_edge({}), 0.0);
}

// The vertices are those of the deformed mesh at that time, rounded to the grid.
TEST(DeformingGeometry, HasTheShapeOfEachTime) {
  const DeformingObject object(made::sphere(0.05, kBands, 0.05));
  for (const double time : {0.0, 0.1, 0.3, 0.32, 0.99, 1.0, 1.1, 7.77}) {
    object.deforming->shape(time);
    const auto expected = object.deformation->vertices_at(object.mesh->vertices, object.deformation->weights_at(time));
    for (std::size_t v = 0; v < expected.size(); ++v) {
      const Vec3& actual = object.geometry->deforming_object().vertices()[object.geometry->new_vertex()[v]];
      EXPECT_LE((actual - object.geometry->to_local(expected[v])).norm(), 0x1p-50) << "at " << time << " s";
      for (int k = 0; k < 3; ++k) EXPECT_EQ(std::ldexp(actual[k], 51), std::rint(std::ldexp(actual[k], 51))) << "on the grid";
    }
  }
}

// Brute force: every triangle near a query point is found, whichever of the trees is in use.
TEST(DeformingGeometry, FindsEveryTriangleAtEachTime) {
  const DeformingObject object(made::sphere(0.05, kBands, 0.05));
  EXPECT_GT(object.deforming->tree_count(), 5U);
  std::mt19937_64 random(6);
  SCOPED_TRACE("seed 6");
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (int i = 0; i < 400; ++i) {
    object.deforming->shape(1.5 + 1.5 * unit(random));
    const auto triangles = static_cast<std::uint32_t>(object.mesh->triangles.size());
    expect_found_in_trees(*object.geometry, triangles, Vec3(unit(random), unit(random), unit(random)));
  }
}

// The sheet rises and sinks again by less than an edge, so that it has only one tree.
TEST(DeformingGeometry, ATreeHoldsTheShapesAtKeysWithinItsTime) {
  constexpr double kRise = 0.006;
  const auto mesh = made::shared(made::sheet(0.05, 0.0, 4));
  MorphTarget up;
  for (std::uint32_t v = 0; v < mesh->vertices.size(); ++v) {
    up.vertices.push_back(v);
    up.displacements.emplace_back(0, 0, kRise);
  }
  const auto deformation = std::make_shared<const MeshDeformation>(std::vector<MorphTarget>{up},
                                                                   std::vector<MorphKey>{{0.0, {0.0}}, {0.5, {1.0}}, {1.0, {0.0}}}, false);
  TouchGeometry geometry(std::vector<std::shared_ptr<const TriangleMesh>>{mesh}, BuildPolicy::to_deform, std::nullopt,
                         bounds_of_all_shapes(*mesh, *deformation));
  DeformingGeometry deforming(geometry, mesh, deformation);
  ASSERT_EQ(deforming.tree_count(), 1U);
  deforming.shape(0.5);
  const Box slab{geometry.to_local(Vec3(-0.05, -0.05, 0.9 * kRise)), geometry.to_local(Vec3(0.05, 0.05, 1.1 * kRise))};
  std::size_t found = 0;
  geometry.for_each_overlapping(slab, [&](std::uint32_t) { ++found; });
  EXPECT_EQ(found, mesh->triangles.size());
}

// A deformation that is never at the rest shape.
TEST(DeformingGeometry, TheBoundsHoldTheMeshAtRestAsWell) {
  const TriangleMesh sheet = made::sheet(0.05, 0.0, 2);
  const MeshDeformation away({{{0, 1, 2, 3, 4, 5, 6, 7, 8}, std::vector<Vec3>(9, Vec3(0, 0, 1))}}, {{0.0, {1.0}}, {1.0, {2.0}}}, false);
  const Box bounds = bounds_of_all_shapes(sheet, away);
  EXPECT_LE(bounds.low.z(), 0.0);
  EXPECT_GE(bounds.high.z(), 2.0);
  EXPECT_LE(bounds.high.z(), 2.0 + 1e-9);
}

TEST(DeformingGeometry, OneTreeIsEnoughForWhatHardlyMoves) {
  const auto mesh = made::shared(made::sheet(0.05, 0.0, 4));
  const auto deformation = std::make_shared<const MeshDeformation>(std::vector<MorphTarget>{{{0}, {Vec3(0, 0, 1e-6)}}},
                                                                   std::vector<MorphKey>{{0.0, {0.0}}, {1.0, {1.0}}}, false);
  TouchGeometry geometry(std::vector<std::shared_ptr<const TriangleMesh>>{mesh}, BuildPolicy::to_deform, std::nullopt,
                         bounds_of_all_shapes(*mesh, *deformation));
  EXPECT_EQ(DeformingGeometry(geometry, mesh, deformation).tree_count(), 1U);
}

TEST(DeformingGeometry, NamesTheTimeAtWhichASurfaceTouchesItself) {
  TriangleMesh sheets = made::sheet(0.05, 0.0, 4);
  EXPECT_TRUE(check_shapes(sheets, *make_waves(sheets, false)));
  const TriangleMesh above = made::sheet(0.04, 0.01, 4);
  const auto shift = static_cast<std::uint32_t>(sheets.vertices.size());
  sheets.vertices.insert(sheets.vertices.end(), above.vertices.begin(), above.vertices.end());
  for (const Triangle& t : above.triangles) sheets.triangles.push_back({t[0] + shift, t[1] + shift, t[2] + shift});
  MorphTarget down;
  for (std::uint32_t v = shift; v < sheets.vertices.size(); ++v) {
    down.vertices.push_back(v);
    down.displacements.push_back({0, 0, -0.02});
  }
  // Half-way between its keys the upper sheet lies in the plane of the lower one.
  const MeshDeformation through({down}, {{0.0, {0.0}}, {1.0, {1.0}}}, false);
  const auto checked = check_shapes(sheets, through);
  ASSERT_FALSE(checked);
  EXPECT_TRUE(
      check_shapes(made::box({0, 0, 0}, {1, 1, 1}), MeshDeformation({{{0}, {Vec3(-1, -1, -1)}}}, {{0.0, {0.0}}, {1.0, {1.0}}}, false)));
  EXPECT_EQ(checked.error().what.find("at 0.5 s 64 of its 64 triangles touch or nearly touch"), 0U) << checked.error().what;
}

}  // namespace
}  // namespace hapton
