#include "tools/dds/servo_force.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace hapton::dds {
namespace {

using Verdict = ServoForce::Verdict;

constexpr std::int64_t kServoMs = 1'000'000;
constexpr double kHuge = std::numeric_limits<double>::max();
const double kNan = std::numeric_limits<double>::quiet_NaN();
const double kInf = std::numeric_limits<double>::infinity();

ServoCommand command(const Vec3& force, std::uint64_t writer = 1) { return {.writer = writer, .frame_id = "world", .force_n = force}; }

TEST(ServoForce, IsZeroUntilACommandAndTwentyMillisecondsAfterTheLast) {
  ServoForce force("world", 2.0);
  EXPECT_TRUE(force.force_n(0).isZero(0.0));
  EXPECT_EQ(force.take(command(Vec3(1.0, 0.0, -1.0)), 100 * kServoMs), Verdict::accepted);
  EXPECT_EQ(force.force_n(100 * kServoMs), Vec3(1.0, 0.0, -1.0));
  EXPECT_EQ(force.force_n(120 * kServoMs - 1), Vec3(1.0, 0.0, -1.0));
  EXPECT_TRUE(force.force_n(120 * kServoMs).isZero(0.0));
}

TEST(ServoForce, IsScaledDownWithItsDirection) {
  ServoForce force("world", 2.0);
  EXPECT_EQ(force.take(command(Vec3(0.0, 30.0, -40.0)), 0), Verdict::reduced);
  EXPECT_LT((force.force_n(0) - Vec3(0.0, 1.2, -1.6)).norm(), 1e-12);
  for (const Vec3& large : {Vec3(kHuge, kHuge, kHuge), Vec3(1e200, 0.0, 1.0), Vec3(-kHuge, 0.0, 0.0)}) {
    EXPECT_EQ(force.take(command(large), 0), Verdict::reduced);
    EXPECT_NEAR(force.force_n(0).norm(), 2.0, 1e-12) << large.transpose();
  }
}

TEST(ServoForce, ALimitOfZeroGivesZero) {
  ServoForce force("world", 0.0);
  EXPECT_EQ(force.take(command(Vec3(1.0, 2.0, 3.0)), 0), Verdict::reduced);
  EXPECT_TRUE(force.force_n(0).isZero(0.0));
  EXPECT_EQ(force.take(command(Vec3::Zero()), 0), Verdict::accepted);
}

TEST(ServoForce, AnInvalidForceReleasesTheLastOne) {
  ServoForce force("world", 2.0);
  for (const double bad : {kNan, kInf, -kInf}) {
    force.take(command(Vec3(1.0, 0.0, 0.0)), 0);
    EXPECT_EQ(force.take(command(Vec3(0.0, bad, 0.0)), 0), Verdict::not_finite);
    EXPECT_TRUE(force.force_n(0).isZero(0.0));
  }
  force.take(command(Vec3(1.0, 0.0, 0.0)), 0);
  ServoCommand turning = command(Vec3(1.0, 0.0, 0.0));
  turning.torque_nm.z() = 1e-6;
  EXPECT_EQ(force.take(turning, 0), Verdict::has_torque);
  EXPECT_TRUE(force.force_n(0).isZero(0.0));
  EXPECT_EQ(force.counts().not_finite, 3U);
  EXPECT_EQ(force.counts().has_torque, 1U);
}

TEST(ServoForce, TorquesAreTakenWhereTheyAreAllowedAndScaledDown) {
  ServoForce force("world", 2.0, 0.1);
  ServoCommand turning = command(Vec3(1.0, 0.0, 0.0));
  turning.torque_nm = Vec3(0.0, 0.03, 0.04);
  EXPECT_EQ(force.take(turning, 0), Verdict::accepted);
  EXPECT_EQ(force.force_n(0), turning.force_n);
  EXPECT_EQ(force.torque_nm(0), turning.torque_nm);
  EXPECT_TRUE(force.torque_nm(20 * kServoMs).isZero(0.0));
  turning.torque_nm = Vec3(0.0, kHuge, 0.0);
  EXPECT_EQ(force.take(turning, 0), Verdict::reduced);
  EXPECT_EQ(force.force_n(0), turning.force_n);
  EXPECT_LT((force.torque_nm(0) - Vec3(0.0, 0.1, 0.0)).norm(), 1e-12);
  turning.torque_nm = Vec3(0.0, kNan, 0.0);
  EXPECT_EQ(force.take(turning, 0), Verdict::not_finite);
  EXPECT_TRUE(force.force_n(0).isZero(0.0) && force.torque_nm(0).isZero(0.0));
  EXPECT_EQ(force.counts().has_torque, 0U);
  // A command without a torque leaves no torque.
  turning.torque_nm = Vec3(0.0, 0.05, 0.0);
  force.take(turning, 0);
  force.take(command(Vec3(1.0, 0.0, 0.0)), 0);
  EXPECT_TRUE(force.torque_nm(0).isZero(0.0));
}

TEST(ServoForce, AnotherFrameDoesNotRenewAForce) {
  ServoForce force("world", 2.0);
  force.take(command(Vec3(1.0, 0.0, 0.0)), 0);
  for (const char* frame : {"", "World", "world ", "camera"}) {
    ServoCommand other = command(Vec3(1.0, 0.0, 0.0));
    other.frame_id = frame;
    EXPECT_EQ(force.take(other, 19 * kServoMs), Verdict::wrong_frame) << frame;
  }
  EXPECT_TRUE(force.force_n(20 * kServoMs).isZero(0.0));
}

TEST(ServoForce, OneWriterAtATime) {
  ServoForce force("world", 2.0);
  force.take(command(Vec3(1.0, 0.0, 0.0), 7), 0);
  EXPECT_EQ(force.take(command(Vec3(-1.0, 0.0, 0.0), 8), kServoMs), Verdict::other_writer);
  EXPECT_EQ(force.take(command(Vec3(0.0, kNan, 0.0), 8), kServoMs), Verdict::other_writer);
  EXPECT_EQ(force.force_n(kServoMs), Vec3(1.0, 0.0, 0.0));
  EXPECT_EQ(force.take(command(Vec3(-1.0, 0.0, 0.0), 8), 20 * kServoMs), Verdict::accepted);
  EXPECT_EQ(force.force_n(20 * kServoMs), Vec3(-1.0, 0.0, 0.0));
}

// Whatever comes, the force is finite, no larger than allowed and no older than 20 ms.
TEST(ServoForce, StaysWithinItsBoundsForAnyCommands) {
  for (const unsigned seed : {1U, 2U, 3U, 4U}) {
    std::mt19937_64 random(seed);
    ServoForce force("world", 1.5);
    std::int64_t now_ns = 0;
    std::int64_t last_accepted_ns = -ServoForce::kMaxAgeNs;
    for (int i = 0; i < 20'000; ++i) {
      now_ns += static_cast<std::int64_t>(random() % (8 * kServoMs));
      const auto number = [&] {
        static const double kNumbers[] = {0.0, -0.5, 1.0, 3.0, -1e300, kNan, kInf, 5e-324};
        return kNumbers[random() % 8];
      };
      ServoCommand random_command = command(Vec3(number(), number(), number()), 1 + random() % 3);
      if (random() % 8 == 0) random_command.frame_id = "elsewhere";
      const Verdict verdict = force.take(random_command, now_ns);
      if (verdict == Verdict::accepted || verdict == Verdict::reduced) last_accepted_ns = now_ns;
      const std::int64_t later_ns = now_ns + static_cast<std::int64_t>(random() % (30 * kServoMs));
      const Vec3 force_n = force.force_n(later_ns);
      ASSERT_TRUE(force_n.allFinite()) << seed;
      ASSERT_LE(force_n.norm(), 1.5 + 1e-12) << seed;
      if (later_ns - last_accepted_ns >= ServoForce::kMaxAgeNs) {
        ASSERT_TRUE(force_n.isZero(0.0)) << seed;
      }
    }
  }
}

}  // namespace
}  // namespace hapton::dds
