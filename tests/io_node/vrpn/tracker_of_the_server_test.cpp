// The project's own VRPN server as a head tracker: both ends of the protocol together.
#include <gtest/gtest.h>

#include "io_node/vrpn/vrpn_server.h"
#include "runtime/clock.h"
#include "runtime/log.h"
#include "vrpn/tracker_link.h"

namespace hapton::vrpn {
namespace {

TEST(TrackerOfTheServer, SeesTheStylusAndTheProxy) {
  start_log("test");
  Feed feed;
  auto server = Server::open(feed, {.address = "127.0.0.1:0", .name = "Head0", .limits = {}});
  ASSERT_TRUE(server) << server.error().what;
  const std::string address = to_string((*server)->local_address());
  auto stylus = TrackerLink::open({"Head0", address}, 0);
  auto proxy = TrackerLink::open({"Head0", address}, 1);
  ASSERT_TRUE(stylus && proxy);
  FeedSample sample;
  sample.device.p_WD = Vec3(0.1, -0.2, 0.3);
  sample.device.q_WT = Quat(Eigen::AngleAxisd(0.5, Vec3::UnitY()));
  const FeedProxy probe{Vec3(0.4, 0.5, 0.6), Quat::Identity(), true};
  std::optional<TrackerPose> stylus_pose, proxy_pose;
  SteadyClock clock;
  const std::int64_t end_ns = clock.now_ns() + 30 * kNanosecondsPerSecond;
  while (!(stylus_pose && proxy_pose) && clock.now_ns() < end_ns) {
    sample.device.time_ns = clock.now_ns();
    feed.push(sample);
    feed.show_proxy(probe);
    if (const auto newest = (*stylus)->take_newest(clock.now_ns())) stylus_pose = newest;
    if (const auto newest = (*proxy)->take_newest(clock.now_ns())) proxy_pose = newest;
    clock.sleep_until_ns(clock.now_ns() + kNanosecondsPerMillisecond);
  }
  ASSERT_TRUE(stylus_pose && proxy_pose);
  EXPECT_EQ(stylus_pose->p_m, sample.device.p_WD);
  EXPECT_LT((stylus_pose->q.coeffs() - sample.device.q_WT.coeffs()).norm(), 1e-15);
  EXPECT_EQ(proxy_pose->p_m, probe.p_WP);
  EXPECT_EQ((*stylus)->describe_devices(), "Head0");
}

}  // namespace
}  // namespace hapton::vrpn
