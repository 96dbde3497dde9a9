#include "core/force/smooth/local_set.h"

#include <gtest/gtest.h>

#include <memory>

namespace hapton {
namespace {

TEST(LocalSet, CoversItsRadiusRoundItsPath) {
  const auto set = std::make_unique<LocalSet>();
  EXPECT_LT(set->radius_at(Vec3::Zero()), 0.0) << "nothing is known at first";
  set->from = Vec3(0, 0, 0);
  set->to = Vec3(2, 0, 0);
  set->radius = 1.0;
  set->nearest = 0.5;
  EXPECT_DOUBLE_EQ(set->distance_to_path(Vec3(1, 0, 0.25)), 0.25);
  EXPECT_DOUBLE_EQ(set->distance_to_path(Vec3(3, 0, 0)), 1.0);
  EXPECT_DOUBLE_EQ(set->radius_at(Vec3(1, 0, 0.25)), 0.75);
  EXPECT_DOUBLE_EQ(set->radius_at(Vec3(-2, 0, 0)), -1.0);
  EXPECT_DOUBLE_EQ(set->clearance_at(Vec3(1, 0, 0.25)), 0.25);
}

TEST(LocalSet, APathMayBeAPoint) {
  const auto set = std::make_unique<LocalSet>();
  set->from = set->to = Vec3(1, 1, 1);
  set->radius = 2.0;
  EXPECT_DOUBLE_EQ(set->radius_at(Vec3(1, 1, 2)), 1.0);
}

TEST(SetTriangle, AreOrderedByObjectAndThenByTriangle) {
  SetTriangle a;
  SetTriangle b;
  a.object = 1;
  a.triangle = 5;
  b.object = 1;
  b.triangle = 6;
  EXPECT_TRUE(a.before(b));
  EXPECT_FALSE(b.before(a));
  b.object = 0;
  EXPECT_TRUE(b.before(a));
}

}  // namespace
}  // namespace hapton
