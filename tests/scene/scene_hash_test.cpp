#include "scene/scene_hash.h"

#include <gtest/gtest.h>

#include <memory>
#include <set>
#include <vector>

namespace hapton {
namespace {

TriangleMesh corner_mesh() { return {{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)}, {{0, 1, 2}, {0, 2, 3}}}; }

std::uint64_t hash_of(const TriangleMesh& mesh, const Material& material = {}) {
  return hash_scene({{{std::make_shared<const TriangleMesh>(mesh), material}}});
}

TEST(SceneHash, EqualScenesHaveEqualHashes) { EXPECT_EQ(hash_of(corner_mesh()), hash_of(corner_mesh())); }

TEST(SceneHash, WhateverChangesTheForceChangesIt) {
  std::set<std::uint64_t> hashes = {hash_of(corner_mesh())};
  TriangleMesh moved = corner_mesh();
  moved.vertices[1].x() = 1.0 + 1e-15;
  hashes.insert(hash_of(moved));
  TriangleMesh turned = corner_mesh();
  std::swap(turned.triangles[0][1], turned.triangles[0][2]);
  hashes.insert(hash_of(turned));
  TriangleMesh fewer = corner_mesh();
  fewer.triangles.pop_back();
  hashes.insert(hash_of(fewer));
  TriangleMesh shaded = corner_mesh();  // force shading turns the force to the normals
  for (const float z : {1.0F, 2.0F}) {
    shaded.authored_normals.assign(2, {Eigen::Vector3f::UnitX(), Eigen::Vector3f::UnitX(), Eigen::Vector3f(0.0F, 0.0F, z)});
    hashes.insert(hash_of(shaded));
  }
  hashes.insert(hash_of(corner_mesh(), {.stiffness_n_per_m = 999.0}));
  hashes.insert(hash_of(corner_mesh(), {.friction_static = 0.1}));
  hashes.insert(hash_of(corner_mesh(), {.friction_dynamic = 0.1}));
  hashes.insert(hash_of(corner_mesh(), {.two_sided = false}));
  const auto shared = std::make_shared<const TriangleMesh>(corner_mesh());
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
  EXPECT_EQ(hashes.size(), 15U) << "each scene above has a hash of its own";
}

// Two objects share a mesh. In each scene another one of them deforms, by the same displacements.
TEST(SceneHash, SaysWhichObjectDeforms) {
  const auto shared = std::make_shared<const TriangleMesh>(corner_mesh());
  std::set<std::uint64_t> hashes;
  for (const std::size_t deforming_object : {0U, 1U}) {
    TouchScene scene{{{shared, {}}, {shared, {}}}};
    scene.objects[deforming_object].deformation =
        std::make_shared<const MeshDeformation>(std::vector<MorphTarget>{{.vertices = {1}, .displacements = {Vec3(0, 0, 0.001)}}},
                                                std::vector<MorphKey>{{0.0, {0.0}}, {1.0, {1.0}}}, false);
    hashes.insert(hash_scene(scene));
  }
  EXPECT_EQ(hashes.size(), 2U);
}

// A haptics node and the windows of its vision nodes must agree on what is felt.
TEST(SceneHash, EachNumberOfEachEffectInSpaceChangesIt) {
  const EffectVolume ball = EffectVolume::ball(Vec3::Zero(), 0.01);
  const Vec3 off_centre(0, 0, 1);
  const std::vector<SwitchedEffect> effects = {SpringEffect(),
                                               SpringEffect{.centre = off_centre},
                                               SpringEffect{.stiffness_n_per_m = 7.0},
                                               SpringEffect{.max_force_n = 0.5},
                                               SwitchedEffect(SpringEffect(), {.button = 1}),
                                               ConstantEffect(),
                                               ConstantEffect{.force_n = 2.0 * off_centre},
                                               ConstantEffect{.volume = ball},
                                               SnapEffect(),
                                               SnapEffect{.target = SnapEffect::Target::line},
                                               SnapEffect{.position = off_centre},
                                               SnapEffect{.direction = Vec3::UnitX()},
                                               SnapEffect{.range_m = 0.03},
                                               SnapEffect{.max_force_n = 0.5},
                                               GravityWellEffect(),
                                               GravityWellEffect{.centre = off_centre},
                                               GravityWellEffect{.radius_m = 0.7},
                                               GravityWellEffect{.max_force_n = 0.5},
                                               ViscousEffect(),
                                               ViscousEffect{.damping_ns_per_m = 7.0},
                                               ViscousEffect{.max_force_n = 0.5},
                                               ViscousEffect{.volume = ball},
                                               WaveEffect(),
                                               WaveEffect{.waveform = Waveform::square},
                                               WaveEffect{.direction = Vec3::UnitX()},
                                               WaveEffect{.amplitude_n = 0.7},
                                               WaveEffect{.frequency_hz = 7.0},
                                               WaveEffect{.volume = ball},
                                               BurstEffect(),
                                               BurstEffect{.direction = Vec3::UnitX()},
                                               BurstEffect{.amplitude_n = 0.7},
                                               BurstEffect{.frequency_hz = 7.0},
                                               BurstEffect{.decay_s = 7.0},
                                               BurstEffect{.duration_s = 7.0},
                                               BurstEffect{.volume = ball},
                                               MassEffect(),
                                               MassEffect{.mass_kg = 0.7},
                                               MassEffect{.filter_s = 0.7},
                                               MassEffect{.max_force_n = 0.5},
                                               MassEffect{.volume = ball}};
  std::set<std::uint64_t> hashes;
  for (const SwitchedEffect& effect : effects) hashes.insert(hash_scene({.objects = {}, .effects = {effect}}));
  EXPECT_EQ(hashes.size(), effects.size());
}

}  // namespace
}  // namespace hapton
