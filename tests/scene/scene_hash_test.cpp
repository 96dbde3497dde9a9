#include "scene/scene_hash.h"

#include <gtest/gtest.h>

#include <memory>
#include <set>

namespace hapton {
namespace {

TriangleMesh corner() { return {{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)}, {{0, 1, 2}, {0, 2, 3}}}; }

std::uint64_t hash_of(const TriangleMesh& mesh, const Material& material = {}) {
  return hash_scene({{{std::make_shared<const TriangleMesh>(mesh), material}}});
}

TEST(SceneHash, EqualScenesHaveEqualHashes) { EXPECT_EQ(hash_of(corner()), hash_of(corner())); }

TEST(SceneHash, WhateverChangesTheForceChangesIt) {
  std::set<std::uint64_t> hashes = {hash_of(corner())};
  TriangleMesh moved = corner();
  moved.vertices[1].x() = 1.0 + 1e-15;
  hashes.insert(hash_of(moved));
  TriangleMesh turned = corner();
  std::swap(turned.triangles[0][1], turned.triangles[0][2]);
  hashes.insert(hash_of(turned));
  TriangleMesh fewer = corner();
  fewer.triangles.pop_back();
  hashes.insert(hash_of(fewer));
  TriangleMesh shaded = corner();  // force shading turns the force to the normals
  for (const float z : {1.0F, 2.0F}) {
    shaded.authored_normals.assign(2, {Eigen::Vector3f::UnitX(), Eigen::Vector3f::UnitX(), Eigen::Vector3f(0.0F, 0.0F, z)});
    hashes.insert(hash_of(shaded));
  }
  hashes.insert(hash_of(corner(), {.stiffness_n_per_m = 999.0}));
  hashes.insert(hash_of(corner(), {.friction_static = 0.1}));
  hashes.insert(hash_of(corner(), {.friction_dynamic = 0.1}));
  hashes.insert(hash_of(corner(), {.two_sided = false}));
  const auto shared = std::make_shared<const TriangleMesh>(corner());
  hashes.insert(hash_scene({{{shared, {}}, {shared, {}}}}));
  const auto moved_for = [&](double seconds, bool loops) {
    TouchScene scene{{{shared, {}}}};
    scene.objects[0].motion = std::make_shared<const KeyframeMotion>(
        Vec3::Zero(), std::vector<Keyframe>{{0.0, Vec3::Zero(), Quat::Identity()}, {seconds, Vec3::Zero(), Quat::Identity()}}, loops);
    return hash_scene(scene);
  };
  for (const bool loops : {false, true}) {
    for (const double seconds : {1.0, 2.0}) hashes.insert(moved_for(seconds, loops));
  }
  EXPECT_EQ(hashes.size(), 15U);
}

}  // namespace
}  // namespace hapton
