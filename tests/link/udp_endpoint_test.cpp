#include "link/udp_endpoint.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/resource.h>
#include <sys/time.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstring>
#include <vector>

#include "link/metered_endpoint.h"
#include "runtime/clock.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/open_files.h"
#include "tests/support/patience.h"
#include "tests/support/text_bytes.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

using testing::HasSubstr;

class UdpEndpointTest : public testing::Test {
 protected:
  std::unique_ptr<Endpoint> open(std::string_view address) {
    Result<std::unique_ptr<Endpoint>> endpoint = open_udp_endpoint(address);
    EXPECT_TRUE(endpoint) << endpoint.error().what;
    return endpoint ? std::move(*endpoint) : nullptr;
  }

  std::string receive(Endpoint& endpoint, std::int64_t wait_ns = 30'000 * kMs) {
    received_ = endpoint.receive(buffer_, clock_.now_ns() + wait_ns);
    return {reinterpret_cast<const char*>(buffer_.data()), received_.bytes};
  }

  SteadyClock clock_;
  std::array<std::byte, kMaxDatagramBytes> buffer_ = {};
  Received received_;
};

// Boost's io_context throws if it gets no descriptor: with a limit of eight, io_node used to abort.
TEST(UdpEndpointLimits, TooFewDescriptorsAreOneClearLine) {
#if defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "sanitizers need descriptors of their own to look at an exception";
#endif
  rlimit before = {};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
  const int next = ::dup(0);
  ::close(next);
  int rejected = 0;
  for (int more = 0; more < 12; ++more) {
    const rlimit few = {.rlim_cur = static_cast<rlim_t>(next + more), .rlim_max = before.rlim_max};
    ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &few), 0);
    const auto endpoint = open_udp_endpoint("127.0.0.1:0");
    ::setrlimit(RLIMIT_NOFILE, &before);
    if (endpoint) continue;
    ++rejected;
    EXPECT_THAT(endpoint.error().what, HasSubstr("ulimit -n")) << more;
  }
  EXPECT_GT(rejected, 3);
  EXPECT_LT(rejected, 12);
}

TEST_F(UdpEndpointTest, CarriesDatagramsBothWaysAndNamesTheSender) {
  const auto a = open("127.0.0.1:0");
  const auto b = open("127.0.0.1:0");
  ASSERT_NE(a->local_address().port, 0);
  ASSERT_TRUE(a->send(b->local_address(), bytes_of("ping")));
  EXPECT_EQ(receive(*b), "ping");
  EXPECT_EQ(received_.from, a->local_address());
  ASSERT_TRUE(b->send(received_.from, bytes_of("pong")));
  EXPECT_EQ(receive(*a), "pong");
}

TEST_F(UdpEndpointTest, SpeaksIpv6AndIpv4OnOneSocket) {
  Result<std::unique_ptr<Endpoint>> opened = open_udp_endpoint("[::]:0");
  if (!opened) {
    GTEST_SKIP() << "no IPv6 here: " << opened.error().what;
  }
  Endpoint& hub = **opened;
  const std::uint16_t port = hub.local_address().port;
  for (const char* local : {"[::1]:0", "127.0.0.1:0"}) {
    Result<std::unique_ptr<Endpoint>> node = open_udp_endpoint(local);
    if (!node) {
      GTEST_SKIP() << node.error().what;
    }
    Address to = (*node)->local_address();
    to.port = port;
    ASSERT_TRUE((*node)->send(to, bytes_of(local)));
    EXPECT_EQ(receive(hub), local);
    EXPECT_EQ(received_.from, (*node)->local_address());
    ASSERT_TRUE(hub.send(received_.from, bytes_of("back")));
    EXPECT_EQ(receive(**node), "back");
  }
}

TEST_F(UdpEndpointTest, AnIpv4SocketRejectsIpv6Addresses) {
  const auto a = open("127.0.0.1:0");
  EXPECT_FALSE(a->send(*parse_address("[2001:db8::1]:9"), bytes_of("x")));
}

TEST_F(UdpEndpointTest, WaitsUntilTheDeadlineAndNotBeyondReason) {
  const auto a = open("127.0.0.1:0");
  for (const std::int64_t wait_ns : {kMs / 2, 20 * kMs, 75 * kMs}) {
    const std::int64_t start_ns = clock_.now_ns();
    EXPECT_EQ(receive(*a, wait_ns), "");
    EXPECT_GE(clock_.now_ns() - start_ns, wait_ns);
    EXPECT_LT(clock_.now_ns() - start_ns, 30 * kNanosecondsPerSecond);
  }
}

TEST_F(UdpEndpointTest, APreparedWaitEndsWithADatagramOrAtItsDeadline) {
  const auto a = open("127.0.0.1:0");
  const auto b = open("127.0.0.1:0");
  for (int cycle = 0; cycle < 3; ++cycle) {
    const std::int64_t deadline_ns = clock_.now_ns() + 20 * kMs;
    b->prepare_wait(deadline_ns);
    a->send(b->local_address(), bytes_of("early"));
    EXPECT_EQ(b->receive(buffer_, deadline_ns).bytes, 5U);
    EXPECT_EQ(b->receive(buffer_, deadline_ns - 15 * kMs).bytes, 0U);  // another deadline than the prepared one
    EXPECT_LT(clock_.now_ns(), deadline_ns + 30 * kNanosecondsPerSecond);
    EXPECT_EQ(b->receive(buffer_, deadline_ns).bytes, 0U);
    EXPECT_GE(clock_.now_ns(), deadline_ns);
    EXPECT_EQ(b->receive(buffer_, deadline_ns).bytes, 0U);  // the deadline has passed
  }
  b->prepare_wait(1);
  b->prepare_wait(-5);
  EXPECT_EQ(receive(*b, kMs), "");
}

TEST_F(UdpEndpointTest, APastDeadlineOnlyTakesWhatIsThere) {
  const auto a = open("127.0.0.1:0");
  const auto b = open("127.0.0.1:0");
  EXPECT_EQ(receive(*b, -kMs), "");
  a->send(b->local_address(), bytes_of("1"));
  a->send(b->local_address(), bytes_of("2"));
  // The kernel may deliver the datagrams later, in a thread of its own.
  EXPECT_TRUE(wait_until([&] { return receive(*b, -kMs) == "1"; }));
  EXPECT_TRUE(wait_until([&] { return b->receive(buffer_, 0).bytes == 1U; }));
  EXPECT_EQ(b->receive(buffer_, std::numeric_limits<std::int64_t>::min() / 2).bytes, 0U);
}

TEST_F(UdpEndpointTest, IgnoresThatAPeerIsNotThere) {
  const auto a = open("127.0.0.1:0");
  const auto b = open("127.0.0.1:0");
  const Address gone = open("127.0.0.1:0")->local_address();
  for (int i = 0; i < 5; ++i) {
    EXPECT_TRUE(a->send(gone, bytes_of("anyone?")));
    EXPECT_EQ(receive(*a, kMs), "");  // the ICMP error of the closed port arrives at this socket
  }
  a->send(gone, bytes_of("anyone?"));
  EXPECT_TRUE(a->send(b->local_address(), bytes_of("hello")));
  EXPECT_EQ(receive(*b), "hello");
}

TEST_F(UdpEndpointTest, PassesOverDatagramsThatAreTooLongOrEmpty) {
  const auto a = open("127.0.0.1:0");
  const auto b = open("127.0.0.1:0");
  std::array<std::byte, 16> small = {};
  a->send(b->local_address(), bytes_of("far too long for sixteen bytes"));
  a->send(b->local_address(), {});
  a->send(b->local_address(), bytes_of("fits"));
  const Received received = b->receive(small, clock_.now_ns() + 30'000 * kMs);
  EXPECT_EQ(received.bytes, 4U);
  EXPECT_EQ(std::memcmp(small.data(), "fits", 4), 0);
  EXPECT_EQ(b->socket_counts().oversized, 2U);
  EXPECT_EQ(MeteredEndpoint(*b, clock_).socket_counts().oversized, 2U);
  EXPECT_EQ(b->socket_counts().last_oversized, a->local_address());
  EXPECT_EQ(MeteredEndpoint(*b, clock_).socket_counts().last_oversized, a->local_address());
  EXPECT_FALSE(a->send(b->local_address(), std::vector<std::byte>(kMaxDatagramBytes + 1)));
}

TEST_F(UdpEndpointTest, AFloodOfOverlongDatagramsCannotBlockAPoll) {
  const auto a = open("127.0.0.1:0");
  const auto b = open("127.0.0.1:0");
  std::array<std::byte, 4> small = {};
  for (int i = 0; i < 100; ++i) {
    a->send(b->local_address(), bytes_of("too long"));
  }
  a->send(b->local_address(), bytes_of("fits"));
  EXPECT_EQ(b->receive(small, 0).bytes, 0U);
  EXPECT_TRUE(wait_until([&] { return b->receive(small, 0).bytes == 4U; }));
}

TEST_F(UdpEndpointTest, ASignalDoesNotCutAWaitShort) {
  struct sigaction action = {};
  action.sa_handler = [](int) {};
  struct sigaction before = {};
  sigaction(SIGALRM, &action, &before);
  const auto a = open("127.0.0.1:0");
  for (const std::int64_t wait_ns : {20 * kMs, 60 * kMs}) {
    const itimerval every_ms = {.it_interval = {0, 1000}, .it_value = {0, 1000}};
    setitimer(ITIMER_REAL, &every_ms, nullptr);
    const std::int64_t start_ns = clock_.now_ns();
    EXPECT_EQ(receive(*a, wait_ns), "");
    EXPECT_GE(clock_.now_ns() - start_ns, wait_ns);
  }
  const itimerval off = {};
  setitimer(ITIMER_REAL, &off, nullptr);
  sigaction(SIGALRM, &before, nullptr);
}

TEST_F(UdpEndpointTest, SaysInOneLineWhyItCannotListen) {
  const auto holder = open("127.0.0.1:0");
  const std::string taken = to_string(holder->local_address());
  const auto expect_rejected = [](const std::string& address, const char* reason) {
    const Result<std::unique_ptr<Endpoint>> rejected = open_udp_endpoint(address);
    ASSERT_FALSE(rejected) << address;
    EXPECT_THAT(rejected.error().what, HasSubstr(reason));
    EXPECT_EQ(rejected.error().what.find('\n'), std::string::npos);
  };
  expect_rejected(taken, "another program holds this port");
  expect_rejected("192.0.2.1:4950", "this host has no such address");
  expect_rejected("nonsense:port", "port 'port'");
}

TEST_F(UdpEndpointTest, UsesNoHeapForADatagram) {
  if (!AllocationGuard::is_available()) {
    GTEST_SKIP() << "heap use cannot be counted in this build";
  }
  const auto a = open("127.0.0.1:0");
  const auto b = open("127.0.0.1:0");
  const Address to = b->local_address();
  const AllocationGuard guard;
  std::size_t received = 0;
  for (int i = 0; i < 100; ++i) {
    a->send(to, bytes_of("datagram"));
    received += b->receive(buffer_, clock_.now_ns() + 30'000 * kMs).bytes;
    b->receive(buffer_, clock_.now_ns() + 10'000);
  }
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_EQ(received, 800U);
}

// A tool that asks the hub for its state once a second opens an endpoint each time.
TEST_F(UdpEndpointTest, IsClosedAgain) {
  EXPECT_FALSE(leaves_files_open([&] { const auto endpoint = open("127.0.0.1:0"); }));
}

}  // namespace
}  // namespace hapton
