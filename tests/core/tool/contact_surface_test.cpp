#include "core/tool/contact_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <set>
#include <tuple>

#include "core/geometry/mesh_shapes.h"
#include "core/tool/near_features.h"

namespace hapton {
namespace {

// A pair of features that are near: kind, closest points of tool and scene, distance, and whether it is a minimum.
using GapKey = std::tuple<int, std::array<double, 3>, std::array<double, 3>, double, bool>;

std::multiset<GapKey> gaps_of(const NearFeatures& near) {
  std::multiset<GapKey> gaps;
  for (const NearFeature& each : near.features()) {
    const Vec3& p = each.gap.on_tool;
    const Vec3& q = each.gap.on_scene;
    gaps.insert({static_cast<int>(each.pair.kind), {p.x(), p.y(), p.z()}, {q.x(), q.y(), q.z()}, each.gap.distance, each.is_minimum});
  }
  return gaps;
}

class ContactSurfaceTest : public testing::Test {
 protected:
  static constexpr unsigned kSeed = 1807;
  std::mt19937_64 random{kSeed};
  std::uniform_real_distribution<double> uniform{-1.0, 1.0};

  std::vector<std::shared_ptr<const TriangleMesh>> meshes{
      std::make_shared<TriangleMesh>(make_bumpy_sphere(0.3, 0.2, 300, 3)),
      std::make_shared<TriangleMesh>(scaled_and_moved(make_box({0.3, 0.2, 0.3}, 3), 1.0, {0.4, 0.0, 0.0})),
      std::make_shared<TriangleMesh>(),
      std::make_shared<TriangleMesh>(scaled_and_moved(make_cylinder(0.1, 0.4, 12, 2), 1.0, {-0.35, 0.1, 0.0}))};
  const TouchGeometry scene_at_once{meshes};
  std::vector<std::shared_ptr<const ContactSurface>> objects = prepare();
  const TouchGeometry joined_scene{geometries(), scene_at_once.frame()};

  std::vector<std::shared_ptr<const ContactSurface>> prepare() const {
    std::vector<std::shared_ptr<const ContactSurface>> prepared;
    for (const auto& mesh : meshes) {
      prepared.push_back(std::make_shared<const ContactSurface>(std::make_shared<const ObjectGeometry>(
          ObjectGeometry::make(*mesh, scene_at_once.frame(), TouchGeometry::most_triangles(meshes)))));
    }
    return prepared;
  }
  std::vector<std::shared_ptr<const ObjectGeometry>> geometries() const {
    std::vector<std::shared_ptr<const ObjectGeometry>> shared_geometries;
    for (const auto& object : objects) shared_geometries.emplace_back(object, &object->geometry());
    return shared_geometries;
  }
  Vec3 draw() {
    const double x = uniform(random);
    const double y = uniform(random);
    return {x, y, uniform(random)};
  }
};

// The twin is built from the same meshes at once: one tree over all triangles, and the features of each object.
TEST_F(ContactSurfaceTest, AJoinedSceneHasTheNearFeaturesOfOneThatIsBuiltAtOnce) {
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  const ObjectGeometry tool(make_box({0.1, 0.2, 0.15}, 2), {Vec3::Zero(), scene_at_once.unit_m()});
  NearFeatures near_at_once(tool, scene_at_once);
  NearFeatures near_in_joined(tool, std::make_shared<const ToolSurface>(tool), joined_scene,
                              std::make_shared<const SceneSurface>(objects, joined_scene));
  std::size_t feature_count = 0;
  std::set<std::uint32_t> touched_objects;
  for (int n = 0; n < 150; ++n) {
    const Placement at{{0.8 * uniform(random), 0.4 * uniform(random), 0.5 * uniform(random)}, turn_by(3.0 * draw())};
    ASSERT_TRUE(near_at_once.collect(at, 0.05, 0.01));
    ASSERT_TRUE(near_in_joined.collect(at, 0.05, 0.01));
    ASSERT_EQ(gaps_of(near_in_joined), gaps_of(near_at_once)) << n;
    const RigidMotion motion{at, 0.05 * draw(), 0.1 * draw()};
    ASSERT_TRUE(near_at_once.extend(motion, 0.01));
    ASSERT_TRUE(near_in_joined.extend(motion, 0.01));
    feature_count += near_in_joined.features().size();
    for (const NearFeature& each : near_in_joined.features()) touched_objects.insert(near_in_joined.object_of(each.pair));
  }
  EXPECT_GT(feature_count, 2000U);
  EXPECT_EQ(touched_objects, (std::set<std::uint32_t>{0, 1, 3}));
}

// The tool is the surface of a prepared object, relative to its grip point; its features refer to the prepared positions.
TEST_F(ContactSurfaceTest, AToolOfAPreparedObjectHasTheNearFeaturesOfOneThatIsBuiltAboutItsGrip) {
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  const TriangleMesh ball = make_bumpy_sphere(0.3, 0.2, 300, 8);
  const TouchGeometry scene(std::vector<const TriangleMesh*>{&ball});
  for (const std::uint32_t object : {0U, 1U, 3U}) {
    const Vec3 grip = objects[object]->geometry().corner(0, 0) + 0.01 * draw();
    const ObjectGeometry tool = objects[object]->geometry().with_origin_at(grip);
    NearFeatures anew(tool, scene);
    NearFeatures prepared(tool, std::make_shared<const ToolSurface>(objects[object], grip, tool), scene,
                          std::make_shared<const SceneSurface>(scene));
    EXPECT_EQ(prepared.radius(), anew.radius());
    std::size_t feature_count = 0;
    for (int n = 0; n < 60; ++n) {
      const Placement at{0.6 * draw().normalized(), turn_by(3.0 * draw())};
      ASSERT_TRUE(anew.collect(at, 0.05, 0.01));
      ASSERT_TRUE(prepared.collect(at, 0.05, 0.01));
      ASSERT_EQ(gaps_of(prepared), gaps_of(anew)) << "object " << object << ", " << n;
      feature_count += prepared.features().size();
    }
    EXPECT_GT(feature_count, 100U) << object;
  }
}

TEST_F(ContactSurfaceTest, CountsItsBytes) {
  EXPECT_EQ(objects[2]->geometry().triangle_count(), 0U);
  // The tree has one node of 64 bytes for each leaf and each branching.
  const std::size_t nodes = 2 * objects[0]->geometry().triangle_count() - 1;
  EXPECT_GE(objects[0]->bytes(), objects[0]->geometry().bytes() + 64 * nodes);
  EXPECT_LE(objects[0]->bytes(), objects[0]->geometry().bytes() + 128 * nodes);
}

}  // namespace
}  // namespace hapton
