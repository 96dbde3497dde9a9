#include "vrpn/tracker_link.h"

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <span>
#include <string>
#include <thread>

#include "runtime/log.h"
#include "tests/vrpn/made_tracker.h"

namespace hapton::vrpn {
namespace {

struct VrpnTrackerLink : testing::Test {
  static void SetUpTestSuite() { start_log("test"); }

  std::unique_ptr<MadeTracker> server = std::make_unique<MadeTracker>();
  std::unique_ptr<TrackerLink> link;
  std::optional<TrackerPose> pose;

  void open() { link = std::move(*TrackerLink::open({"Head0", to_string(server->address())}, 0)); }
  // The server sends the pose again until the link has received it.
  bool wait_for_pose(double x) {
    const Bytes message_bytes = say_pose(0, {x, 0, 0});
    return server->attend_until([&](std::int64_t now_ns) {
      server->say(message_bytes);
      if (const auto newest = link->take_newest(now_ns)) pose = newest;
      return pose && pose->p_m.x() == x;
    });
  }
};

TEST(VrpnTrackerName, IsADeviceAndAHost) {
  for (const char* text : {"Head0@127.0.0.1:4000", "Head0@tcp://127.0.0.1:4000"}) {
    const auto name = parse_tracker_name(text);
    ASSERT_TRUE(name) << text;
    EXPECT_EQ(name->device, "Head0");
    EXPECT_EQ(name->host, "127.0.0.1:4000");
  }
  for (const std::string& text : {std::string(), std::string("Head0"), std::string("@host"), std::string("Head0@"), std::string("a b@host"),
                                  std::string("a\n@host"), std::string(65, 'a') + "@host", std::string("Head0@tcp://")}) {
    const auto name = parse_tracker_name(text);
    ASSERT_FALSE(name) << text;
    EXPECT_EQ(name.error().what.find("NAME@HOST") == std::string::npos && name.error().what.find("letters") == std::string::npos, false);
  }
}

TEST_F(VrpnTrackerLink, BringsPoses) {
  open();
  EXPECT_FALSE(link->is_connected());
  EXPECT_TRUE(wait_for_pose(1.5));
  EXPECT_TRUE(link->is_connected());
  EXPECT_EQ(link->describe_devices(), "Head0");
}

TEST_F(VrpnTrackerLink, WaitsForAServerThatStartsLaterOrAgain) {
  const std::string at = to_string(server->address());
  open();
  server.reset();
  SteadyClock clock;
  for (int n = 0; n < 5; ++n) EXPECT_FALSE(link->take_newest(clock.now_ns()));
  server = std::make_unique<MadeTracker>(at);
  EXPECT_TRUE(wait_for_pose(2.0));
  server->hang_up();
  EXPECT_TRUE(wait_for_pose(3.0));
  EXPECT_EQ(server->calls(), 2);
}

TEST_F(VrpnTrackerLink, AsksASilentServerForASignOfLifeAndThenConnectsAnew) {
  open();
  ASSERT_TRUE(wait_for_pose(1.0));
  // The bytes that the link sends first: the cookie and two descriptions.
  const std::size_t greeting_bytes = 24 + 40 + 56;
  ASSERT_TRUE(server->attend_until([&](std::int64_t now_ns) {
    link->take_newest(now_ns);
    return server->heard().size() == greeting_bytes;
  }));
  // Simulated later times, at which the server has sent nothing more.
  const std::int64_t ping_time_ns = SteadyClock().now_ns() + 2 * TrackerLink::kPingNs;
  link->take_newest(ping_time_ns);
  ASSERT_TRUE(server->attend_until([&](std::int64_t) { return server->heard().size() > greeting_bytes; }));
  EXPECT_EQ(server->heard().size(), greeting_bytes + kHeaderBytes) << "one ping";
  link->take_newest(ping_time_ns + TrackerLink::kPingNs - 1);
  link->take_newest(ping_time_ns + TrackerLink::kPingNs);
  ASSERT_TRUE(server->attend_until([&](std::int64_t) { return server->heard().size() >= greeting_bytes + 2 * kHeaderBytes; }));
  // A ping that came too early makes this one due. Whatever was sent has arrived when the server sees the end of the connection.
  link->take_newest(ping_time_ns + 2 * TrackerLink::kPingNs - 1);
  const std::int64_t timeout_ns = ping_time_ns + TrackerLink::kReceiveTimeoutNs;
  link->take_newest(timeout_ns);
  ASSERT_TRUE(server->attend_until([&](std::int64_t) { return !server->has_client(); }));
  EXPECT_EQ(server->heard().size(), greeting_bytes + 2 * kHeaderBytes);
  EXPECT_FALSE(link->is_connected());
  EXPECT_TRUE(server->attend_until([&](std::int64_t) {
    link->take_newest(timeout_ns + TrackerLink::kRetryNs);
    return server->calls() == 2;
  }));
}

TEST_F(VrpnTrackerLink, LeavesAServerThatIsNotVrpnAndTriesOnceASecond) {
  const std::string text = "HTTP/1.1 400 Bad Request\r\n";
  const auto message_bytes = std::as_bytes(std::span(text));
  server->set_hello(Bytes(message_bytes.begin(), message_bytes.end()));
  open();
  // All times are simulated. Whether, at that time, the link has connected this many times and disconnected, and does not connect again.
  const auto leaves_at = [&](std::int64_t now_ns, int calls) {
    int turns = 0;
    return server->attend_until([&](std::int64_t) {
      turns = server->calls() == calls && !server->has_client() ? turns + 1 : 0;
      EXPECT_FALSE(link->take_newest(now_ns));
      return turns == 3;
    });
  };
  const std::int64_t start_ns = SteadyClock().now_ns();
  EXPECT_TRUE(leaves_at(start_ns, 1));
  EXPECT_TRUE(leaves_at(start_ns + TrackerLink::kRetryNs - 1, 1));
  EXPECT_TRUE(leaves_at(start_ns + TrackerLink::kRetryNs, 2));
  EXPECT_FALSE(link->is_connected());
}

// However much a server sends, and even if it sends while the link reads, one call of take_newest() takes only a bounded part of it.
TEST_F(VrpnTrackerLink, AFloodIsTakenInBoundedParts) {
  constexpr double kMaxCallBytes = 4 * 65536;
  const int listening = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in at = {};
  at.sin_family = AF_INET;
  at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t at_bytes = sizeof at;
  ASSERT_EQ(::bind(listening, reinterpret_cast<const sockaddr*>(&at), at_bytes), 0);
  ASSERT_EQ(::listen(listening, 1), 0);
  ASSERT_EQ(::getsockname(listening, reinterpret_cast<sockaddr*>(&at), &at_bytes), 0);
  // The x of each pose is the number of bytes sent before it.
  Bytes flood = say_hello("Head0");
  const auto pose_bytes = static_cast<double>(say_pose(0, Vec3::Zero()).size());
  while (flood.size() < 4'000'000) {
    const Bytes one = say_pose(0, {static_cast<double>(flood.size()), 0, 0});
    flood.insert(flood.end(), one.begin(), one.end());
  }
  const double last_x = static_cast<double>(flood.size()) - pose_bytes;
  int connection = -1;
  std::thread sender([&] {
    connection = ::accept4(listening, nullptr, nullptr, SOCK_CLOEXEC);
    std::span<const std::byte> unsent(flood);
    while (!unsent.empty()) {
      const ssize_t sent = ::send(connection, unsent.data(), unsent.size(), MSG_NOSIGNAL);
      if (sent <= 0) break;
      unsent = unsent.subspan(static_cast<std::size_t>(sent));
    }
  });
  link = std::move(*TrackerLink::open({"Head0", "127.0.0.1:" + std::to_string(ntohs(at.sin_port))}, 0));
  SteadyClock clock;
  const std::int64_t end_ns = clock.now_ns() + 20 * kNanosecondsPerSecond;
  double x = 0.0;
  double largest_part = 0.0;
  while (x < last_x && clock.now_ns() < end_ns) {
    if (const auto newest = link->take_newest(clock.now_ns())) {
      largest_part = std::max(largest_part, newest->p_m.x() - x);
      x = newest->p_m.x();
    }
    // Meanwhile the server fills the kernel's buffers.
    clock.sleep_until_ns(clock.now_ns() + kNanosecondsPerMillisecond);
  }
  const bool was_connected = link->is_connected();
  // Ends a sender that still waits, for the link or for room.
  ::shutdown(listening, SHUT_RDWR);
  link.reset();
  sender.join();
  ::close(connection);
  ::close(listening);
  EXPECT_EQ(x, last_x);
  // A part of one pose may have come with the call before.
  EXPECT_LT(largest_part, kMaxCallBytes + pose_bytes);
  EXPECT_TRUE(was_connected);
}

TEST(VrpnTrackerOpen, AHostWithoutAnAddressIsOneLine) {
  const auto link = TrackerLink::open({"Head0", "127.0.0.1:99999"}, 0);
  ASSERT_FALSE(link);
  EXPECT_NE(link.error().what.find("99999"), std::string::npos);
  EXPECT_EQ(link.error().what.find('\n'), std::string::npos);
}

}  // namespace
}  // namespace hapton::vrpn
