#include "core/force/reference/half_space_projection.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace hapton {
namespace {

constexpr double kTolerance = 1e-13;

class Draw {
 public:
  explicit Draw(std::uint64_t seed) : random_(seed) {}
  Vec3 unit_vector() {
    Vec3 v;
    do v = Vec3(symmetric_(random_), symmetric_(random_), symmetric_(random_));
    while (v.squaredNorm() > 1.0 || v.squaredNorm() < 0.01);
    return v.normalized();
  }
  double symmetric() { return symmetric_(random_); }

 private:
  std::mt19937_64 random_;
  std::uniform_real_distribution<double> symmetric_{-1.0, 1.0};
};

void expect_optimal(const Vec3& goal, const std::vector<HalfSpace>& half_spaces, const HalfSpaceProjection& projection) {
  // Karush-Kuhn-Tucker conditions: feasible, moved by active planes alone, multipliers >= 0. For a projection they prove the minimum.
  ASSERT_TRUE(projection.feasible);
  Vec3 residual = projection.point - goal;
  for (int i = 0; i < projection.count; ++i) {
    EXPECT_GE(projection.multiplier[i], -1e-12);
    EXPECT_NEAR(half_spaces[projection.active[i]].normal.dot(projection.point), half_spaces[projection.active[i]].gap, 1e-12);
    residual -= projection.multiplier[i] * half_spaces[projection.active[i]].normal;
  }
  EXPECT_LT(residual.norm(), 1e-10);
  for (const HalfSpace& half_space : half_spaces) EXPECT_GE(half_space.normal.dot(projection.point) - half_space.gap, -1e-12);
}

TEST(HalfSpaceProjection, IsOptimalOnRandomFeasibleSets) {
  const std::uint64_t seed = 3;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  Draw draw(seed);
  int counts[4] = {};
  for (int i = 0; i < 20000; ++i) {
    std::vector<HalfSpace> half_spaces;
    const int n = 1 + i % 12;
    for (int k = 0; k < n; ++k) half_spaces.push_back({draw.unit_vector(), -0.2 * std::abs(draw.symmetric())});  // the origin is feasible
    const Vec3 goal = 2.0 * draw.unit_vector();
    const HalfSpaceProjection projection = project_onto_half_spaces(goal, half_spaces, kTolerance);
    expect_optimal(goal, half_spaces, projection);
    ++counts[projection.count];
  }
  for (int count : counts) EXPECT_GT(count, 100);
}

TEST(HalfSpaceProjection, IsOptimalOnConesWithTheApexAtTheOrigin) {
  const std::uint64_t seed = 4;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  Draw draw(seed);
  for (int i = 0; i < 20000; ++i) {
    std::vector<HalfSpace> half_spaces;
    for (int k = 0; k < 1 + i % 8; ++k) half_spaces.push_back({draw.unit_vector(), 0.0});
    const Vec3 goal = draw.unit_vector();
    expect_optimal(goal, half_spaces, project_onto_half_spaces(goal, half_spaces, kTolerance));
  }
}

TEST(HalfSpaceProjection, AGoalInsideIsReturnedToTheBit) {
  const std::vector<HalfSpace> half_spaces{{Vec3::UnitZ(), -1.0}, {Vec3::UnitX(), -1.0}};
  const Vec3 goal(0.1, 0.2, 0.3);
  const HalfSpaceProjection projection = project_onto_half_spaces(goal, half_spaces, kTolerance);
  EXPECT_EQ(projection.point, goal);
  EXPECT_EQ(projection.count, 0);
  EXPECT_EQ(project_onto_half_spaces(goal, {}, kTolerance).point, goal);
}

TEST(HalfSpaceProjection, IsExactOnDuplicateAndNearlyParallelPlanes) {
  for (double tilt : {0.0, 1e-15, 1e-12, 1e-9, 1e-6}) {
    std::vector<HalfSpace> half_spaces{{Vec3::UnitZ(), 0.0}, {Vec3(std::sin(tilt), 0.0, std::cos(tilt)), 0.0}, {Vec3::UnitZ(), 0.0}};
    const Vec3 goal(-0.3, 0.4, -1.0);
    const HalfSpaceProjection projection = project_onto_half_spaces(goal, half_spaces, kTolerance);
    ASSERT_TRUE(projection.feasible) << tilt;
    EXPECT_NEAR(projection.point.y(), 0.4, 1e-12) << tilt;
    EXPECT_NEAR(projection.point.x(), -0.3, 2.0 * tilt + 1e-12) << tilt;
  }
}

TEST(HalfSpaceProjection, SaysWhenThereIsNoCommonPoint) {
  const std::vector<HalfSpace> half_spaces{{Vec3::UnitZ(), 1.0}, {-Vec3::UnitZ(), 1.0}};
  EXPECT_FALSE(project_onto_half_spaces(Vec3::Zero(), half_spaces, kTolerance).feasible);
}

}  // namespace
}  // namespace hapton
