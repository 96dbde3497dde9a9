#include "core/tool/near_features.h"

#include <gtest/gtest.h>

#include <random>

#include "core/geometry/mesh_shapes.h"
#include "core/geometry/triangle_distance.h"

namespace hapton {
namespace {

// The distance of two triangles that do not intersect, from points and edges.
double triangle_gap(const std::array<Vec3, 3>& a, const std::array<Vec3, 3>& b) {
  double least = 1e300;
  for (int k = 0; k < 3; ++k) {
    least = std::min(least, triangle_distance_squared(a[k], b[0], b[1], b[2]));
    least = std::min(least, triangle_distance_squared(b[k], a[0], a[1], a[2]));
    for (int j = 0; j < 3; ++j) {
      least = std::min(least, detail::segment_segment_distance_squared(of3(a[k]), of3(Vec3(a[(k + 1) % 3] - a[k])), of3(b[j]),
                                                                       of3(Vec3(b[(j + 1) % 3] - b[j]))));
    }
  }
  return std::sqrt(least);
}

class NearFeaturesTest : public testing::Test {
 protected:
  static constexpr unsigned kSeed = 47;
  std::mt19937_64 random{kSeed};
  std::uniform_real_distribution<double> uniform{-1.0, 1.0};
  const TriangleMesh ball = make_bumpy_sphere(0.3, 0.2, 300, 3);
  const TouchGeometry scene{std::vector<const TriangleMesh*>{&ball}};
  const ObjectGeometry tool{make_box({0.1, 0.2, 0.15}, 3), {Vec3::Zero(), scene.unit_m()}};
  NearFeatures near{tool, scene};

  double brute_distance(const Placement& at) const {
    double least = 1e300;
    for (std::uint32_t t = 0; t < tool.triangle_count(); ++t) {
      const std::array<Vec3, 3> a = {at.at(tool.corner(t, 0)), at.at(tool.corner(t, 1)), at.at(tool.corner(t, 2))};
      for (std::uint32_t s = 0; s < scene.triangle_count(); ++s) {
        least = std::min(least, triangle_gap(a, {scene.corner(s, 0), scene.corner(s, 1), scene.corner(s, 2)}));
      }
    }
    return least;
  }
};

// The nearest features are found, and the nearest of all is a minimum; also from candidates that an earlier call has kept.
TEST_F(NearFeaturesTest, TheNearestIsThatOfABruteForceSearchAndAMinimum) {
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  Placement at;
  int compared = 0;
  for (int n = 0; n < 200; ++n) {
    if (n % 10 == 0)
      at = {Vec3(uniform(random), uniform(random), uniform(random)).normalized() * 0.5,
            turn_by(3.0 * Vec3(uniform(random), uniform(random), uniform(random)))};
    at.position += 0.01 * Vec3(uniform(random), uniform(random), uniform(random));
    at.orientation = turn_by(0.02 * Vec3(uniform(random), uniform(random), uniform(random))) * at.orientation;
    const double distance = 0.15;
    if (!near.collect(at, distance, 0.0)) continue;
    const double brute = brute_distance(at);
    double least = 1e300;
    double least_minimum = 1e300;
    for (const NearFeature& feature : near.features()) {
      ASSERT_LE(feature.gap.distance, distance);
      least = std::min(least, feature.gap.distance);
      if (feature.is_minimum) least_minimum = std::min(least_minimum, feature.gap.distance);
    }
    if (brute > distance || brute < 1e-6) continue;
    ++compared;
    ASSERT_NEAR(least, brute, 1e-12) << "case " << n;
    ASSERT_NEAR(least_minimum, brute, 1e-9) << "case " << n;
  }
  EXPECT_GT(compared, 100);
}

TEST_F(NearFeaturesTest, NothingIsFoundFarAway) {
  ASSERT_TRUE(near.collect({Vec3(50.0, 0.0, 0.0), Quat::Identity()}, 1.0, 0.0));
  EXPECT_TRUE(near.features().empty());
}

}  // namespace
}  // namespace hapton
