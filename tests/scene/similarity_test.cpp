#include "scene/similarity.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

const Similarity kOuter{2.0, Quat(Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized())), Vec3(0.1, -0.2, 0.3)};
const Similarity kInner{0.3, Quat(Eigen::AngleAxisd(-1.1, Vec3(3, -1, 2).normalized())), Vec3(-4, 5, 6)};
const Vec3 kPoint(0.7, 0.8, -0.9);

TEST(Similarity, ScalesThenTurnsThenMoves) {
  const Similarity one{2.0, Quat(Eigen::AngleAxisd(M_PI / 2, Vec3::UnitZ())), Vec3(10, 0, 0)};
  EXPECT_LT((one.apply(Vec3(1, 0, 0)) - Vec3(10, 2, 0)).norm(), 1e-12);
}

TEST(Similarity, FollowsAnother) { EXPECT_LT((kOuter.then(kInner).apply(kPoint) - kOuter.apply(kInner.apply(kPoint))).norm(), 1e-12); }

TEST(Similarity, IsUndoneByItsInverse) { EXPECT_LT((kOuter.inverse().apply(kOuter.apply(kPoint)) - kPoint).norm(), 1e-12); }

TEST(Similarity, MovesAnObjectWithItsKeyframes) {
  ObjectSpec object;
  object.scale = kInner.scale;
  object.q_SM = kInner.q;
  object.p_SM = kInner.p;
  object.motion.keyframes = {{.time_s = 0.0}, {.time_s = 1.0, .p_SM = Vec3(1, 2, 3), .q_SM = kInner.q}};
  move_by(kOuter, object);
  EXPECT_LT((pose_of(object).apply(kPoint) - kOuter.apply(kInner.apply(kPoint))).norm(), 1e-12);
  EXPECT_FALSE(object.motion.keyframes[0].p_SM || object.motion.keyframes[0].q_SM) << "as at rest";
  EXPECT_LT((*object.motion.keyframes[1].p_SM - kOuter.apply(Vec3(1, 2, 3))).norm(), 1e-12);
  EXPECT_LT((*object.motion.keyframes[1].q_SM * kPoint - kOuter.q * (kInner.q * kPoint)).norm(), 1e-12);
}

}  // namespace
}  // namespace hapton
