// Forces that another DDS implementation sends: they are limited, end soon without a new one, and are off by default.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#if defined(HAPTON_WITH_DDS) && defined(HAPTON_WITH_FAST_DDS)

#include <algorithm>
#include <chrono>
#include <fstream>
#include <limits>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "tests/dds/bridge.h"
#include "tests/dds/fast_node.h"
#include "tests/process/system.h"

namespace hapton::dds_test {
namespace {

using process::kPatience;
using process::System;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Key;
using ::testing::Not;

const std::string kServo = "rt/hapton/servo_cf";

// The forces on the hand as ROS 2 sees them, while commands are sent.
class CommandTest : public ::testing::Test {
 protected:
  explicit CommandTest(std::vector<std::string> io_options = {"--vision-rate", "2000"}) : system_(std::move(io_options)) {}

  // Replaces System's own trajectory: the hand rests above the cube.
  void rest() const { std::ofstream(system_.folder() / "taps.csv") << "t_s,x_m,y_m,z_m\n0,0.01,0.02,0.07\n600,0.01,0.02,0.07\n"; }
  void begin(const std::vector<std::string>& more) {
    rest();
    system_.start("io_node");
    bridge_.emplace(system_, more);
    ASSERT_TRUE(bridge_->is_publishing()) << bridge_->err();
    ros_.emplace(domain());
    if (more == std::vector<std::string>{"--prefix", "watch"}) wrench_topic_ = "rt/watch/measured_cf";
    ros_->subscribe(wrench_topic_, kWrench);
    ASSERT_TRUE(System::wait_until([&] { return ros_->is_matched(wrench_topic_); }));
  }
  // Calls send repeatedly until holds(force) is true for the newest wrench. False: not within kPatience.
  template <class Send, class Holds>
  bool reaches(Send&& send, Holds&& holds) {
    const auto end = std::chrono::steady_clock::now() + kPatience;
    while (std::chrono::steady_clock::now() < end) {
      send();
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
      for (const auto& bytes : ros_->take(wrench_topic_)) {
        const auto numbers = FastNode::read_stamped(bytes, 6).numbers;
        force_ = Vec3(numbers[0], numbers[1], numbers[2]);
        torque_ = Vec3(numbers[3], numbers[4], numbers[5]);
        largest_force_n_ = std::max(largest_force_n_, force_.norm());
        largest_torque_nm_ = std::max(largest_torque_nm_, torque_.norm());
        ++wrench_count_;
      }
      if (wrench_count_ > 0 && holds(force_)) return true;
    }
    return false;
  }

  System system_;
  std::optional<Bridge> bridge_;
  std::optional<FastNode> ros_;
  std::string wrench_topic_ = "rt/hapton/measured_cf";
  Vec3 force_ = Vec3::Zero();
  Vec3 torque_ = Vec3::Zero();
  double largest_force_n_ = 0.0;
  double largest_torque_nm_ = 0.0;
  int wrench_count_ = 0;
};

bool is_zero(const Vec3& force) { return force.isZero(0.0); }

TEST_F(CommandTest, AForceIsScaledDownAndEndsWithItsPublisher) {
  begin({"--accept-forces", "0.5"});
  const auto command = [&] { ros_->write_wrench(kServo, "world", 0.0, 3.0, -4.0); };
  EXPECT_TRUE(reaches(command, [](const Vec3& force) { return (force - Vec3(0.0, 0.3, -0.4)).norm() < 1e-9; })) << force_.transpose();
  EXPECT_TRUE(reaches([] {}, is_zero)) << "a command counts for 20 ms";
  EXPECT_LE(largest_force_n_, 0.5 + 1e-9);
  // A force that is smaller than the limit.
  const auto smaller = [&] { ros_->write_wrench(kServo, "world", 0.25, 0.0, 0.0); };
  EXPECT_TRUE(reaches(smaller, [](const Vec3& force) { return (force - Vec3(0.25, 0.0, 0.0)).norm() < 1e-9; })) << force_.transpose();
  const std::string out = bridge_->end();
  EXPECT_THAT(out, HasSubstr("forces taken"));
  EXPECT_THAT(out, HasSubstr("scaled down"));
  system_.end_all();
}

TEST_F(CommandTest, AnInvalidCommandReleasesTheForce) {
  begin({"--accept-forces", "1"});
  const auto good = [&] { ros_->write_wrench(kServo, "world", 0.0, 0.4, 0.0); };
  const auto is_full = [](const Vec3& force) { return (force - Vec3(0.0, 0.4, 0.0)).norm() < 1e-9; };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  ASSERT_TRUE(reaches(good, is_full));
  EXPECT_TRUE(reaches([&] { ros_->write_wrench(kServo, "world", nan, 0.0, 0.0); }, is_zero));
  ASSERT_TRUE(reaches(good, is_full));
  EXPECT_TRUE(reaches([&] { ros_->write_wrench(kServo, "world", 0.0, 0.4, 0.0, 0.1); }, is_zero)) << "with a torque";
  ASSERT_TRUE(reaches(good, is_full));
  EXPECT_TRUE(reaches([&] { ros_->write_wrench(kServo, "camera", 0.0, 0.4, 0.0); }, is_zero)) << "in another frame";
  EXPECT_LE(largest_force_n_, 0.4 + 1e-9);
  bridge_->end();
  system_.end_all();
}

TEST_F(CommandTest, AFloodIsHeldWithinTheLimit) {
  begin({"--accept-forces", "0.5"});
  int sent_wrenches = 0;
  const auto flood = [&] {
    for (int i = 0; i < 50; ++i) ros_->write_wrench(kServo, "world", 0.0, i % 2 == 0 ? 1e300 : 0.4, 0.0);
    sent_wrenches += 50;
  };
  EXPECT_TRUE(reaches(flood, [&](const Vec3& force) { return sent_wrenches >= 5'000 && force.y() > 0.1; })) << force_.transpose();
  EXPECT_TRUE(reaches([] {}, is_zero));
  EXPECT_LE(largest_force_n_, 0.5 + 1e-9);
  EXPECT_THAT(bridge_->end(), HasSubstr(", 0 failed"));
  system_.end_all();
}

TEST_F(CommandTest, OfTwoPublishersOneCounts) {
  begin({"--accept-forces", "1"});
  FastNode other(domain());
  const auto both = [&] {
    ros_->write_wrench(kServo, "world", 0.0, 0.4, 0.0);
    other.write_wrench(kServo, "world", 0.0, 0.4, 0.0);
  };
  EXPECT_TRUE(reaches(both, [&](const Vec3& force) {
    return force.y() > 0.39 && bridge_->out().find("two publishers at a time") != std::string::npos;
  })) << bridge_->out();
  EXPECT_LE(largest_force_n_, 0.4 + 1e-9);
  bridge_->end();
  system_.end_all();
}

// A second bridge, which takes no forces, shows the force on the hand.
TEST_F(CommandTest, ACrashLeavesNoForce) {
  begin({"--prefix", "watch"});
  Bridge accepting(system_, {"--accept-forces", "1", "--prefix", "hapton"});
  ASSERT_TRUE(accepting.is_publishing()) << accepting.err();
  const auto command = [&] { ros_->write_wrench(kServo, "world", 0.0, 0.4, 0.0); };
  ASSERT_TRUE(reaches(command, [](const Vec3& force) { return force.y() > 0.39; })) << force_.transpose();
  accepting.kill();
  EXPECT_TRUE(reaches(command, is_zero)) << force_.transpose();
  const process::Json report = system_.request_report();
  EXPECT_GE(process::count(report, "command_timeouts"), 1);
  bridge_->end();
  system_.end_all();
}

TEST_F(CommandTest, WithoutConsentNothingIsTaken) {
  begin({});
  for (int i = 0; i < 100; ++i) reaches([&] { ros_->write_wrench(kServo, "world", 0.0, 1.0, 0.0); }, [](const Vec3&) { return true; });
  EXPECT_EQ(largest_force_n_, 0.0);
  EXPECT_THAT(ros_->readers(), Not(Contains(Key(kServo))));
  bridge_->end();
  system_.end_all();
}

// A device with motors that turn the stylus. --max-torque limits it to 0.05 Nm; its own limit is 0.17 Nm.
class TorqueTest : public CommandTest {
 protected:
  TorqueTest() : CommandTest({"--vision-rate", "2000", "--device", "simulated-6dof", "--max-torque", "0.05"}) {}
  bool turns(double tx_nm, double expected_nm) {
    return reaches([&] { ros_->write_wrench(kServo, "world", 0.0, 0.2, 0.0, tx_nm); },
                   [&](const Vec3& force) { return (torque_ - Vec3(expected_nm, 0.0, 0.0)).norm() < 1e-9 && force.y() > 0.1; });
  }
};

// The same device, started with --max-torque 0: it may exert no torque.
class ForbiddenTorqueTest : public CommandTest {
 protected:
  ForbiddenTorqueTest() : CommandTest({"--vision-rate", "2000", "--device", "simulated-6dof", "--max-torque", "0"}) {}
};

TEST_F(ForbiddenTorqueTest, TheForceComesAlone) {
  begin({"--accept-forces", "0.5", "--accept-torques", "0.15"});
  const auto command = [&] { ros_->write_wrench(kServo, "world", 0.0, 0.2, 0.0, 0.1); };
  int with_force = 0;
  EXPECT_TRUE(reaches(command, [&](const Vec3& force) { return force.y() > 0.19 && ++with_force > 50; })) << force_.transpose();
  EXPECT_EQ(largest_torque_nm_, 0.0);
  bridge_->end();
  system_.end_all();
}

TEST_F(TorqueTest, ATorqueReachesTheHandAndEndsWithItsPublisher) {
  begin({"--accept-forces", "0.5", "--accept-torques", "0.04"});
  EXPECT_TRUE(turns(0.03, 0.03)) << torque_.transpose();
  EXPECT_LE(largest_torque_nm_, 0.03 + 1e-9);
  // `hapton dds` scales the torque down.
  EXPECT_TRUE(turns(-5.0, -0.04)) << torque_.transpose();
  EXPECT_LE(largest_torque_nm_, 0.04 + 1e-9);
  EXPECT_TRUE(reaches([] {}, [&](const Vec3& force) { return is_zero(force) && torque_.isZero(0.0); })) << "a command counts for 20 ms";
  EXPECT_THAT(bridge_->end(), HasSubstr("torques above 0.04 Nm"));
  system_.end_all();
}

TEST_F(TorqueTest, TheGovernorLimitsWhatIsAccepted) {
  begin({"--accept-forces", "0.5", "--accept-torques", "0.15"});
  EXPECT_TRUE(turns(0.15, 0.05)) << torque_.transpose();
  EXPECT_LE(largest_torque_nm_, 0.05 + 1e-9);
  bridge_->end();
  system_.end_all();
}

TEST_F(TorqueTest, WithoutConsentNoTorqueIsTaken) {
  begin({"--accept-forces", "0.5"});
  const auto turning = [&] { ros_->write_wrench(kServo, "world", 0.0, 0.2, 0.0, 0.03); };
  int sent_wrenches = 0;
  EXPECT_TRUE(reaches(turning, [&](const Vec3&) { return ++sent_wrenches > 200; }));
  EXPECT_EQ(largest_torque_nm_, 0.0);
  EXPECT_EQ(largest_force_n_, 0.0) << "the wrench is dropped as a whole";
  EXPECT_THAT(bridge_->end(), HasSubstr("allow torques with --accept-torques"));
  system_.end_all();
}

// The device has three motors: it gets the force without the torque.
TEST_F(CommandTest, ADeviceThatCannotTurnTheStylusGetsNoTorque) {
  begin({"--accept-forces", "0.5", "--accept-torques", "0.1"});
  const auto command = [&] { ros_->write_wrench(kServo, "world", 0.0, 0.25, 0.0, 0.05); };
  EXPECT_TRUE(reaches(command, [](const Vec3& force) { return (force - Vec3(0.0, 0.25, 0.0)).norm() < 1e-9; })) << force_.transpose();
  EXPECT_EQ(largest_torque_nm_, 0.0);
  bridge_->end();
  system_.end_all();
}

}  // namespace
}  // namespace hapton::dds_test

#endif
