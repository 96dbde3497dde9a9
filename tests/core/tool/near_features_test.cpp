#include "core/tool/near_features.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <vector>

#include "core/geometry/mesh_shapes.h"
#include "tests/support/triangle_gap.h"

namespace hapton {
namespace {

class NearFeaturesTest : public testing::Test {
 protected:
  static constexpr unsigned kSeed = 47;
  std::mt19937_64 random{kSeed};
  std::uniform_real_distribution<double> uniform{-1.0, 1.0};
  const TriangleMesh ball = make_bumpy_sphere(0.3, 0.2, 300, 3);
  const TouchGeometry scene{std::vector<const TriangleMesh*>{&ball}};
  const ObjectGeometry tool{make_box({0.1, 0.2, 0.15}, 3), {Vec3::Zero(), scene.unit_m()}};
  NearFeatures near{tool, scene};

  double brute_force_distance(const Placement& at) const {
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

// The nearest features are found, and the nearest of all is a minimum; also from candidates that an earlier collect has kept.
TEST_F(NearFeaturesTest, TheNearestIsThatOfABruteForceSearchAndAMinimum) {
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  Placement at;
  int compared_poses = 0;
  for (int n = 0; n < 200; ++n) {
    if (n % 10 == 0)
      at = {Vec3(uniform(random), uniform(random), uniform(random)).normalized() * 0.5,
            turn_by(3.0 * Vec3(uniform(random), uniform(random), uniform(random)))};
    at.position += 0.01 * Vec3(uniform(random), uniform(random), uniform(random));
    at.orientation = turn_by(0.02 * Vec3(uniform(random), uniform(random), uniform(random))) * at.orientation;
    const double distance = 0.15;
    if (!near.collect(at, distance, 0.0)) continue;
    const double expected = brute_force_distance(at);
    double least = 1e300;
    double least_minimum = 1e300;
    for (const NearFeature& feature : near.features()) {
      ASSERT_LE(feature.gap.distance, distance);
      least = std::min(least, feature.gap.distance);
      if (feature.is_minimum) least_minimum = std::min(least_minimum, feature.gap.distance);
    }
    if (expected > distance || expected < 1e-6) continue;
    ++compared_poses;
    ASSERT_NEAR(least, expected, 1e-12) << "case " << n;
    ASSERT_NEAR(least_minimum, expected, 1e-9) << "case " << n;
  }
  EXPECT_GT(compared_poses, 100);
}

// Identifies the two features of a pair by their corners, however the triangles around them are numbered.
using FeatureKey = std::pair<FeaturePair::Kind, std::vector<double>>;

FeatureKey key_of(const FeaturePair& pair) {
  const bool is_edge = pair.kind == FeaturePair::Kind::edge_edge;
  FeatureKey key{pair.kind, {}};
  const auto add = [&key](const std::array<Vec3, 3>& points, std::size_t count) {
    std::vector<std::array<double, 3>> sorted;
    for (std::size_t i = 0; i < count; ++i) sorted.push_back({points[i].x(), points[i].y(), points[i].z()});
    std::sort(sorted.begin(), sorted.end());
    for (const auto& p : sorted) key.second.insert(key.second.end(), p.begin(), p.end());
  };
  add(pair.tool, is_edge ? 2 : pair.kind == FeaturePair::Kind::vertex_face ? 1 : 3);
  add(pair.scene, is_edge ? 2 : pair.kind == FeaturePair::Kind::vertex_face ? 3 : 1);
  return key;
}

std::vector<FeaturePair> all_pairs_of(const std::array<Vec3, 3>& tool, const std::array<Vec3, 3>& scene) {
  std::vector<FeaturePair> pairs;
  for (int k = 0; k < 3; ++k) {
    pairs.push_back({.kind = FeaturePair::Kind::vertex_face, .tool = {tool[k]}, .scene = scene});
    pairs.push_back({.kind = FeaturePair::Kind::face_vertex, .tool = tool, .scene = {scene[k]}});
    for (int j = 0; j < 3; ++j) {
      pairs.push_back(
          {.kind = FeaturePair::Kind::edge_edge, .tool = {tool[k], tool[(k + 1) % 3]}, .scene = {scene[j], scene[(j + 1) % 3]}});
    }
  }
  return pairs;
}

// Compared with all pairs of features, at five times of the motion.
TEST_F(NearFeaturesTest, EveryPairThatAMotionBringsNearIsAmongThem) {
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::size_t near_count = 0;
  std::size_t added_count = 0;
  Placement at;
  for (int n = 0; n < 60; ++n) {
    if (n % 6 == 0)
      at = {Vec3(uniform(random), uniform(random), uniform(random)).normalized() * 0.5, turn_by(3.0 * Vec3(0.3, 0.1 * n, -0.2))};
    const double length = n % 2 == 0 ? 0.1 : 0.01;
    const double collected_distance = 0.01;
    const double distance = 0.02 * std::abs(uniform(random));
    const auto random_vector = [&] { return Vec3(uniform(random), uniform(random), uniform(random)); };
    const RigidMotion motion{at, length * random_vector(), length * random_vector()};
    ASSERT_TRUE(near.collect(at, collected_distance, 0.0));
    const std::size_t collected = near.features().size();
    // Called twice: pairs that are known are not added again.
    ASSERT_TRUE(near.extend(motion, distance));
    const std::size_t extended = near.features().size();
    ASSERT_TRUE(near.extend(motion, distance));
    ASSERT_EQ(near.features().size(), extended);
    added_count += extended - collected;
    std::set<FeatureKey> found_keys;
    for (const NearFeature& feature : near.features()) {
      ASSERT_TRUE(found_keys.insert(key_of(feature.pair)).second) << "found twice";
      ASSERT_EQ(feature.gap.distance, measure_gap(feature.pair, at).distance);
    }
    for (std::uint32_t t = 0; t < tool.triangle_count(); ++t) {
      const std::array<Vec3, 3> a = {tool.corner(t, 0), tool.corner(t, 1), tool.corner(t, 2)};
      for (std::uint32_t s = 0; s < scene.triangle_count(); ++s) {
        const std::array<Vec3, 3> b = {scene.corner(s, 0), scene.corner(s, 1), scene.corner(s, 2)};
        if (triangle_gap({at.at(a[0]), at.at(a[1]), at.at(a[2])}, b) > distance + 4.0 * length) continue;
        for (const FeaturePair& pair : all_pairs_of(a, b)) {
          double least = measure_gap(pair, at).distance - (collected_distance - distance);
          for (double time = 0.0; time <= 1.0; time += 0.25) least = std::min(least, measure_gap(pair, motion.at(time)).distance);
          if (least > distance - 1e-12) continue;
          ++near_count;
          ASSERT_EQ(found_keys.count(key_of(pair)), 1U) << "case " << n;
        }
      }
    }
    at = motion.at(0.5);
  }
  EXPECT_GT(near_count, 500U);
  EXPECT_GT(added_count, 100U);
}

// In a slide, most calls of collect measure only the features that were near before. Between two calls, extend asks for fewer of them.
TEST_F(NearFeaturesTest, ACollectAfterOthersFindsWhatOneFromTheRootsFinds) {
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  NearFeatures from_roots{tool, scene};
  const auto keys_of = [](const NearFeatures& features) {
    std::set<FeatureKey> keys;
    for (const NearFeature& feature : features.features()) keys.insert(key_of(feature.pair));
    return keys;
  };
  std::size_t feature_count = 0;
  for (int slide = 0; slide < 20; ++slide) {
    const auto random_vector = [&] { return Vec3(uniform(random), uniform(random), uniform(random)); };
    Placement at{random_vector().normalized() * (0.40 / scene.unit_m()), turn_by(3.0 * random_vector())};
    const double distance = 0.04;
    for (int n = 0; n < 40; ++n) {
      ASSERT_TRUE(near.collect(at, distance, 0.0));
      from_roots.restart();
      ASSERT_TRUE(from_roots.collect(at, distance, 0.0));
      ASSERT_EQ(keys_of(near), keys_of(from_roots)) << "slide " << slide << ", step " << n;
      feature_count += near.features().size();
      // The motion has a large turn: features near its axis move less than the bound for the whole tool.
      const RigidMotion motion{at, 0.2 * distance * random_vector(), 1.5 * distance / near.radius() * random_vector()};
      ASSERT_TRUE(near.extend(motion, 0x1p-20));
      at = motion.at(0.02 * std::abs(uniform(random)));
    }
  }
  EXPECT_GT(feature_count, 10000U);
}

// Several motions after one call of collect: the pairs that each brings near are measured at its end. Short motions need no walk.
TEST_F(NearFeaturesTest, FollowFindsAllThatACollectThereFinds) {
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  NearFeatures from_roots{tool, scene};
  const auto random_vector = [&] { return Vec3(uniform(random), uniform(random), uniform(random)); };
  std::size_t compared_features = 0;
  for (int slide = 0; slide < 40; ++slide) {
    Placement at{random_vector().normalized() * (0.40 / scene.unit_m()), turn_by(3.0 * random_vector())};
    ASSERT_TRUE(near.collect(at, 0.01, 0.02));
    for (int n = 0; n < 12; ++n) {
      const double distance = 0.01 * std::abs(uniform(random));
      const double length = n % 3 == 0 ? 0.1 * distance : 0.02;
      // Of several motions given to extend, the last one is carried out.
      ASSERT_TRUE(near.extend({at, length * random_vector(), length * random_vector()}, distance));
      const RigidMotion motion{at, length * random_vector(), length * random_vector()};
      ASSERT_TRUE(near.extend(motion, distance));
      at = motion.at(n % 2 == 0 ? 1.0 : std::abs(uniform(random)));
      const double turn = 0.05 * std::abs(uniform(random));
      near.follow(at, turn);
      from_roots.restart();
      ASSERT_TRUE(from_roots.collect(at, distance * (1.0 - 1e-9), turn));
      std::map<FeatureKey, NearFeature> followed;
      for (const NearFeature& feature : near.features()) {
        ASSERT_TRUE(followed.emplace(key_of(feature.pair), feature).second) << "found twice";
        ASSERT_EQ(feature.gap.distance, measure_gap(feature.pair, at).distance);
      }
      for (const NearFeature& feature : from_roots.features()) {
        const auto same = followed.find(key_of(feature.pair));
        ASSERT_NE(same, followed.end()) << "slide " << slide << ", motion " << n << ": a pair " << feature.gap.distance << " apart";
        ASSERT_EQ(same->second.gap.distance, feature.gap.distance);
        ASSERT_EQ(same->second.is_minimum, feature.is_minimum);
        ++compared_features;
      }
    }
  }
  EXPECT_GT(compared_features, 1000U);
}

// A triangle of the tool that is thousands of times as long as the scene, and so thin that rounding turns its normal far: no plane along
// this normal may hide the corner of the scene that its longest edge touches.
TEST_F(NearFeaturesTest, TheNormalOfALongThinTriangleHidesNothing) {
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  constexpr double kHalfLength = 1000.0;
  const ObjectGeometry needle{{{{-kHalfLength, 0, 0}, {kHalfLength, 0, 0}, {0.3 * kHalfLength, 1e-9, 0}}, {{0, 1, 2}}},
                              {Vec3::Zero(), scene.unit_m()}};
  NearFeatures near_needle{needle, scene};
  for (int n = 0; n < 300; ++n) {
    const Vec3 corner = scene.corner(static_cast<std::uint32_t>(random() % scene.triangle_count()), n % 3);
    const Quat turn = turn_by(3.0 * Vec3(uniform(random), uniform(random), uniform(random)));
    const Vec3 touched(0.5 * kHalfLength / scene.unit_m() * uniform(random), 0.0, 0.0);
    ASSERT_TRUE(near_needle.collect({(1.0 + 1e-7 * uniform(random)) * corner - turn * touched, turn}, 1e-6, 0.0));
    double least = 1e300;
    for (const NearFeature& feature : near_needle.features()) least = std::min(least, feature.gap.distance);
    EXPECT_LT(least, 2e-7) << "case " << n;
  }
}

TEST_F(NearFeaturesTest, NothingIsFoundFarAway) {
  ASSERT_TRUE(near.collect({Vec3(50.0, 0.0, 0.0), Quat::Identity()}, 1.0, 0.0));
  EXPECT_TRUE(near.features().empty());
}

}  // namespace
}  // namespace hapton
