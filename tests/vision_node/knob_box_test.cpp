#include "vision_node/knob_box.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "runtime/log.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

TEST(Dials, TurnAboutTheWorldsAxesThroughTheCentre) {
  const Vec3 centre(0.1, 0.2, 0.3);
  Dials dials;
  dials.turn(1, 90.0);
  const Pose X_WS = dials.compute_pose(centre);
  EXPECT_LT((X_WS * centre - centre).norm(), 1e-15);
  EXPECT_LT((X_WS * (centre + Vec3::UnitZ()) - (centre + Vec3::UnitX())).norm(), 1e-15);
  dials.turn(2, 90.0);
  EXPECT_LT((dials.compute_pose(centre) * (centre + Vec3::UnitZ()) - (centre + Vec3::UnitY())).norm(), 1e-15);
}

TEST(Dials, KeepWithinHalfATurnAndIgnoreInvalidAngles) {
  Dials dials;
  dials.turn(0, 170.0);
  dials.turn(0, 20.0);
  EXPECT_NEAR(dials.degrees.x(), -170.0, 1e-12);
  dials.turn(0, -10.0);
  EXPECT_NEAR(dials.degrees.x(), 180.0, 1e-12);
  const Dials before = dials;
  dials.turn(0, std::numeric_limits<double>::quiet_NaN());
  dials.turn(1, std::numeric_limits<double>::infinity());
  dials.turn(3, 5.0);
  dials.turn(-1, 5.0);
  EXPECT_EQ(dials, before);
}

TEST(Dials, AreFoundFromAPose) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> degrees(-180.0, 180.0);
  const Vec3 centre(0.05, 0.0, -0.02);
  for (int n = 0; n < 1000; ++n) {
    Dials dials{Vec3(degrees(random), degrees(random), degrees(random))};
    if (n % 10 == 0) dials.degrees.y() = n % 20 == 0 ? 90.0 : -90.0;
    const Pose X_WS = dials.compute_pose(centre);
    const std::optional<Dials> found = find_dials(from_twelve_floats(to_twelve_floats(X_WS)), centre);
    ASSERT_TRUE(found) << n;
    EXPECT_LT((found->compute_pose(centre).matrix() - X_WS.matrix()).cwiseAbs().maxCoeff(), 2e-6) << n;
  }
  // Angles as keys set them, at round numbers, are found exactly.
  const std::optional<Dials> set_by_keys =
      find_dials(from_twelve_floats(to_twelve_floats(Dials{Vec3(5, -35, 170)}.compute_pose(centre))), centre);
  ASSERT_TRUE(set_by_keys);
  EXPECT_EQ(set_by_keys->degrees, Vec3(5, -35, 170));
  Pose moved = Pose::Identity();
  moved.translation().x() = 1e-4;
  EXPECT_FALSE(find_dials(moved, centre));
}

TEST(TwelveFloats, ComeBackAsTheSamePoseToFloatPrecision) {
  Dials dials;
  dials.turn(0, 33.0);
  dials.turn(2, -71.0);
  const Pose X_WS = dials.compute_pose({0.05, 0.0, -0.02});
  const Pose back = from_twelve_floats(to_twelve_floats(X_WS));
  EXPECT_LT((back.matrix() - X_WS.matrix()).norm(), 1e-6);
  EXPECT_EQ(to_twelve_floats(X_WS)[3], static_cast<float>(X_WS.translation().x()));
}

TEST(ViewTransformSender, SendsOnceForEachChangeOnly) {
  ViewTransformSender sender;
  EXPECT_FALSE(sender.take_due(0));
  sender.set(Pose::Identity());
  auto sent = sender.take_due(0);
  ASSERT_TRUE(sent);
  EXPECT_EQ(sent->revision, 1u);
  sender.confirm(sent->revision == 1 ? 0 : 1);
  sender.confirm(1);
  for (int ms = 1; ms < 2000; ++ms) {
    sender.set(Pose::Identity());
    ASSERT_FALSE(sender.take_due(ms * kMs)) << "nothing changed, nothing lost";
  }
  Dials dials;
  dials.turn(0, 5.0);
  sender.set(dials.compute_pose(Vec3::Zero()));
  sent = sender.take_due(2000 * kMs);
  ASSERT_TRUE(sent);
  EXPECT_EQ(sent->revision, 2u);
  EXPECT_EQ(sent->X_WS, to_twelve_floats(dials.compute_pose(Vec3::Zero())));
  EXPECT_EQ(sender.sent(), 2u);
}

TEST(ViewTransformSender, SendsAgainUntilTheHubHasIt) {
  ViewTransformSender sender;
  sender.set(Pose::Identity());
  sender.confirm(0);
  ASSERT_TRUE(sender.take_due(0));
  int again = 0;
  for (int ms = 1; ms <= 1000; ++ms) {
    sender.confirm(0);  // the hub still has an older one: the transform was lost
    if (const auto sent = sender.take_due(ms * kMs)) {
      ++again;
      EXPECT_EQ(sent->revision, 1u);
    }
  }
  EXPECT_GE(again, 10);
  EXPECT_LE(again, 30) << "patiently, not in every turn of the loop";
  sender.confirm(1);
  EXPECT_FALSE(sender.take_due(5000 * kMs));
}

TEST(ViewTransformSender, SendsARejectedTransformNoMoreAndSaysSoOnce) {
  ViewTransformSender sender;
  sender.set(Pose::Identity());
  sender.confirm(0);
  ASSERT_TRUE(sender.take_due(0));
  start_log("test", LogLevel::info);
  testing::internal::CaptureStderr();
  sender.reject(9);  // not a revision that this sender sent
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  testing::internal::CaptureStderr();
  sender.reject(1);
  sender.reject(1);
  const std::string logged = testing::internal::GetCapturedStderr();
  EXPECT_NE(logged.find("rejected view transform 1: not a rigid pose"), std::string::npos) << logged;
  EXPECT_EQ(std::count(logged.begin(), logged.end(), '\n'), 1);
  sender.confirm(0);
  EXPECT_FALSE(sender.take_due(1000 * kMs));
  Dials dials;
  dials.turn(1, 40.0);
  sender.set(dials.compute_pose(Vec3::Zero()));
  EXPECT_TRUE(sender.take_due(1001 * kMs));
}

TEST(ViewTransformSender, SendsWhatItHasToAHubThatWasRestarted) {
  ViewTransformSender sender;
  Dials dials;
  dials.turn(1, 40.0);
  sender.set(Pose::Identity());
  ASSERT_TRUE(sender.take_due(0));
  sender.set(dials.compute_pose(Vec3::Zero()));
  ASSERT_TRUE(sender.take_due(1));
  sender.confirm(2);
  sender.rejoin();
  const auto sent = sender.take_due(2);
  ASSERT_TRUE(sent);
  EXPECT_EQ(sent->X_WS, to_twelve_floats(dials.compute_pose(Vec3::Zero())));
}

TEST(ViewTransformSender, GoesOnFromTheRevisionsOfAnEarlierVisionNode) {
  ViewTransformSender sender;
  sender.set(Pose::Identity());
  ASSERT_TRUE(sender.take_due(0));
  sender.confirm(41);  // the hub has the revision of an earlier node
  const auto sent = sender.take_due(1);
  ASSERT_TRUE(sent);
  EXPECT_EQ(sent->revision, 42u);
  sender.confirm(42);
  // When another vision node turns its dials, the two must not keep sending ever higher revisions.
  sender.confirm(50);
  EXPECT_FALSE(sender.take_due(1000 * kMs));
}

TEST(ViewTransformSender, KnowsThePoseOfARevisionForAWhile) {
  ViewTransformSender sender;
  EXPECT_FALSE(sender.find_pose(0));
  Dials dials;
  const auto turn_to = [&](double degrees) {
    dials.degrees.y() = degrees;
    sender.set(dials.compute_pose(Vec3::Zero()));
  };
  for (int i = 1; i <= 100; ++i) turn_to(0.5 * i);
  EXPECT_FALSE(sender.find_pose(0));
  EXPECT_FALSE(sender.find_pose(100 - ViewTransformSender::kHistory)) << "too long ago";
  EXPECT_FALSE(sender.find_pose(101)) << "not yet";
  for (const std::uint32_t revision : {100U - static_cast<std::uint32_t>(ViewTransformSender::kHistory) + 1U, 77U, 100U}) {
    dials.degrees.y() = 0.5 * revision;
    const auto pose = sender.find_pose(revision);
    ASSERT_TRUE(pose) << revision;
    EXPECT_TRUE(pose->isApprox(dials.compute_pose(Vec3::Zero()), 1e-6)) << revision;
  }
}

TEST(ViewTransformSender, KnowsThePoseUnderTheNumberThatGoesOnFromAnEarlierVisionNode) {
  ViewTransformSender sender;
  sender.set(Pose::Identity());
  sender.confirm(41);
  EXPECT_TRUE(sender.find_pose(42));
  EXPECT_FALSE(sender.find_pose(41));
}

ViewTransform hub_view(std::uint32_t revision, double degrees) {
  return {.revision = revision, .X_WS = to_twelve_floats(Dials{Vec3(0.0, degrees, 0.0)}.compute_pose(Vec3::Zero()))};
}

// Two vision nodes may begin with the same number.
TEST(ViewTransformSender, AFirstReportOfItsOwnNumberIsOfAnEarlierVisionNode) {
  ViewTransformSender sender;
  sender.set(Pose::Identity());
  ASSERT_TRUE(sender.take_due(0));
  sender.confirm(1);
  const auto sent = sender.take_due(1);
  ASSERT_TRUE(sent);
  EXPECT_EQ(sent->revision, 2u);
}

TEST(ViewTransformSender, AdoptsTheViewOfAnotherNodeWithItsOwnNumber) {
  ViewTransformSender sender;
  sender.set(Pose::Identity());
  ASSERT_TRUE(sender.take_due(0));
  const ViewTransform theirs = hub_view(1, 80.0);
  EXPECT_TRUE(sender.adopt(theirs));
  EXPECT_FALSE(sender.adopt(theirs)) << "the hub repeats it";
  const auto pose = sender.find_pose(1);
  ASSERT_TRUE(pose);
  EXPECT_EQ(to_twelve_floats(*pose), theirs.X_WS);
  sender.confirm(0);
  EXPECT_FALSE(sender.take_due(1000 * kMs)) << "it is not its own to repeat";
}

TEST(ViewTransformSender, ItsOwnPoseAfterAnAdoptedOneIsSentUntilTheHubHasIt) {
  ViewTransformSender sender;
  sender.set(Pose::Identity());
  ASSERT_TRUE(sender.adopt(hub_view(41, 80.0)));
  EXPECT_FALSE(sender.take_due(0));
  sender.set(Dials{Vec3(0.0, 85.0, 0.0)}.compute_pose(Vec3::Zero()));
  auto sent = sender.take_due(0);
  ASSERT_TRUE(sent);
  EXPECT_EQ(sent->revision, 42u);
  sender.confirm(41);  // the hub still has an older one: the transform was lost
  EXPECT_FALSE(sender.take_due(49 * kMs));
  sent = sender.take_due(50 * kMs);
  ASSERT_TRUE(sent);
  EXPECT_EQ(sent->revision, 42u);
  sender.confirm(42);
  EXPECT_FALSE(sender.take_due(5000 * kMs));
}

TEST(ViewTransformSender, CountsOnFromAViewThatItDoesNotTakeOver) {
  ViewTransformSender sender;
  sender.set(Pose::Identity());
  sender.count_from(7);
  EXPECT_EQ(sender.revision(), 7u);
  EXPECT_FALSE(sender.take_due(0));
  sender.count_from(3);  // an older revision that arrives late
  EXPECT_EQ(sender.revision(), 7u);
  sender.set(Dials{Vec3(0.0, 85.0, 0.0)}.compute_pose(Vec3::Zero()));
  const auto sent = sender.take_due(kMs);
  ASSERT_TRUE(sent);
  EXPECT_EQ(sent->revision, 8u);
}

}  // namespace
}  // namespace hapton
