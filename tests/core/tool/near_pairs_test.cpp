#include "core/tool/near_pairs.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

Box box_at(const ObjectGeometry& surface, std::uint32_t t, const Placement& at) {
  Box box;
  for (int k = 0; k < 3; ++k) box.grow(at.at(surface.corner(t, k)));
  return box;
}

TEST(NearPairs, FindsEveryPairThatABruteForceSearchFinds) {
  constexpr unsigned kPairsSeed = 31;
  SCOPED_TRACE(testing::Message() << "seed " << kPairsSeed);
  std::mt19937_64 random(kPairsSeed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const TriangleMesh ball = make_bumpy_sphere(0.3, 0.2, 300, 3);
  const TriangleMesh box = scaled_and_moved(make_box({0.4, 0.2, 0.3}, 3), 1.0, {0.5, 0.0, 0.0});
  const TouchGeometry scene(std::vector<const TriangleMesh*>{&ball, &box});
  const ObjectGeometry tool(make_box({0.1, 0.2, 0.15}, 4), {Vec3::Zero(), scene.unit_m()});
  NearPairs near(tool, scene, 1U << 16);
  std::size_t overlap_count = 0;
  for (int n = 0; n < 60; ++n) {
    const Placement at{Vec3(uniform(random), uniform(random), uniform(random)),
                       turn_by(3.0 * Vec3(uniform(random), uniform(random), uniform(random)))};
    const double margin = 0.1 * std::abs(uniform(random));
    ASSERT_TRUE(near.collect(at, margin));
    std::set<std::pair<std::uint32_t, std::uint32_t>> pairs;
    for (const TrianglePairIds& ids : near.pairs()) EXPECT_TRUE(pairs.insert({ids.tool, ids.scene}).second) << "found twice";
    for (std::uint32_t t = 0; t < tool.triangle_count(); ++t) {
      const Box inflated_box = box_at(tool, t, at).inflated(margin);
      for (std::uint32_t o = 0; o < 2; ++o) {
        for (std::uint32_t s = 0; s < scene.object_geometry(o).triangle_count(); ++s) {
          if (!inflated_box.overlaps(box_at(scene.object_geometry(o), s, {}))) continue;
          ++overlap_count;
          // In the id, the bits of the object's number are above those of the triangle's number.
          const std::uint32_t id = s | (o == 0 ? 0U : scene.object_bits() & (~scene.object_bits() + 1U));
          ASSERT_EQ(pairs.count({t, id}), 1U) << "case " << n;
        }
      }
    }
    ASSERT_FALSE(!pairs.empty() && NearPairs(tool, scene, pairs.size() - 1).collect(at, margin)) << "one pair more than fits";
  }
  EXPECT_GT(overlap_count, 1000U);
}

}  // namespace
}  // namespace hapton
