#include "core/tool/obb_tree.h"

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <set>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

struct TreeContents {
  std::set<std::uint32_t> triangles;
  int depth = 0;
};

// Expects that every box contains the exact corners of all triangles below it. Returns these triangles and the depth of the tree.
TreeContents check_tree(const ObbTree& tree, const std::function<std::array<Vec3, 3>(std::uint32_t)>& corners) {
  TreeContents contents;
  const std::function<std::vector<std::uint32_t>(std::uint32_t, int)> visit = [&](std::uint32_t at, int depth) {
    const ObbTree::Node& node = tree.nodes()[at];
    contents.depth = std::max(contents.depth, depth);
    std::vector<std::uint32_t> triangles_below;
    if (node.is_leaf()) {
      triangles_below.push_back(tree.triangle(node));
      EXPECT_TRUE(contents.triangles.insert(triangles_below[0]).second) << "twice in the tree";
    } else {
      for (const std::uint32_t child : {node.link, node.link + 1}) {
        for (const std::uint32_t id : visit(child, depth + 1)) triangles_below.push_back(id);
      }
    }
    Mat3 axes;
    for (int i = 0; i < 3; ++i) axes.col(i) = node.axis(i);
    EXPECT_LT((axes.transpose() * axes - Mat3::Identity()).cwiseAbs().maxCoeff(), 0x1p-20);
    for (const std::uint32_t id : triangles_below) {
      for (const Vec3& p : corners(id)) {
        const Vec3 y = axes.inverse() * (p - node.at());
        EXPECT_TRUE((y.cwiseAbs().array() <= node.half_size().array()).all());
      }
    }
    return triangles_below;
  };
  if (!tree.nodes().empty()) visit(0, 0);
  return contents;
}

TEST(ObbTree, BoxesContainTheirTriangles) {
  for (const TriangleMesh& mesh : {make_bumpy_sphere(0.3, 0.2, 2000, 5), make_box({0.1, 0.2, 0.3}, 4), make_cylinder(0.1, 0.3, 64, 3),
                                   make_gutter(0.1, 0.03, 1.5, 3), make_plane_grid(0.2, 6)}) {
    const ObjectGeometry surface(mesh, {Vec3::Zero(), 1.0});
    const ObbTree tree(surface);
    const TreeContents contents = check_tree(tree, [&](std::uint32_t t) {
      return std::array<Vec3, 3>{surface.corner(t, 0), surface.corner(t, 1), surface.corner(t, 2)};
    });
    EXPECT_EQ(contents.triangles.size(), surface.triangle_count());
    EXPECT_LE(contents.depth, ObbTree::kMaxDepth);
  }
}

TEST(ObbTree, HoldsTheTrianglesOfAllObjectsUnderTheirNumbersInTheScene) {
  const TriangleMesh ball = make_bumpy_sphere(0.3, 0.2, 300, 3);
  const TriangleMesh box = scaled_and_moved(make_box({0.4, 0.2, 0.3}, 3), 1.0, {0.5, 0.0, 0.0});
  const TouchGeometry scene(std::vector<const TriangleMesh*>{&ball, &box});
  const TreeContents contents = check_tree(ObbTree(scene), [&](std::uint32_t id) {
    return std::array<Vec3, 3>{scene.corner(id, 0), scene.corner(id, 1), scene.corner(id, 2)};
  });
  EXPECT_EQ(contents.triangles.size(), scene.triangle_count());
}

TEST(ObbTree, TreesOfObjectsAreJoined) {
  for (const int count : {0, 1, 2, 33}) {
    std::vector<std::shared_ptr<const TriangleMesh>> meshes;
    for (int i = 0; i < count; ++i) {
      const Vec3 at(0.3 * (i % 7), 0.4 * (i % 5), 0.1 * i);
      meshes.push_back(i == 4 ? std::make_shared<TriangleMesh>()
                              : std::make_shared<TriangleMesh>(scaled_and_moved(make_bumpy_sphere(0.3, 0.2, 80, i), 1.0, at)));
    }
    const TouchGeometry scene(meshes);
    std::vector<ObbTree> trees;
    for (std::uint32_t o = 0; o < scene.object_count(); ++o) trees.emplace_back(scene.object_geometry(o));
    std::vector<const ObbTree*> all;
    for (const ObbTree& tree : trees) all.push_back(&tree);
    const ObbTree joined(all, scene);
    const TreeContents contents = check_tree(joined, [&](std::uint32_t id) {
      return std::array<Vec3, 3>{scene.corner(id, 0), scene.corner(id, 1), scene.corner(id, 2)};
    });
    EXPECT_EQ(contents.triangles.size(), scene.triangle_count()) << count;
    EXPECT_LE(contents.depth, ObbTree::kMaxDepth);
    EXPECT_EQ(joined.nodes().size(), count == 0 ? 0 : 2 * scene.triangle_count() - 1) << count;
  }
}

TEST(ObbTree, WithAnotherOriginBoxesContainTheDisplacedTriangles) {
  const ObjectGeometry surface(make_bumpy_sphere(0.3, 0.2, 2000, 5), {Vec3::Zero(), 1.0});
  const ObbTree tree(surface);
  for (const Vec3& p : {Vec3(0.1, -0.2, 0.3), Vec3(-1.7, 0.9, 0.4), Vec3(0.0, 0.0, 0.0)}) {
    const ObjectGeometry displaced = surface.with_origin_at(p);
    const ObbTree moved = tree.with_origin_at(p);
    const TreeContents contents = check_tree(moved, [&](std::uint32_t t) {
      return std::array<Vec3, 3>{displaced.corner(t, 0), displaced.corner(t, 1), displaced.corner(t, 2)};
    });
    EXPECT_EQ(contents.triangles.size(), surface.triangle_count());
    for (std::size_t n = 0; n < tree.nodes().size(); ++n) {
      ASSERT_TRUE((moved.nodes()[n].half_size() - tree.nodes()[n].half_size()).maxCoeff() < 0x1p-21) << "no larger than rounding makes it";
    }
  }
}

// A box over a piece of a sphere is as thick as the cap is high; flat faces have flat boxes.
TEST(ObbTree, BoxesAreThin) {
  const ObjectGeometry ball(make_icosphere(1.0, 5), {Vec3::Zero(), 1.0});
  const ObbTree ball_tree(ball);
  int compared = 0;
  for (const ObbTree::Node& node : ball_tree.nodes()) {
    const double radius = node.half_size().norm();
    if (radius > 0.2) continue;
    ++compared;
    EXPECT_LT(node.half[0], 0.5 * radius * radius);
  }
  EXPECT_GT(compared, 10000);
  const ObjectGeometry box(make_box({1.0, 1.0, 1.0}, 4), {Vec3::Zero(), 1.0});
  int flat = 0;
  const ObbTree tree(box);
  for (const ObbTree::Node& node : tree.nodes()) flat += node.half[0] < 1e-6 ? 1 : 0;
  EXPECT_GT(flat, static_cast<int>(tree.nodes().size()) - 16);
}

TEST(ObbTree, OfTrianglesWithoutAreaIsComplete) {
  TriangleMesh mesh;
  for (int i = 0; i < 20; ++i) {
    const auto v = static_cast<std::uint32_t>(mesh.vertices.size());
    for (int k = 0; k < 3; ++k) mesh.vertices.emplace_back(0.1 * (i % 3), 0.2 * k, 0.0);
    mesh.triangles.push_back({v, v + 1, v + 2});
  }
  const ObjectGeometry surface(mesh, {Vec3::Zero(), 1.0});
  const TreeContents contents = check_tree(ObbTree(surface), [&](std::uint32_t t) {
    return std::array<Vec3, 3>{surface.corner(t, 0), surface.corner(t, 1), surface.corner(t, 2)};
  });
  EXPECT_EQ(contents.triangles.size(), surface.triangle_count());
}

}  // namespace
}  // namespace hapton
