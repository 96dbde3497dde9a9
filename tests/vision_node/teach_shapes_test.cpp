#include "vision_node/teach_shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/geometry/closest_point.h"
#include "tests/support/made_meshes.h"
#include "vision_node/teach_builder.h"

namespace hapton {
namespace {

TouchScene make_sphere_scene(int bands = 24) { return {.objects = {{made::shared(made::sphere(0.05, bands)), {}}}}; }

SmoothScene make_smooth_scene(const TouchScene& scene) { return *SmoothScene::build(scene, {}); }

TeachProbe make_touching_probe() {
  TeachProbe probe;
  const Vec3 outward = Vec3(1.0, 2.0, 3.0).normalized();
  probe.p_SP = 0.05 * outward;
  probe.p_SD = 0.048 * outward;
  probe.force_S_n = 2.0 * outward;
  probe.is_contact = true;
  return probe;
}

TEST(TeachShapes, ContactShowsTheTrianglesAndPlanesAtTheProbe) {
  const TouchScene scene = make_sphere_scene();
  const SmoothScene smooth = make_smooth_scene(scene);
  TeachProbe probe = make_touching_probe();
  // The point is on a triangle, where a proxy in contact is.
  const TriangleMesh& mesh = *scene.objects[0].mesh;
  const std::size_t t = mesh.triangles.size() / 2;
  probe.p_SP = (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3.0;
  probe.force_S_n = probe.p_SP;
  const TeachShapes shapes = make_contact_shapes(smooth, probe);
  ASSERT_EQ(shapes.triangles.size(), 1U) << shapes.caption;
  // Three sides of the triangle, four sides of the plane's square, the plane's normal, the penetration vector.
  EXPECT_EQ(shapes.lines.size(), 9U);
  const TeachTriangle& touched = shapes.triangles.front();
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(shapes.lines[k].from, touched.corner[k]);
    EXPECT_EQ(shapes.lines[k].to, touched.corner[(k + 1) % 3]);
    EXPECT_EQ(shapes.lines[k].colour, (TeachColour{255, 190, 40}));
    EXPECT_EQ(touched.colour[k], (TeachColour{153, 114, 24})) << "darker, so that its sides are visible";
  }
  const TeachLine& normal = shapes.lines[7];
  EXPECT_GT((normal.to - normal.from).dot(probe.force_S_n), 0.0) << "towards the force";
  probe.is_contact = false;
  EXPECT_TRUE(make_contact_shapes(smooth, probe).lines.empty());
}

// A square in the triangle's plane, its side 6 % of the scene's diagonal; a normal half as long; a line from proxy to device point.
TEST(TeachShapes, APlaneIsASquareAtTheClosestPoint) {
  const TouchScene scene = make_sphere_scene();
  const SmoothScene smooth = make_smooth_scene(scene);
  TeachProbe probe = make_touching_probe();
  const TriangleMesh& mesh = *scene.objects[0].mesh;
  const std::size_t t = mesh.triangles.size() / 2;
  probe.p_SP = (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3.0;
  const Vec3 face_normal = (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0)).normalized();
  probe.p_SD = probe.p_SP - 0.002 * face_normal;
  for (const double sign : {1.0, -1.0}) {
    probe.force_S_n = sign * face_normal;
    const TeachShapes shapes = make_contact_shapes(smooth, probe);
    ASSERT_EQ(shapes.lines.size(), 9U);
    EXPECT_EQ(shapes.caption, "contact: 1 triangle, 1 plane, penetration 2.00 mm");
    const double size = 0.03 * smooth.diagonal();
    for (std::size_t k = 3; k < 7; ++k) {
      EXPECT_NEAR((shapes.lines[k].to - shapes.lines[k].from).norm(), 2.0 * size, 1e-9) << k;
      EXPECT_NEAR((shapes.lines[k].from - probe.p_SP).norm(), std::sqrt(2.0) * size, 1e-6) << k;
      EXPECT_NEAR((shapes.lines[k].from - probe.p_SP).dot(face_normal), 0.0, 1e-6) << k;
    }
    EXPECT_LT((shapes.lines[7].to - shapes.lines[7].from - sign * size * face_normal).norm(), 1e-6) << "where the force goes";
    EXPECT_EQ(shapes.lines[8].from, probe.p_SP);
    EXPECT_EQ(shapes.lines[8].to, probe.p_SD);
  }
  // Without a force, the normal points to the side of the proxy, as seen from the device point.
  probe.force_S_n.setZero();
  EXPECT_GT((make_contact_shapes(smooth, probe).lines[7].to - probe.p_SP).dot(face_normal), 0.0);
  probe.is_contact = false;
  EXPECT_EQ(make_contact_shapes(smooth, probe).caption, "contact: none");
}

// Triangles of one flat face are one plane; in front of the middle of a face of a box, at an edge and at a corner.
TEST(TeachShapes, AFlatFaceIsOnePlane) {
  const SmoothScene smooth = make_smooth_scene({.objects = {{made::shared(made::box(Vec3(0, 0, 0), Vec3(0.04, 0.04, 0.04))), {}}}});
  for (const auto& [p_SP, planes] : {std::pair(Vec3(0.02, 0.02, 0.04), 1), {Vec3(0.04, 0.02, 0.04), 2}, {Vec3(0.04, 0.04, 0.04), 3}}) {
    TeachProbe probe;
    probe.p_SP = p_SP;
    probe.p_SD = p_SP - Vec3(0.001, 0.001, 0.001);
    probe.force_S_n = Vec3(1, 1, 1);
    probe.is_contact = true;
    const TeachShapes shapes = make_contact_shapes(smooth, probe);
    EXPECT_GE(shapes.triangles.size(), 2U);
    EXPECT_NE(shapes.caption.find(planes == 1 ? ", 1 plane, " : fmt::format(", {} planes, ", planes)), std::string::npos) << shapes.caption;
    EXPECT_EQ(shapes.lines.size(), 3 * shapes.triangles.size() + 5 * static_cast<std::size_t>(planes) + 1);
  }
}

// A sphere probe is in contact with all triangles within its radius.
TEST(TeachShapes, ABallIsInContactByItsRadius) {
  const TouchScene scene = make_sphere_scene();
  const SmoothScene smooth = make_smooth_scene(scene);
  TeachProbe probe = make_touching_probe();
  probe.p_SP = 0.06 * Vec3(1.0, 2.0, 3.0).normalized();
  for (const double radius_m : {0.0, 0.0095, 0.0105, 0.012}) {
    probe.radius_m = radius_m;
    const double contact_distance_m = radius_m + 2e-4 * smooth.diagonal();
    std::size_t expected = 0;
    std::vector<Vec3> normals;  // the two triangles of a quadrilateral have the same one
    const TriangleMesh& mesh = *scene.objects[0].mesh;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const Vec3 &a = mesh.corner(t, 0), &b = mesh.corner(t, 1), &c = mesh.corner(t, 2);
      if (closest_point(a, b, c, probe.p_SP).distance > contact_distance_m) continue;
      ++expected;
      const Vec3 normal = (b - a).cross(c - a).normalized();
      if (std::none_of(normals.begin(), normals.end(), [&](const Vec3& n) { return (n - normal).norm() < 1e-3; }))
        normals.push_back(normal);
    }
    const TeachShapes shapes = make_contact_shapes(smooth, probe);
    EXPECT_EQ(shapes.triangles.size(), expected) << radius_m;
    EXPECT_EQ(shapes.lines.size(), 3 * expected + 5 * normals.size() + 1) << radius_m;
    EXPECT_EQ(expected > 0, radius_m > 0.01) << radius_m;
  }
}

// By brute force: at most 20 triangles are nearer than the farthest one shown, and within the distance in the caption none is left out.
TEST(TeachShapes, TheLocalSetIsTheNearest) {
  const TouchScene scene = make_sphere_scene();
  const SmoothScene smooth = make_smooth_scene(scene);
  TeachProbe probe = make_touching_probe();
  probe.set_size = 20;
  const TeachShapes shapes = make_local_set_shapes(smooth, probe);
  EXPECT_EQ(shapes.triangles.size(), 20U);
  const auto distance = [&](const std::array<Vec3, 3>& c) { return closest_point(c[0], c[1], c[2], probe.p_SP).distance; };
  double farthest = 0.0;
  for (const TeachTriangle& triangle : shapes.triangles) farthest = std::max(farthest, distance(triangle.corner));
  std::size_t nearer = 0;
  smooth.for_each([&](const SetTriangle& triangle) { nearer += distance(triangle.corner) < farthest - 1e-9 ? 1 : 0; });
  EXPECT_LE(nearer, 20U);
  double complete_mm = 0.0;
  ASSERT_EQ(std::sscanf(shapes.caption.c_str(), "local set: 20 triangles, complete within %lf mm", &complete_mm), 1) << shapes.caption;
  EXPECT_GT(complete_mm, 0.5);
  std::size_t within = 0;
  smooth.for_each([&](const SetTriangle& triangle) { within += distance(triangle.corner) < 1e-3 * complete_mm - 1e-5 ? 1 : 0; });
  std::size_t shown = 0;
  for (const TeachTriangle& triangle : shapes.triangles) shown += distance(triangle.corner) < 1e-3 * complete_mm - 1e-5 ? 1 : 0;
  EXPECT_EQ(shown, within) << "what is nearer is in the set";
  probe.set_size = -3;
  EXPECT_EQ(make_local_set_shapes(smooth, probe).triangles.size(), 1U) << "at least one";
}

// The hulls of the first level together enclose the whole scene; a hull that contains the probe is white.
TEST(TeachShapes, TheHullsOfTheFirstLevelEncloseTheScene) {
  const TouchScene scene = make_sphere_scene();
  const SmoothScene smooth = make_smooth_scene(scene);
  TeachProbe probe = make_touching_probe();
  for (const auto& [at, colour] : {std::pair(Vec3(0.0, 0.0, 0.0), TeachColour{255, 255, 255}),
                                   {Vec3(0.0, 0.0, 0.051), TeachColour{255, 200, 90}},
                                   {Vec3(0.0, -0.051, 0.0), TeachColour{255, 200, 90}}}) {
    probe.p_SP = at;
    const TeachShapes shapes = make_tree_shapes(smooth, probe, 0);
    EXPECT_EQ(shapes.caption, "tree: level 0, 8 hulls");
    Eigen::AlignedBox3d box;
    for (const TeachLine& line : shapes.lines) {
      box.extend(line.from).extend(line.to);
      EXPECT_EQ(line.colour, colour);
    }
    EXPECT_LT((box.min() + Vec3::Constant(0.05)).norm(), 1e-3);
    EXPECT_LT((box.max() - Vec3::Constant(0.05)).norm(), 1e-3);
  }
}

TEST(TeachShapes, HullsOfALevelContainTheirTrianglesAndTogetherAll) {
  const TouchScene scene = make_sphere_scene();
  const SmoothScene smooth = make_smooth_scene(scene);
  const std::size_t triangle_count = smooth.surface(0).mesh.triangles.size();
  std::size_t hulls_of_previous_level = 0;
  for (int level = 0; level < smooth.tree_stats().depth; ++level) {
    std::multiset<std::uint32_t> covered;
    std::size_t hulls = 0;
    smooth.for_each_hull(level, [&]<int K>(std::uint32_t object, const FdhHull<K>& hull, std::span<const std::uint32_t> triangles) {
      ++hulls;
      covered.insert(triangles.begin(), triangles.end());
      for (const std::uint32_t t : triangles) {
        for (const Vec3& corner : smooth.triangle_at(object, t).corner) {
          const auto along = fdh_project<K>(corner);
          for (int i = 0; i < K / 2; ++i) {
            ASSERT_GE(along[i], hull.low[i]);
            ASSERT_LE(along[i], hull.high[i]);
          }
        }
      }
    });
    EXPECT_EQ(covered.size(), triangle_count) << "level " << level;
    EXPECT_EQ(std::set<std::uint32_t>(covered.begin(), covered.end()).size(), triangle_count) << "each once";
    EXPECT_GE(hulls, hulls_of_previous_level);
    hulls_of_previous_level = hulls;
    const TeachShapes shapes = make_tree_shapes(smooth, make_touching_probe(), level);
    EXPECT_GE(shapes.lines.size(), 12U * std::min(hulls, kMaxTeachHulls) / 2) << shapes.caption;
  }
  EXPECT_GT(hulls_of_previous_level, 8U);
}

TEST(TeachShapes, LinesOfALargeMeshAreBounded) {
  const TouchScene scene = make_sphere_scene(300);  // 359,000 triangles
  const SmoothScene smooth = make_smooth_scene(scene);
  const TeachShapes shapes = make_tree_shapes(smooth, make_touching_probe(), TeachChoice::kDeepest);
  EXPECT_LE(shapes.lines.size(), 36U * kMaxTeachHulls);
  EXPECT_NE(shapes.caption.find("the 1000 nearest are drawn"), std::string::npos) << shapes.caption;
  EXPECT_EQ(make_curvature_shapes(scene, find_curvature(scene), make_touching_probe()).triangles.size(), kMaxTeachTriangles);
}

// Every edge belongs to an occupied cell, and each occupied cell has its twelve edges.
TEST(TeachShapes, CellsAreThoseOfTheGrid) {
  const TouchScene scene = make_sphere_scene(8);
  const UniformGrid grid = *make_teach_grid(scene);
  TeachProbe far_probe = make_touching_probe();
  far_probe.p_SP = Vec3(9.0, 9.0, 9.0);
  const TeachShapes shapes = make_grid_shapes(grid, far_probe);
  const Vec3 size = (grid.high() - grid.low()) / kTeachCells;
  using Edge = std::array<int, 4>;  // the corner where it begins, in cells, and its axis
  std::set<Edge> drawn;
  for (const TeachLine& line : shapes.lines) {
    const Vec3 at = (line.from - grid.low()).cwiseQuotient(size);
    const Vec3 along = (line.to - line.from).cwiseQuotient(size);
    int axis = 0;
    EXPECT_NEAR(along.cwiseAbs().maxCoeff(&axis), 1.0, 1e-6);
    drawn.insert(
        {static_cast<int>(std::lround(at.x())), static_cast<int>(std::lround(at.y())), static_cast<int>(std::lround(at.z())), axis});
  }
  EXPECT_EQ(drawn.size(), shapes.lines.size()) << "each once";
  std::set<Edge> expected;
  for (int z = 0; z < kTeachCells; ++z) {
    for (int y = 0; y < kTeachCells; ++y) {
      for (int x = 0; x < kTeachCells; ++x) {
        if (grid.triangles_in(x, y, z).empty()) continue;
        for (int a = 0; a < 2; ++a) {
          for (int b = 0; b < 2; ++b) {
            expected.insert({x, y + a, z + b, 0});
            expected.insert({x + a, y, z + b, 1});
            expected.insert({x + a, y + b, z, 2});
          }
        }
      }
    }
  }
  EXPECT_EQ(drawn, expected);
  EXPECT_NE(shapes.caption.find(std::to_string(grid.occupancy().occupied_cells) + " of 32768 cells"), std::string::npos) << shapes.caption;
  const TeachShapes with_cell = make_grid_shapes(grid, make_touching_probe());
  ASSERT_EQ(with_cell.lines.size(), shapes.lines.size() + 12) << "the probe's cell";
  Eigen::AlignedBox3d cell;
  for (std::size_t i = shapes.lines.size(); i < with_cell.lines.size(); ++i) {
    EXPECT_EQ(with_cell.lines[i].colour, (TeachColour{255, 255, 255}));
    cell.extend(with_cell.lines[i].from).extend(with_cell.lines[i].to);
  }
  EXPECT_LT((cell.sizes() - size).norm(), 1e-9);
  EXPECT_TRUE(cell.contains(make_touching_probe().p_SP));
  const Vec3 cell_index = (cell.min() - grid.low()).cwiseQuotient(size);
  const auto triangles = grid.triangles_in(static_cast<int>(std::lround(cell_index.x())), static_cast<int>(std::lround(cell_index.y())),
                                           static_cast<int>(std::lround(cell_index.z())));
  EXPECT_NE(with_cell.caption.find("; the probe's cell: " + std::to_string(triangles.size())), std::string::npos) << with_cell.caption;
  EXPECT_EQ(shapes.caption.find("the probe's cell"), std::string::npos);
}

TEST(TeachShapes, CurvatureOfASphereHasOneColour) {
  const TouchScene scene = make_sphere_scene(48);
  const TeachCurvature curvature = find_curvature(scene);
  EXPECT_NEAR(curvature.limit, 20.0, 0.4) << "1 / 0.05 m";
  const TeachShapes shapes = make_curvature_shapes(scene, curvature, make_touching_probe());
  ASSERT_TRUE(shapes.legend);
  for (const TeachTriangle& triangle : shapes.triangles) {
    for (const TeachColour& colour : triangle.colour) ASSERT_GT(colour[0], colour[2] + 100) << "red: convex";
  }
  EXPECT_EQ(shapes.legend->limit, curvature.limit);
  EXPECT_EQ(shapes.legend->unit, "1/m");
}

TEST(TeachShapes, ColoursGoEvenlyFromBlueThroughGreyToRed) {
  EXPECT_EQ(curvature_colour(0.0, 5.0), (TeachColour{222, 222, 222}));
  EXPECT_EQ(curvature_colour(5.0, 5.0), (TeachColour{220, 40, 40}));
  EXPECT_EQ(curvature_colour(2.5, 5.0), (TeachColour{221, 131, 131}));
  EXPECT_EQ(curvature_colour(-2.5, 5.0), (TeachColour{131, 151, 226}));
  EXPECT_EQ(curvature_colour(-5.0, 5.0), (TeachColour{40, 80, 230}));
  EXPECT_EQ(curvature_colour(-99.0, 5.0), (TeachColour{40, 80, 230}));
  EXPECT_EQ(curvature_colour(3.0, 0.0), (TeachColour{222, 222, 222})) << "a plane has no scale";
  EXPECT_EQ(curvature_colour(std::nan(""), 5.0), (TeachColour{230, 210, 60}));
}

// The scale ends at the curvature that 95 of 100 vertices do not exceed: a few sharp vertices do not make all others grey.
TEST(TeachShapes, AFewSharpVerticesDoNotSetTheScale) {
  for (const int sharp_bands : {4, 24}) {
    TouchScene scene = make_sphere_scene(48);
    scene.objects.push_back({made::shared(made::sphere(0.005, sharp_bands)), {}});
    const double share = static_cast<double>(scene.objects[1].mesh->vertices.size()) /
                         static_cast<double>(scene.objects[0].mesh->vertices.size() + scene.objects[1].mesh->vertices.size());
    EXPECT_EQ(share > 0.05, sharp_bands == 24);
    EXPECT_EQ(find_curvature(scene).limit > 100.0, sharp_bands == 24) << share;
  }
  EXPECT_EQ(find_curvature(TouchScene{}).limit, 0.0);
}

TEST(TeachBuilder, RepliesToTheNewestRequest) {
  TeachBuilder builder(make_sphere_scene());
  builder.request({TeachView::grid, 0}, make_touching_probe());
  builder.request({TeachView::tree, 1}, make_touching_probe());
  std::optional<TeachShapes> shapes;
  while (!shapes || shapes->choice.view != TeachView::tree) {
    std::this_thread::yield();
    if (auto next = builder.take_shapes()) shapes = std::move(next);
  }
  EXPECT_EQ(shapes->choice, (TeachChoice{TeachView::tree, 1}));
  EXPECT_GT(builder.tree_depth(), 1);
  EXPECT_FALSE(builder.is_busy());
}

// As soon as is_busy() is false, the requested shapes can be taken.
TEST(TeachBuilder, IsBusyUntilWhatWasRequestedIsThere) {
  for (int n = 0; n < 20; ++n) {
    TeachBuilder builder(make_sphere_scene());
    builder.request({TeachView::grid, 0}, make_touching_probe());
    while (builder.is_busy()) std::this_thread::yield();
    ASSERT_TRUE(builder.take_shapes()) << n;
  }
}

TEST(TeachBuilder, ASceneThatCannotBePreparedSaysWhy) {
  TeachBuilder builder(TouchScene{});
  builder.request({TeachView::grid, 0}, {});
  std::optional<TeachShapes> shapes;
  while (!(shapes = builder.take_shapes())) std::this_thread::yield();
  EXPECT_EQ(shapes->caption.find("grid: "), 0U) << shapes->caption;
}

}  // namespace
}  // namespace hapton
