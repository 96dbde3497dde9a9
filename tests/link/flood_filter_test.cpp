#include "link/flood_filter.h"

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstring>
#include <vector>

#include "link/codec.h"
#include "link/seal_format.h"
#include "link/udp_endpoint.h"
#include "runtime/clock.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

constexpr std::uint32_t kConnection = 0x11223344;
using Bytes = std::vector<std::byte>;

Bytes datagram_of_kind(seal::Kind kind, std::size_t size = 100) {
  Bytes bytes(size, std::byte{0x5A});
  seal::write_lead(kind, seal::bytes_of(std::span<std::byte>(bytes)));
  if (kind == seal::Kind::data) seal::store(kConnection, seal::bytes_of(std::span<std::byte>(bytes)) + seal::kConnectionAt);
  return bytes;
}

// The hub's socket, to which the filter applies, and peers that send to it.
struct Wire {
  explicit Wire(const char* at = "127.0.0.1:0") : hub(std::move(*open_udp_endpoint(at, true))) {}

  // Sends the datagram this many times. Returns how many of them the hub received.
  int count_passed(Endpoint& from, const Bytes& datagram, int times) {
    std::array<std::byte, 2048> into = {};
    int count = 0;
    for (int n = 0; n < times; ++n) {
      from.send(hub->local_address(), datagram);
      count += hub->receive(into, 0).bytes > 0 ? 1 : 0;
    }
    while (hub->receive(into, clock.now_ns() + 5 * kMs).bytes > 0) ++count;
    return count;
  }
  // Sends unknown datagrams until the hub has the kernel drop unknown peers.
  void flood(Endpoint& from) {
    for (int n = 0; n < 100 && hub->socket_counts().floods == 0; ++n) {
      count_passed(from, Bytes(50, std::byte{1}), 200);
    }
    ASSERT_EQ(hub->socket_counts().floods, 1U);
    // The share that passes settles only while the flood goes on.
    for (int n = 0; n < 20; ++n) count_passed(from, Bytes(50, std::byte{1}), 2000);
  }

  SteadyClock clock;
  std::unique_ptr<Endpoint> hub;
  std::unique_ptr<Endpoint> node = std::move(*open_udp_endpoint("127.0.0.1:0"));
  std::unique_ptr<Endpoint> unknown_peer = std::move(*open_udp_endpoint("127.0.0.1:0"));
};

TEST(FloodFilter, DropsUnknownPeersInTheKernelAndPassesDataOfKnownNodes) {
  Wire wire;
  const Bytes data = datagram_of_kind(seal::Kind::data);
  wire.hub->expect(wire.node->local_address(), kConnection);
  EXPECT_EQ(wire.count_passed(*wire.node, data, 100), 100);
  EXPECT_EQ(wire.count_passed(*wire.unknown_peer, data, 20), 20) << "without a flood nothing is kept out";
  wire.flood(*wire.unknown_peer);
  EXPECT_EQ(wire.hub->socket_counts().last_unknown_sender.port, wire.unknown_peer->local_address().port);
  EXPECT_EQ(wire.count_passed(*wire.node, data, 500), 500);
  EXPECT_LT(wire.count_passed(*wire.unknown_peer, data, 2000), 1000) << "data of an unknown address";
  EXPECT_LT(wire.count_passed(*wire.unknown_peer, Bytes(50, std::byte{1}), 2000), 1000) << "junk";
  EXPECT_LT(wire.count_passed(*wire.node, datagram_of_kind(seal::Kind::request), 2000), 1000) << "a handshake, from a known address too";
  EXPECT_LT(wire.count_passed(*wire.node, datagram_of_kind(seal::Kind::data, seal::kOverheadBytes - 1), 2000), 1000) << "too short";
  Bytes other_session = data;
  other_session[seal::kConnectionAt + 3] ^= std::byte{1};
  EXPECT_LT(wire.count_passed(*wire.node, other_session, 2000), 1000) << "a known address in another session: its sender may be forged";
  EXPECT_EQ(wire.count_passed(*wire.node, data, 500), 500);
  EXPECT_GT(wire.hub->socket_counts().dropped, 2000U);
}

TEST(FloodFilter, KnowsNodesByIpv6AsWell) {
  if (!open_udp_endpoint("[::1]:0")) GTEST_SKIP() << "this machine has no IPv6";
  Wire wire("[::1]:0");
  wire.node = std::move(*open_udp_endpoint("[::1]:0"));
  wire.unknown_peer = std::move(*open_udp_endpoint("[::1]:0"));
  wire.hub->expect(wire.node->local_address(), kConnection);
  wire.flood(*wire.unknown_peer);
  EXPECT_EQ(wire.count_passed(*wire.node, datagram_of_kind(seal::Kind::data), 500), 500);
  EXPECT_LT(wire.count_passed(*wire.unknown_peer, datagram_of_kind(seal::Kind::data), 2000), 1000);
}

TEST(FloodFilter, OversizedAndEmptyDatagramsAreCounted) {
  Wire wire;
  const int socket = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in to = {};
  to.sin_family = AF_INET;
  to.sin_port = htons(wire.hub->local_address().port);
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const Bytes large(1400);
  ASSERT_GT(::sendto(socket, large.data(), large.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to), 0);
  ASSERT_EQ(::sendto(socket, large.data(), 0, 0, reinterpret_cast<const sockaddr*>(&to), sizeof to), 0);
  ::close(socket);
  std::array<std::byte, kMaxDatagramBytes> into = {};
  EXPECT_EQ(wire.hub->receive(into, wire.clock.now_ns() + 20 * kMs).bytes, 0U);
  EXPECT_EQ(wire.hub->socket_counts().oversized, 2U);
}

// The tests from here on use no socket and no clock: they supply the time and the kernel's count of dropped datagrams.
struct FloodFilterTest : testing::Test {
  FloodFilter::Action run_period(std::uint64_t unknown_peers, std::uint32_t dropped_more = 0) {
    for (std::uint64_t n = 0; n < unknown_peers; ++n) filter.note_received(unknown_address, junk, false);
    now_ns += FloodFilter::kPeriodNs;
    dropped += dropped_more;
    return filter.end_period(dropped, now_ns);
  }
  static Address node_at(std::uint16_t port) { return {{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF, 10, 0, 0, 1}, port}; }
  FloodFilter filter;
  Bytes junk = Bytes(9);
  Address unknown_address{{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF, 10, 0, 0, 9}, 9};
  std::int64_t now_ns = 1'000'000'000'000;
  std::uint32_t dropped = 0xFFFFFFF0;  // near its end, so that it wraps around
};

TEST_F(FloodFilterTest, AFewUnknownPeersAreNoFlood) {
  run_period(0);
  for (int n = 0; n < 100; ++n) ASSERT_EQ(run_period(FloodFilter::kFloodDatagrams - 1), FloodFilter::Action::none);
  EXPECT_EQ(filter.counts().floods, 0U);
}

TEST_F(FloodFilterTest, AFloodShutsAndItsEndOpensAfterAWhile) {
  run_period(0);
  EXPECT_EQ(run_period(500), FloodFilter::Action::install);
  EXPECT_TRUE(filter.is_installed());
  EXPECT_GT(filter.program().size(), 5U);
  EXPECT_EQ(run_period(20, 480), FloodFilter::Action::none) << "the same flood needs no other program";
  EXPECT_EQ(run_period(20, 5000), FloodFilter::Action::install) << "a tenfold one does";
  int periods = 0;
  for (FloodFilter::Action action = FloodFilter::Action::none; action != FloodFilter::Action::remove && periods < 10'000; ++periods) {
    action = run_period(0);
  }
  EXPECT_NEAR(static_cast<double>(periods), static_cast<double>(FloodFilter::kQuietNs / FloodFilter::kPeriodNs), 2.0);
  EXPECT_FALSE(filter.is_installed());
  EXPECT_EQ(filter.counts().floods, 1U);
  EXPECT_EQ(run_period(500), FloodFilter::Action::install);
  EXPECT_EQ(filter.counts().floods, 2U);
}

// About 5,000 datagrams a second pass, however large the flood is: of 100,000 one in twenty.
TEST_F(FloodFilterTest, LetsThroughNoMoreThanCanBeLookedAt) {
  run_period(0);
  ASSERT_EQ(run_period(500), FloodFilter::Action::install);
  EXPECT_NEAR(filter.counts().flood_per_s, 100'000.0, 1.0);
  ASSERT_GT(filter.program().size(), 3U);
  const sock_filter chance = filter.program()[filter.program().size() - 3];
  EXPECT_NEAR(static_cast<double>(chance.k) / 0xFFFFFFFF, 0.05, 1e-6);
  EXPECT_EQ(chance.jt, 1) << "a larger random number goes to the end, where it is dropped";
  EXPECT_EQ(filter.program().back().k, 0U);
}

TEST_F(FloodFilterTest, ANodeThatJoinsDuringAFloodGetsANewProgram) {
  run_period(0);
  ASSERT_EQ(run_period(500), FloodFilter::Action::install);
  const std::size_t before = filter.program().size();
  EXPECT_FALSE(filter.is_due(now_ns));
  filter.note_expected(node_at(77), kConnection, now_ns);
  ASSERT_TRUE(filter.is_due(now_ns)) << "at once: it sends as soon as it has the reply";
  ASSERT_EQ(filter.end_period(dropped, now_ns), FloodFilter::Action::install);
  EXPECT_GT(filter.program().size(), before);
  // Only one new peer in each period is admitted at once: endless handshakes would otherwise make a program each time.
  filter.note_expected(node_at(78), kConnection, now_ns);
  EXPECT_FALSE(filter.is_due(now_ns));
  EXPECT_EQ(run_period(500), FloodFilter::Action::install);
}

TEST_F(FloodFilterTest, EndlessHandshakesDisplaceNoPeerThatIsSentData) {
  const Bytes data = datagram_of_kind(seal::Kind::data);
  filter.note_sent(node_at(77), data, now_ns);
  for (std::uint16_t n = 0; n < 1000; ++n) {
    now_ns += kMs;
    filter.note_expected(unknown_address, n, now_ns);
  }
  filter.note_received(node_at(77), data, false);
  EXPECT_EQ(filter.counts().unknown_peers, 0U) << "it was sent data a second ago";
  now_ns += FloodFilter::kKnownNs;
  for (std::uint16_t n = 0; n < 1000; ++n) filter.note_expected(unknown_address, 5000 + n, now_ns + n);
  filter.note_received(node_at(77), data, false);
  EXPECT_EQ(filter.counts().unknown_peers, 1U) << "that is too long ago";
}

TEST_F(FloodFilterTest, FilteredAndOverflownDatagramsAreCountedSeparately) {
  run_period(0);
  EXPECT_EQ(run_period(0, 500), FloodFilter::Action::install);
  EXPECT_EQ(filter.counts().filtered, 0U);
  run_period(20, 480);
  EXPECT_EQ(filter.counts().filtered, 480U);
  EXPECT_EQ(filter.counts().dropped, 980U);
}

TEST_F(FloodFilterTest, TheMostNodesFitIntoAProgramAndAnAttackerCannotCrowdThemOut) {
  for (std::uint16_t n = 1; n <= 100; ++n) {
    filter.note_sent({{0x20, 1, 0xd, 0xb8, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1}, n}, datagram_of_kind(seal::Kind::data), now_ns);
    // Retries to unknown peers do not make them known.
    filter.note_sent(unknown_address, datagram_of_kind(seal::Kind::retry), now_ns);
  }
  run_period(0);
  ASSERT_EQ(run_period(500), FloodFilter::Action::install);
  EXPECT_LT(filter.program().size(), FloodFilter::kMaxInstructions);
  filter.note_received(unknown_address, datagram_of_kind(seal::Kind::data), false);
  EXPECT_GT(filter.counts().unknown_peers, 500U);
}

TEST_F(FloodFilterTest, UsesNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  AllocationGuard guard;
  for (int n = 0; n < 100; ++n) run_period(n % 2 == 0 ? 500 : 0, 5000);
  EXPECT_EQ(guard.count(), 0U);
}

}  // namespace
}  // namespace hapton
