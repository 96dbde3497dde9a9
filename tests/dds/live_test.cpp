// The device as another DDS implementation sees it: names, types, QoS, values, frames, stamps.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#if defined(HAPTON_WITH_DDS) && defined(HAPTON_WITH_FAST_DDS)

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <fstream>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "tests/dds/bridge.h"
#include "tests/dds/fast_node.h"
#include "tests/process/system.h"

namespace hapton::dds_test {
namespace {

using process::System;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Key;
using ::testing::Not;

// A haptics node that replies to every sample with the same force. It runs in its own thread until it is destroyed.
class Responder {
 public:
  Responder(const System& system, const ForceCommand& reply)
      : reply_(reply), hub_(*parse_address(system.hub())), sealed_(*endpoint_, clock_, RoleKey(system.key(), KeyRole::haptics), hub_) {
    thread_ = std::thread([this] { run(); });
  }
  ~Responder() {
    is_over_ = true;
    thread_.join();
  }

 private:
  void run() {
    Datagram datagram;
    while (!is_over_) {
      if (!client_.receive(datagram, clock_.now_ns() + 20 * kNanosecondsPerMillisecond)) continue;
      const auto* state = std::get_if<DeviceState>(&datagram.message);
      if (state == nullptr) continue;
      reply_.echo_sample = state->sample;
      reply_.echo_sample_time_ns = state->sample_time_ns;
      client_.send(reply_);
    }
  }
  ForceCommand reply_;
  SteadyClock clock_;
  Address hub_;
  std::unique_ptr<Endpoint> endpoint_ = *open_udp_endpoint("127.0.0.1:0");
  SealedClient sealed_;
  HubClient client_{sealed_, clock_, NodeRole::haptics, hub_};
  std::atomic<bool> is_over_{false};
  std::thread thread_;
};

// A straight line, so slow (0.2 mm/s) that its position tells the time, and so long that no test reaches its end.
constexpr double kDurationS = 600.0;
const Vec3 kStart(0.011, -0.023, 0.037);
const Vec3 kVelocity(1e-4, -2e-4, 5e-5);
constexpr double kTurnRadPerS = 2e-3;  // about z
constexpr double kFirstTurnRad = 0.5;
constexpr std::uint32_t kButtons = 0x80000005;

// Replaces the trajectory that io_node replays (System's taps) by the line. Call this before io_node starts.
void write_line(const System& system) {
  std::ofstream file(system.folder() / "taps.csv");
  file << "t_s,x_m,y_m,z_m,qw,qx,qy,qz,buttons\n";
  file.precision(17);
  for (int i = 0; i <= 60; ++i) {
    const double t_s = kDurationS * i / 60;
    const Vec3 p = kStart + t_s * kVelocity;
    const double half_rad = 0.5 * (kFirstTurnRad + t_s * kTurnRadPerS);
    file << t_s << ',' << p.x() << ',' << p.y() << ',' << p.z() << ',' << std::cos(half_rad) << ",0,0," << std::sin(half_rad) << ','
         << kButtons << '\n';
  }
}

// The time at which the hand on the line has this pose (x, y, z, then the quaternion), s.
double time_of(const std::vector<double>& pose) { return (pose.at(0) - kStart.x()) / kVelocity.x(); }

void expect_on_the_line(const std::vector<double>& pose) {
  const double t_s = time_of(pose);
  EXPECT_GE(t_s, -1e-6);
  EXPECT_LT(t_s, kDurationS);
  const Vec3 p = kStart + t_s * kVelocity;
  EXPECT_NEAR(pose.at(1), p.y(), 1e-9);
  EXPECT_NEAR(pose.at(2), p.z(), 1e-9);
  const double half_rad = 0.5 * (kFirstTurnRad + t_s * kTurnRadPerS);
  EXPECT_NEAR(pose.at(3), 0.0, 1e-6);
  EXPECT_NEAR(pose.at(4), 0.0, 1e-6);
  EXPECT_NEAR(pose.at(5), std::sin(half_rad), 1e-5);
  EXPECT_NEAR(pose.at(6), std::cos(half_rad), 1e-5);
}

TEST(DdsLive, TopicsHaveTheNamesTypesAndQosOfRos2) {
  System system;
  system.start("io_node");
  Bridge bridge(system, {"--prefix", "arm/pen"});
  ASSERT_TRUE(bridge.is_publishing()) << bridge.err();
  FastNode ros(domain());
  ASSERT_TRUE(System::wait_until([&] { return ros.writers().size() >= 6; }));
  const std::map<std::string, std::string> expected = {
      {"rt/arm/pen/measured_cp", kPose},       {"rt/arm/pen/measured_cv", kTwist}, {"rt/arm/pen/measured_cf", kWrench},
      {"rt/arm/pen/proxy/measured_cp", kPose}, {"rt/arm/pen/joy", kJoy},           {"rt/tf", kTransforms}};
  const auto writers = ros.writers();
  for (const auto& [topic, type] : expected) {
    ASSERT_THAT(writers, Contains(Key(topic)));
    EXPECT_EQ(writers.at(topic).type, type);
    EXPECT_EQ(writers.at(topic).is_reliable, topic == "rt/tf") << topic;
    EXPECT_FALSE(writers.at(topic).is_transient) << topic;
    EXPECT_FALSE(writers.at(topic).has_key) << topic;
  }
  // Force commands from ROS are off by default.
  EXPECT_THAT(ros.readers(), Not(Contains(Key("rt/arm/pen/servo_cf"))));
  ros.subscribe("rt/arm/pen/measured_cp", kPose);
  EXPECT_TRUE(System::wait_until([&] { return !ros.take("rt/arm/pen/measured_cp").empty(); }));
  EXPECT_THAT(bridge.end(), HasSubstr("messages published, 0 failed"));
  system.end_all();
}

// If the host has a network address, a ROS 2 node announces that address. In this test no setting makes either side use loopback.
TEST(DdsLive, AProgramOfThisHostWithDefaultSettingsSeesIt) {
  ::unsetenv("CYCLONEDDS_URI");
  System system;
  system.start("io_node");
  Bridge bridge(system, {}, "");
  ASSERT_TRUE(bridge.is_publishing()) << bridge.err();
  FastNode ros(domain(), FastNode::Reach::as_ros);
  ros.subscribe("rt/hapton/measured_cp", kPose);
  EXPECT_TRUE(System::wait_until([&] { return !ros.take("rt/hapton/measured_cp").empty(); }));
  bridge.end();
  system.end_all();
}

TEST(DdsLive, TwoAtATimeDoNotDisturbEachOther) {
  System system;
  system.start("io_node");
  Bridge left(system, {"--prefix", "left"});
  Bridge right(system, {"--prefix", "right"});
  ASSERT_TRUE(left.is_publishing()) << left.err();
  ASSERT_TRUE(right.is_publishing()) << right.err();
  FastNode ros(domain());
  for (const char* side : {"left", "right"}) ros.subscribe(std::string("rt/") + side + "/measured_cp", kPose);
  for (const char* side : {"left", "right"}) {
    EXPECT_TRUE(System::wait_until([&] { return !ros.take(std::string("rt/") + side + "/measured_cp").empty(); })) << side;
  }
  left.end();
  ros.take("rt/right/measured_cp");
  EXPECT_TRUE(System::wait_until([&] { return !ros.take("rt/right/measured_cp").empty(); }));
  right.end();
  system.end_all();
}

TEST(DdsLive, ValuesAreInTheirFieldsAndFrames) {
  System system({"--vision-rate", "2000"});
  write_line(system);
  system.start("io_node");
  ForceCommand reply;
  reply.force_n = Vec3(0.1, -0.2, 0.3);
  reply.visual_offset_m = Vec3(0.001, 0.002, -0.003);
  reply.visual_turn = Vec3(0.0, 0.0, 0.25);
  reply.contact = true;
  const Responder responder(system, reply);
  Bridge bridge(system, {"--frame", "table"});
  ASSERT_TRUE(bridge.is_publishing()) << bridge.err();
  FastNode ros(domain());
  ros.subscribe("rt/hapton/measured_cp", kPose);
  ros.subscribe("rt/hapton/proxy/measured_cp", kPose);
  ros.subscribe("rt/hapton/measured_cv", kTwist);
  ros.subscribe("rt/hapton/measured_cf", kWrench);
  ros.subscribe("rt/hapton/joy", kJoy);
  ros.subscribe("rt/tf", kTransforms, true);
  std::map<std::int64_t, std::vector<double>> poses;
  std::map<std::int64_t, std::vector<double>> proxies;
  std::map<std::int64_t, std::vector<double>> twists;
  std::map<std::int64_t, std::vector<double>> wrenches;
  std::optional<Joy> joy;
  std::vector<Transform> transforms;
  const auto collect = [&](const std::string& topic, std::size_t numbers, auto& into) {
    std::int64_t before_ns = into.empty() ? 0 : into.rbegin()->first;
    for (const auto& bytes : ros.take(topic)) {
      const Stamped stamped = FastNode::read_stamped(bytes, numbers);
      EXPECT_EQ(stamped.header.frame_id, "table");
      EXPECT_GT(stamped.header.stamp_ns(), before_ns) << topic;
      before_ns = stamped.header.stamp_ns();
      into[before_ns] = stamped.numbers;
    }
  };
  // Whether the force of the last wrench is the whole force: the governor ramps it up.
  const auto has_full_force = [&] {
    return !wrenches.empty() &&
           (Vec3(wrenches.rbegin()->second[0], wrenches.rbegin()->second[1], wrenches.rbegin()->second[2]) - reply.force_n).norm() < 1e-9;
  };
  const std::int64_t start_s = ::time(nullptr);
  // 500 samples: their mean velocity is within 5 % even if the machine stands still for a while.
  System::wait_until([&] {
    collect("rt/hapton/measured_cp", 7, poses);
    collect("rt/hapton/proxy/measured_cp", 7, proxies);
    collect("rt/hapton/measured_cv", 6, twists);
    collect("rt/hapton/measured_cf", 6, wrenches);
    for (const auto& bytes : ros.take("rt/hapton/joy")) joy = FastNode::read_joy(bytes);
    for (const auto& bytes : ros.take("rt/tf")) transforms = FastNode::read_transforms(bytes);
    return has_full_force() && joy && !transforms.empty() && poses.size() > 500 && proxies.size() > 500 && twists.size() > 500;
  });
  ASSERT_GT(poses.size(), 500U);
  ASSERT_TRUE(has_full_force()) << "the last force is not that of the last reply";
  EXPECT_EQ(wrenches.rbegin()->second[3], 0.0);
  for (const auto& [unused, pose] : poses) expect_on_the_line(pose);
  // Stamps are the time of day; their differences are the time that passed on the line.
  EXPECT_NEAR(static_cast<double>(poses.begin()->first) * 1e-9, static_cast<double>(start_s), 60.0);
  // Only the middle half of the offsets counts: if the machine stands still between a position and its stamp, the stamp is late.
  std::vector<double> offsets_s;
  for (const auto& [stamp, pose] : poses) offsets_s.push_back(1e-9 * static_cast<double>(stamp - poses.begin()->first) - time_of(pose));
  std::sort(offsets_s.begin(), offsets_s.end());
  const std::size_t quarter = offsets_s.size() / 4;
  EXPECT_LT(offsets_s[offsets_s.size() - quarter] - offsets_s[quarter], 1e-3);

  std::size_t pairs = 0;
  for (const auto& [stamp, proxy] : proxies) {
    const auto pose = poses.find(stamp);
    if (pose == poses.end()) continue;
    const Vec3 offset(proxy[0] - pose->second[0], proxy[1] - pose->second[1], proxy[2] - pose->second[2]);
    if (offset.isZero(0.0)) continue;  // before the first reply
    ++pairs;
    EXPECT_LT((offset - reply.visual_offset_m).norm(), 1e-12);
    const double half_rad = 0.5 * (kFirstTurnRad + time_of(pose->second) * kTurnRadPerS + 0.25);
    EXPECT_NEAR(proxy[5], std::sin(half_rad), 1e-5);
    EXPECT_NEAR(proxy[6], std::cos(half_rad), 1e-5);
  }
  EXPECT_GT(pairs, 100U);

  std::vector<double> means(6, 0.0);
  for (const auto& [unused, twist] : twists) {
    for (std::size_t i = 0; i < 6; ++i) means[i] += twist[i] / static_cast<double>(twists.size());
  }
  // The mean is over all samples, also the first ones, in which the velocity filter has not settled: hence 5 %.
  EXPECT_NEAR(means[0], kVelocity.x(), 0.05 * kVelocity.norm());
  EXPECT_NEAR(means[1], kVelocity.y(), 0.05 * kVelocity.norm());
  EXPECT_NEAR(means[2], kVelocity.z(), 0.05 * kVelocity.norm());
  EXPECT_NEAR(means[3], 0.0, 0.05 * kTurnRadPerS);
  EXPECT_NEAR(means[4], 0.0, 0.05 * kTurnRadPerS);
  EXPECT_NEAR(means[5], kTurnRadPerS, 0.05 * kTurnRadPerS);

  ASSERT_TRUE(joy);
  EXPECT_EQ(joy->header.frame_id, "table");
  EXPECT_TRUE(joy->axes.empty());
  ASSERT_EQ(joy->buttons.size(), 32U);
  for (std::size_t i = 0; i < 32; ++i) EXPECT_EQ(joy->buttons[i], static_cast<std::int32_t>(kButtons >> i & 1U)) << i;

  ASSERT_EQ(transforms.size(), 2U);
  EXPECT_EQ(transforms[0].header.frame_id, "table");
  EXPECT_EQ(transforms[0].child_frame_id, "hapton/device");
  EXPECT_EQ(transforms[1].child_frame_id, "hapton/proxy");
  expect_on_the_line(transforms[0].numbers);
  EXPECT_NEAR(transforms[1].numbers[2] - transforms[0].numbers[2], -0.003, 1e-12);
  EXPECT_THAT(bridge.end(), HasSubstr(", 0 failed"));
}

TEST(DdsLive, AReliableSubscriberIsServedOnRequest) {
  System system({"--vision-rate", "2000"});
  write_line(system);
  system.start("io_node");
  ForceCommand reply;
  reply.force_n = Vec3(0.0, 0.0, 0.6);
  const Responder responder(system, reply);
  Bridge bridge(system, {"--reliable"});
  ASSERT_TRUE(bridge.is_publishing()) << bridge.err();
  FastNode ros(domain());
  ros.subscribe("rt/hapton/measured_cf", kWrench, true);  // only a reliable writer matches a reliable reader
  double largest_n = 0.0;
  EXPECT_TRUE(System::wait_until([&] {
    for (const auto& bytes : ros.take("rt/hapton/measured_cf"))
      largest_n = std::max(largest_n, FastNode::read_stamped(bytes, 6).numbers[2]);
    return largest_n > 0.59;
  })) << largest_n
      << " N\n"
      << system["io_node"].err();
  bridge.end();
  system.end_all();
}

TEST(DdsLive, ItWaitsForAHubThatIsStartedAnew) {
  System system;
  system.start("io_node");
  Bridge bridge(system);
  ASSERT_TRUE(bridge.is_publishing()) << bridge.err();
  FastNode ros(domain());
  ros.subscribe("rt/hapton/measured_cp", kPose);
  std::int64_t last_ns = 0;
  const auto receives = [&] {
    bool has_received = false;
    for (const auto& bytes : ros.take("rt/hapton/measured_cp")) {
      const std::int64_t stamp_ns = FastNode::read_stamped(bytes, 7).header.stamp_ns();
      EXPECT_GT(stamp_ns, last_ns);
      last_ns = stamp_ns;
      has_received = true;
    }
    return has_received;
  };
  ASSERT_TRUE(System::wait_until(receives));
  system.end("io_node");
  receives();
  system.start("io_node");
  EXPECT_TRUE(System::wait_until(receives));
  bridge.end();
  system.end_all();
}

}  // namespace
}  // namespace hapton::dds_test

#else

namespace hapton::dds_test {
namespace {

TEST(DdsLive, IsCheckedByFastDds) {
  GTEST_SKIP() << "needs cyclonedds-dev, cyclonedds-tools, libfastrtps-dev and libfastcdr-dev (deploy/setup)";
}

}  // namespace
}  // namespace hapton::dds_test

#endif
