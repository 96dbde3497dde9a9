// The server over loopback, as seen by a VRPN client that connects in either way (vrpn_program.h).
#include "io_node/vrpn/vrpn_server.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "link/udp_endpoint.h"
#include "runtime/clock.h"
#include "runtime/log.h"
#include "tests/io_node/vrpn/vrpn_program.h"
#include "tests/support/scratch_folder.h"
#include "tests/vrpn/hex.h"

namespace hapton::vrpn {
namespace {

using ::testing::HasSubstr;

constexpr const char* kPosition = "vrpn_Tracker Pos_Quat";
constexpr const char* kButton = "vrpn_Button Change";
constexpr const char* kMiscellaneousErrorBody = "00000003";  // of "vrpn_ForceDevice Force_Error"
constexpr const char* kNoErrorBody = "00000004";

struct VrpnServer : testing::Test {
  static void SetUpTestSuite() { start_log("test"); }

  Feed feed;
  std::unique_ptr<Server> server;
  FeedSample sample;
  SteadyClock clock;
  double speed_m_per_s = 0.0;  // along x
  std::int64_t last_fed_ns = clock.now_ns();

  VrpnServer() { sample.device.p_WD = Vec3(1, -2, 0.5); }

  void open(double rate_hz = 500.0) {
    Server::Options options{.address = "127.0.0.1:0", .name = "Phantom0", .limits = {}, .rate_hz = rate_hz};
    options.limits.workspace_min_m = Vec3(-2, -2, -2);
    options.limits.workspace_max_m = Vec3(1, 1, 0.5);
    auto opened = Server::open(feed, options);
    ASSERT_TRUE(opened) << opened.error().what;
    server = std::move(*opened);
  }
  const Address& server_address() const { return server->local_address(); }

  // Sixteen clients that send nothing. Each has a slot: it has received the server's cookie.
  std::vector<int> fill_with_silent_clients() {
    std::vector<int> silent;
    for (int n = 0; n < 16; ++n) {
      silent.push_back(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
      const timeval timeout = {.tv_sec = 30, .tv_usec = 0};
      ::setsockopt(silent.back(), SOL_SOCKET, SO_RCVTIMEO, &timeout, sizeof timeout);
      sockaddr_in to = {};
      to.sin_family = AF_INET;
      to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
      to.sin_port = htons(server_address().port);
      EXPECT_EQ(::connect(silent.back(), reinterpret_cast<const sockaddr*>(&to), sizeof to), 0);
    }
    std::array<std::byte, kCookieBytes> cookie;
    for (const int client : silent) {
      EXPECT_EQ(::recv(client, cookie.data(), cookie.size(), MSG_WAITALL), static_cast<ssize_t>(cookie.size()));
    }
    return silent;
  }

  // Feeds a sample each millisecond until the condition holds, or for half a minute.
  template <class Condition>
  bool feed_until(Program& program, Condition&& holds) {
    const std::int64_t end_ns = clock.now_ns() + 30 * kNanosecondsPerSecond;
    while (!holds()) {
      if (clock.now_ns() > end_ns) return false;
      sample.device.time_ns = clock.now_ns();
      sample.device.p_WD.x() +=
          speed_m_per_s * 1e-9 * static_cast<double>(sample.device.time_ns - std::exchange(last_fed_ns, sample.device.time_ns));
      feed.push(sample);
      program.poll();
      clock.sleep_until_ns(clock.now_ns() + kNanosecondsPerMillisecond);
    }
    return true;
  }
};

TEST_F(VrpnServer, ShowsTheStylusToTcpClients) {
  open();
  sample.wrench.force_n = Vec3(0, 0.5, 1);
  Program program;
  program.connect(server_address());
  ASSERT_TRUE(feed_until(program, [&] { return program.has_received(kPosition) && program.has_received("vrpn_Analog Channel"); }));
  EXPECT_EQ(program.device(), "Phantom0");
  // Sensor 0, padding, the position and the quaternion (x, y, z, w).
  EXPECT_EQ(to_hex(program.last(kPosition)->body), to_hex(hex("00000000 00000000 3ff0000000000000 c000000000000000 3fe0000000000000"
                                                              "0000000000000000 0000000000000000 0000000000000000 3ff0000000000000")));
  EXPECT_EQ(to_hex(program.last("vrpn_ForceDevice Force")->body), to_hex(hex("0000000000000000 3fe0000000000000 3ff0000000000000")));
  EXPECT_TRUE(program.has_received("vrpn_Button States"));
  EXPECT_FALSE(program.last(kPosition)->by_udp);
}

TEST_F(VrpnServer, ConnectsToAUdpRequesterAndSendsPositionsByUdp) {
  open();
  Program program;
  program.request_callbacks(server_address());
  ASSERT_TRUE(feed_until(program, [&] { return program.is_connected(); }));
  program.describe_udp();
  ASSERT_TRUE(feed_until(program, [&] { return program.has_received(kPosition) && program.last(kPosition)->by_udp; }));
  sample.device.buttons = 1;
  ASSERT_TRUE(feed_until(program, [&] { return program.has_received(kButton); }));
  EXPECT_FALSE(program.last(kButton)->by_udp) << "no change of a button may get lost";
}

TEST_F(VrpnServer, ConnectsOnlyToTheRequesterWhateverHostIsWritten) {
  open();
  Program program;
  program.request_callbacks(server_address(), "192.0.2.1");
  EXPECT_TRUE(feed_until(program, [&] { return program.has_received(kPosition); }));
}

TEST_F(VrpnServer, SendsNoDatagramsToThirdParties) {
  open();
  Program program;
  program.connect(server_address());
  program.describe_udp("127.0.0.2");
  ASSERT_TRUE(feed_until(program, [&] { return program.received().size() > 50; }));
  EXPECT_TRUE(std::none_of(program.received().begin(), program.received().end(), [](const auto& received) { return received.by_udp; }));
}

TEST_F(VrpnServer, SendsEveryChangeOfAButtonHoweverShort) {
  open(50.0);
  Program program;
  program.connect(server_address());
  ASSERT_TRUE(feed_until(program, [&] { return program.has_received("vrpn_Button States"); }));
  for (const std::uint32_t buttons : {2U, 0U, 2U, 0U}) {
    sample.device.buttons = buttons;
    sample.device.time_ns = clock.now_ns();
    feed.push(sample);
  }
  std::vector<std::string> changes;
  ASSERT_TRUE(feed_until(program, [&] {
    return std::count_if(program.received().begin(), program.received().end(),
                         [](const auto& received) { return received.name == kButton; }) == 4;
  }));
  for (const auto& received : program.received()) {
    if (received.name == kButton) changes.push_back(to_hex(received.body));
  }
  const std::string down = to_hex(hex("00000001 00000001")), up = to_hex(hex("00000001 00000000"));
  EXPECT_THAT(changes, testing::ElementsAre(down, up, down, up));
}

TEST_F(VrpnServer, RepliesToPingsAndSendsTheWorkspace) {
  open();
  Program program;
  program.connect(server_address());
  program.describe_sender(7, "Phantom0");
  program.describe_type(8, "vrpn_Base ping_message");
  program.describe_type(9, "vrpn_Tracker Request_Tracker_Workspace");
  program.say(7, 8);
  program.say(7, 9);
  ASSERT_TRUE(feed_until(program,
                         [&] { return program.has_received("vrpn_Base pong_message") && program.has_received("vrpn_Tracker Workspace"); }));
  EXPECT_EQ(to_hex(program.last("vrpn_Tracker Workspace")->body),
            to_hex(hex("c000000000000000 c000000000000000 c000000000000000 3ff0000000000000 3ff0000000000000 3fe0000000000000")));
}

TEST_F(VrpnServer, ShowsTheProxyAsSecondSensorAndAsContactPoint) {
  open();
  Program program;
  program.connect(server_address());
  ASSERT_TRUE(feed_until(program, [&] { return program.has_received(kPosition); }));
  EXPECT_EQ(to_hex(program.last(kPosition)->body).substr(0, 11), "00 00 00 00") << "no proxy is known yet";
  const std::string pose =
      to_hex(hex("3ff0000000000000 c000000000000000 3fe8000000000000"
                 "0000000000000000 0000000000000000 0000000000000000 3ff0000000000000"));
  ASSERT_TRUE(feed_until(program, [&] {
    feed.show_proxy({Vec3(1, -2, 0.75), Quat::Identity(), true});
    return program.has_received("vrpn_ForceDevice SCP");
  }));
  EXPECT_EQ(to_hex(program.last("vrpn_ForceDevice SCP")->body), pose);
  EXPECT_EQ(to_hex(program.last(kPosition)->body), to_hex(hex("00000001 00000001")) + pose);
  program.forget();
  ASSERT_TRUE(feed_until(program, [&] {
    feed.show_proxy({Vec3(1, -2, 0.75), Quat::Identity(), false});
    return std::count_if(program.received().begin(), program.received().end(), [](const auto& r) { return r.name == kPosition; }) > 100;
  }));
  EXPECT_EQ(to_hex(program.last("vrpn_ForceDevice SCP")->body), to_hex(Bytes(56))) << "zeros: no contact";
}

TEST_F(VrpnServer, SendsAClientNoMoreReportsThanItAskedFor) {
  open();
  Program slow, fast;
  slow.connect(server_address());
  fast.connect(server_address());
  slow.describe_sender(7, "Phantom0");
  slow.describe_type(8, "vrpn_Tracker set_update_rate");
  slow.say(hex("00000020 00000000 00000000 00000007 00000008 00000000 4024000000000000"));  // 10 a second
  const auto positions = [](const Program& program) {
    return std::count_if(program.received().begin(), program.received().end(), [](const auto& r) { return r.name == kPosition; });
  };
  ASSERT_TRUE(feed_until(slow, [&] {
    fast.poll();
    return positions(slow) > 0 && positions(fast) > 0;
  }));
  slow.forget();
  fast.forget();
  const std::int64_t begin_ns = clock.now_ns();
  // On a busy machine there are fewer samples, and the loop may take longer than a second.
  EXPECT_TRUE(feed_until(slow, [&] {
    fast.poll();
    return clock.now_ns() - begin_ns > kNanosecondsPerSecond && positions(slow) > 0 && positions(fast) > 2 * positions(slow);
  }));
  EXPECT_LE(positions(slow), 2 + 10 * (clock.now_ns() - begin_ns) / kNanosecondsPerSecond);
}

TEST_F(VrpnServer, SendsVelocityAsDistanceOverTime) {
  open(100.0);
  Program program;
  program.connect(server_address());
  speed_m_per_s = 1.0;
  ASSERT_TRUE(feed_until(program, [&] {
    return std::count_if(program.received().begin(), program.received().end(),
                         [](const auto& received) { return received.name == "vrpn_Tracker Velocity"; }) > 20;
  }));
  const Bytes body = program.last("vrpn_Tracker Velocity")->body;
  std::uint64_t bits = 0;
  for (std::size_t n = 8; n < 16; ++n) bits = (bits << 8) | std::to_integer<std::uint64_t>(body[n]);
  EXPECT_NEAR(std::bit_cast<double>(bits), 1.0, 0.5);
}

TEST_F(VrpnServer, ShowsNoPositionsOfADeviceThatIsAwayButSaysSo) {
  open();
  Program program;
  program.connect(server_address());
  ASSERT_TRUE(feed_until(program, [&] { return program.has_received(kPosition); }));
  sample.status = DeviceStatus::away;
  ASSERT_TRUE(feed_until(program, [&] { return program.has_received("vrpn_ForceDevice Force_Error"); }));
  EXPECT_EQ(to_hex(program.last("vrpn_ForceDevice Force_Error")->body), to_hex(hex(kMiscellaneousErrorBody)));
  program.forget();
  sample.status = DeviceStatus::ready;
  ASSERT_TRUE(feed_until(program, [&] { return program.has_received("vrpn_ForceDevice Force_Error"); }));
  EXPECT_EQ(program.received().front().name, "vrpn_ForceDevice Force_Error") << "nothing came while it was away";
  EXPECT_TRUE(feed_until(program, [&] { return program.has_received(kPosition); }));
}

// If the server reported only changes, a client that joins while the device is away would learn nothing about the device.
TEST_F(VrpnServer, ReportsToLaterClientsThatTheDeviceIsAway) {
  open();
  sample.status = DeviceStatus::away;
  Program program;
  program.connect(server_address());
  ASSERT_TRUE(feed_until(program, [&] { return program.has_received("vrpn_ForceDevice Force_Error"); }));
  EXPECT_EQ(to_hex(program.last("vrpn_ForceDevice Force_Error")->body), to_hex(hex(kMiscellaneousErrorBody)));
  EXPECT_FALSE(program.has_received(kPosition));
  program.forget();
  sample.status = DeviceStatus::ready;
  ASSERT_TRUE(feed_until(program, [&] { return program.has_received(kPosition); }));
  EXPECT_EQ(to_hex(program.last("vrpn_ForceDevice Force_Error")->body), to_hex(hex(kNoErrorBody)));
  Program later;
  later.connect(server_address());
  ASSERT_TRUE(feed_until(later, [&] { return later.has_received(kPosition); }));
  EXPECT_FALSE(later.has_received("vrpn_ForceDevice Force_Error")) << "there is no error";
}

TEST_F(VrpnServer, DisconnectsClientsOfAnotherProtocol) {
  open();
  Program foreign;
  foreign.connect(server_address());
  foreign.say(Bytes(100'000, std::byte{0x7f}));
  Program program;
  program.connect(server_address());
  ASSERT_TRUE(feed_until(foreign, [&] {
    program.poll();
    return foreign.is_closed();
  }));
  EXPECT_TRUE(feed_until(program, [&] { return program.has_received(kPosition); }));
}

TEST_F(VrpnServer, HasPlacesForSixteenAndDisconnectsTheOthers) {
  open();
  std::vector<std::unique_ptr<Program>> programs;
  const auto poll_all = [&] {
    for (const auto& program : programs) program->poll();
  };
  for (int n = 0; n < 24; ++n) {
    programs.push_back(std::make_unique<Program>());
    programs.back()->connect(server_address());
    // A client that has sent nothing yet would lose its slot to the next one.
    if (n == 15) {
      ASSERT_TRUE(feed_until(*programs.front(), [&] {
        poll_all();
        return std::all_of(programs.begin(), programs.end(), [](const auto& p) { return p->has_received(kPosition); });
      }));
    }
  }
  const auto count = [&](auto&& holds) {
    return std::count_if(programs.begin(), programs.end(), [&](const auto& p) { return holds(*p); });
  };
  ASSERT_TRUE(feed_until(*programs.front(), [&] {
    poll_all();
    return count([](const Program& p) { return p.is_closed(); }) + count([](const Program& p) { return p.has_received(kPosition); }) == 24;
  }));
  EXPECT_EQ(count([](const Program& p) { return p.has_received(kPosition); }), 16);
}

// If each silent client kept its slot for the whole timeout, sixteen of them would take all slots.
TEST_F(VrpnServer, SilentClientsKeepNoOtherOut) {
  open();
  const std::vector<int> silent = fill_with_silent_clients();
  Program program;
  program.connect(server_address());
  EXPECT_TRUE(feed_until(program, [&] {
    program.poll();
    return program.has_received(kPosition) || program.is_closed();
  }));
  EXPECT_TRUE(program.has_received(kPosition));
  for (const int client : silent) ::close(client);
}

// This client sends its request once. VRPN's own clients repeat theirs, but not for ever.
TEST_F(VrpnServer, SilentClientsDoNotKeepOutAUdpRequester) {
  open();
  const std::vector<int> silent = fill_with_silent_clients();
  Program program;
  program.request_callbacks(server_address());
  EXPECT_TRUE(feed_until(program, [&] { return program.has_received(kPosition); }));
  for (const int client : silent) ::close(client);
}

// Redirects stderr to a file that can be read at any time. Between two captures by gtest a line of another thread would be lost.
class StderrFile {
 public:
  StderrFile() : before_(::dup(STDERR_FILENO)) {
    const int file = ::open(path().c_str(), O_CREAT | O_TRUNC | O_APPEND | O_WRONLY | O_CLOEXEC, 0600);
    ::dup2(file, STDERR_FILENO);
    ::close(file);
  }
  ~StderrFile() {
    ::dup2(before_, STDERR_FILENO);
    ::close(before_);
  }
  StderrFile(const StderrFile&) = delete;
  StderrFile& operator=(const StderrFile&) = delete;

  std::string read() const {
    std::ifstream file(path());
    return {std::istreambuf_iterator<char>(file), {}};
  }

 private:
  std::string path() const { return (folder_.path() / "stderr").string(); }

  ScratchFolder folder_;
  int before_;
};

TEST_F(VrpnServer, DisconnectsClientsThatDoNotReadAndServesTheNext) {
  open(10'000.0);
  Program lazy;
  lazy.connect(server_address(), 4096);
  // Sends the cookie, without which the server sends it nothing. From then on it does not read.
  lazy.poll();
  const StderrFile log;
  Program idle;
  ASSERT_TRUE(feed_until(idle, [&] {
    for (int n = 0; n < 10; ++n) {
      // The server must send every change of a button, so unread bytes pile up.
      sample.device.buttons ^= 0xFFFFFFFF;
      feed.push(sample);
    }
    return log.read().find("left") != std::string::npos;
  }));
  Program program;
  program.connect(server_address());
  EXPECT_TRUE(feed_until(program, [&] { return program.has_received(kPosition); }));
}

TEST_F(VrpnServer, AnAddressThatCannotBeOpenedIsReported) {
  open();
  const Server::Options same{.address = to_string(server_address()), .name = "Phantom0", .limits = {}};
  EXPECT_THAT(Server::open(feed, same).error().what, HasSubstr("another program holds this port"));
  EXPECT_THAT(Server::open(feed, {.address = "127.0.0.1:0", .name = "a b", .limits = {}}).error().what,
              HasSubstr("not a valid VRPN device name"));
  EXPECT_THAT(Server::open(feed, {.address = "192.0.2.1:0", .name = "a", .limits = {}}).error().what, HasSubstr("no such address"));
}

TEST_F(VrpnServer, WarnsWhereOtherMachinesCanConnect) {
  testing::internal::CaptureStderr();
  EXPECT_TRUE(Server::open(feed, {.address = "0.0.0.0:0", .name = "a", .limits = {}}));
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("VRPN has no authentication"));
}

}  // namespace
}  // namespace hapton::vrpn
