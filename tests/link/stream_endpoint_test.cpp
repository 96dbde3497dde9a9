#include "link/stream_endpoint.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "link/udp_endpoint.h"
#include "runtime/clock.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

std::span<const std::byte> bytes_of(const std::string& text) { return std::as_bytes(std::span(text)); }
std::string text_of(std::span<const std::byte> bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

// An endpoint that keeps the events it was notified of.
struct ListeningEndpoint final : StreamEndpoint::Listener {
  std::unique_ptr<StreamEndpoint> endpoint;
  std::map<StreamEndpoint::Id, std::string> arrived;
  std::map<StreamEndpoint::Id, Address> peers;
  int connects = 0;  // calls of on_connected
  std::vector<StreamEndpoint::Id> closed;
  std::vector<std::string> datagrams;
  Address last_from;

  explicit ListeningEndpoint(const std::string& at = "127.0.0.1:0") {
    auto opened = StreamEndpoint::open(at, 3883);
    if (opened) endpoint = std::move(*opened);
  }
  void on_connected(StreamEndpoint::Id id, const Address& peer) override {
    peers[id] = peer;
    ++connects;
  }
  void on_bytes(StreamEndpoint::Id id, std::span<const std::byte> bytes) override { arrived[id] += text_of(bytes); }
  void on_closed(StreamEndpoint::Id id) override {
    closed.push_back(id);
    peers.erase(id);
  }
  void on_datagram(const Address& from, std::span<const std::byte> bytes) override {
    datagrams.push_back(text_of(bytes));
    last_from = from;
  }
  void poll() { endpoint->wait(0, *this); }
};

bool poll_until(const std::vector<ListeningEndpoint*>& endpoints, const std::function<bool()>& holds) {
  SteadyClock clock;
  const std::int64_t end_ns = clock.now_ns() + 30 * kNanosecondsPerSecond;
  while (!holds()) {
    if (clock.now_ns() > end_ns) return false;
    for (ListeningEndpoint* each : endpoints) each->poll();
    clock.sleep_until_ns(clock.now_ns() + kNanosecondsPerMillisecond / 4);
  }
  return true;
}

TEST(StreamEndpoint, TwoConnectExchangeBytesAndClose) {
  ListeningEndpoint server, client;
  const auto id = client.endpoint->connect(server.endpoint->local_address());
  ASSERT_NE(id, 0U);
  // Data sent before the connection is established is sent when it is.
  ASSERT_TRUE(client.endpoint->send(id, bytes_of("hello ")));
  ASSERT_TRUE(poll_until({&server, &client}, [&] { return !client.peers.empty() && !server.peers.empty(); }));
  EXPECT_EQ(client.peers.at(id), server.endpoint->local_address());
  ASSERT_TRUE(client.endpoint->send(id, bytes_of("there")));
  const auto server_id = server.peers.begin()->first;
  ASSERT_TRUE(poll_until({&server, &client}, [&] { return server.arrived[server_id] == "hello there"; }));
  server.endpoint->close(server_id);
  ASSERT_TRUE(poll_until({&server, &client}, [&] { return server.closed.size() == 1 && client.closed.size() == 1; }));
  EXPECT_FALSE(client.endpoint->send(id, bytes_of("gone")));
}

// errno belongs to the last call that failed, whichever code made that call.
TEST(StreamEndpoint, AnErrorOfAnotherCallClosesNoConnection) {
  ListeningEndpoint server, client;
  const auto id = client.endpoint->connect(server.endpoint->local_address());
  ASSERT_TRUE(poll_until({&server, &client}, [&] { return !client.peers.empty() && !server.peers.empty(); }));
  errno = EPIPE;
  ASSERT_TRUE(client.endpoint->send(id, bytes_of("still here")));
  ASSERT_TRUE(poll_until({&server, &client}, [&] { return server.arrived[server.peers.begin()->first] == "still here"; }));
  EXPECT_TRUE(client.closed.empty());
}

TEST(StreamEndpoint, MuchArrivesWhole) {
  ListeningEndpoint server, client;
  const auto id = client.endpoint->connect(server.endpoint->local_address());
  const std::string much(200'000, 'x');
  ASSERT_TRUE(client.endpoint->send(id, bytes_of(much)));
  EXPECT_TRUE(poll_until({&server, &client}, [&] { return !server.arrived.empty() && server.arrived.begin()->second == much; }));
}

TEST(StreamEndpoint, DatagramsComeAtTheSamePort) {
  ListeningEndpoint server, client;
  ASSERT_TRUE(client.endpoint->send_datagram(server.endpoint->local_address(), bytes_of("call me")));
  ASSERT_TRUE(poll_until({&server}, [&] { return !server.datagrams.empty(); }));
  EXPECT_EQ(server.datagrams.front(), "call me");
  EXPECT_EQ(server.last_from, client.endpoint->local_address());
}

TEST(StreamEndpoint, AConnectionWithoutAListenerIsClosed) {
  ListeningEndpoint client;
  Address nobody;
  {
    const ListeningEndpoint gone;
    nobody = gone.endpoint->local_address();
  }
  const auto id = client.endpoint->connect(nobody);
  ASSERT_NE(id, 0U) << "Linux reports only later that nobody listens";
  EXPECT_TRUE(poll_until({&client}, [&] { return client.closed == std::vector<StreamEndpoint::Id>{id}; }));
  EXPECT_EQ(client.connects, 0);
}

TEST(StreamEndpoint, AClientThatDoesNotReadIsDisconnected) {
  ListeningEndpoint server, client;
  client.endpoint->connect(server.endpoint->local_address());
  ASSERT_TRUE(poll_until({&server, &client}, [&] { return !server.peers.empty(); }));
  const auto id = server.peers.begin()->first;
  const std::string much(50'000, 'x');
  std::size_t sent = 0;
  while (server.endpoint->send(id, bytes_of(much))) {
    ASSERT_LT(sent += much.size(), 100'000'000U);
    server.poll();
  }
  server.poll();
  EXPECT_EQ(server.closed.size(), 1U);
}

// Nothing is sent before the connection is established, so the count of waiting bytes is exact.
TEST(StreamEndpoint, AsMuchAsIsAllowedWaitsAndNoByteMore) {
  ListeningEndpoint server, client;
  const auto full = client.endpoint->connect(server.endpoint->local_address());
  const auto above = client.endpoint->connect(server.endpoint->local_address());
  const std::string most(StreamEndpoint::kMaxWaitingBytes, 'x');
  EXPECT_TRUE(client.endpoint->send(full, bytes_of(most)));
  EXPECT_FALSE(client.endpoint->send(above, bytes_of(most + "x")));
  EXPECT_FALSE(client.endpoint->send(full, bytes_of("x")));
  ASSERT_TRUE(poll_until({&client}, [&] { return client.closed.size() == 2; }));
}

TEST(StreamEndpoint, ConnectsNoMoreThanItHasSlots) {
  ListeningEndpoint server, client;
  for (std::size_t n = 0; n < StreamEndpoint::kMaxConnections; ++n) {
    ASSERT_NE(client.endpoint->connect(server.endpoint->local_address()), 0U);
  }
  EXPECT_EQ(client.endpoint->connect(server.endpoint->local_address()), 0U);
}

TEST(StreamEndpoint, ConnectionsBeyondTheLimitAreDropped) {
  ListeningEndpoint server;
  std::vector<std::unique_ptr<ListeningEndpoint>> clients;
  std::vector<ListeningEndpoint*> all = {&server};
  for (std::size_t n = 0; n < StreamEndpoint::kMaxConnections + 3; ++n) {
    clients.push_back(std::make_unique<ListeningEndpoint>());
    clients.back()->endpoint->connect(server.endpoint->local_address());
    all.push_back(clients.back().get());
  }
  ASSERT_TRUE(poll_until(all, [&] {
    std::size_t dropped = 0;
    for (const auto& client : clients) dropped += client->closed.size();
    return dropped == 3;
  }));
  EXPECT_EQ(server.peers.size(), StreamEndpoint::kMaxConnections);
}

TEST(StreamEndpoint, AConnectionThatIsGivenUpTakesNoSlotFromTheNext) {
  const ListeningEndpoint server;
  ListeningEndpoint client;
  const Address& to = server.endpoint->local_address();
  const StreamEndpoint::Id first = client.endpoint->connect(to);
  for (std::size_t n = 1; n < StreamEndpoint::kMaxConnections; ++n) ASSERT_NE(client.endpoint->connect(to), 0U);
  EXPECT_EQ(client.endpoint->connect(to), 0U);
  client.endpoint->close(first);
  EXPECT_NE(client.endpoint->connect(to), 0U) << "before the next wait";
}

// The socket of this process that is connected to this port; -1: no socket is.
int find_socket_to(std::uint16_t port) {
  for (int socket = 0; socket < 1024; ++socket) {
    sockaddr_in peer = {};
    socklen_t size = sizeof peer;
    const bool is_connected = ::getpeername(socket, reinterpret_cast<sockaddr*>(&peer), &size) == 0 && peer.sin_family == AF_INET;
    if (is_connected && ntohs(peer.sin_port) == port) return socket;
  }
  return -1;
}

// A test cannot switch off a host. It checks the options by which the kernel notices that a host no longer replies.
TEST(StreamEndpoint, AHostThatNoLongerRepliesIsNoticed) {
  ListeningEndpoint server, client;
  ASSERT_NE(client.endpoint->connect(server.endpoint->local_address()), 0U);
  ASSERT_TRUE(poll_until({&server, &client}, [&] { return server.peers.size() == 1 && client.peers.size() == 1; }));
  for (const std::uint16_t port : {server.peers.begin()->second.port, server.endpoint->local_address().port}) {
    const int socket = find_socket_to(port);
    ASSERT_GE(socket, 0);
    const auto value_of = [&](int level, int name) {
      int value = -1;
      socklen_t size = sizeof value;
      ::getsockopt(socket, level, name, &value, &size);
      return value;
    };
    EXPECT_EQ(value_of(SOL_SOCKET, SO_KEEPALIVE), 1);
    EXPECT_LT(value_of(IPPROTO_TCP, TCP_KEEPIDLE) + value_of(IPPROTO_TCP, TCP_KEEPINTVL), StreamEndpoint::kMaxSilentS);
    EXPECT_EQ(value_of(IPPROTO_TCP, TCP_USER_TIMEOUT), 1000 * StreamEndpoint::kMaxSilentS);
  }
}

// Evicts its oldest connection to make room for a new one.
struct EvictsTheOldest final : StreamEndpoint::Listener {
  std::vector<StreamEndpoint::Id> open;
  std::size_t connected = 0;

  void on_connected(StreamEndpoint::Id id, const Address&) override {
    open.push_back(id);
    ++connected;
  }
  void on_bytes(StreamEndpoint::Id, std::span<const std::byte>) override {}
  void on_closed(StreamEndpoint::Id id) override { std::erase(open, id); }
  void on_datagram(const Address&, std::span<const std::byte>) override {}
  StreamEndpoint::Id choose_connection_to_evict() override { return open.empty() ? 0 : open.front(); }
};

// Connections that arrived between two waits used to evict the same old one each, so that all of them were let in, beyond the limit.
TEST(StreamEndpoint, ConnectionsThatArriveTogetherEvictDifferentOldOnes) {
  constexpr std::size_t kAtOnce = 8;
  const auto server = StreamEndpoint::open("127.0.0.1:0", 3883);
  ASSERT_TRUE(server);
  sockaddr_in to = {};
  to.sin_family = AF_INET;
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  to.sin_port = htons((*server)->local_address().port);
  std::vector<int> callers;
  const auto call = [&](std::size_t count) {
    for (std::size_t n = 0; n < count; ++n) {
      callers.push_back(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
      ASSERT_EQ(::connect(callers.back(), reinterpret_cast<const sockaddr*>(&to), sizeof to), 0);
    }
  };
  EvictsTheOldest listener;
  SteadyClock clock;
  const std::int64_t end_ns = clock.now_ns() + 30 * kNanosecondsPerSecond;
  call(StreamEndpoint::kMaxConnections);
  while (listener.connected < StreamEndpoint::kMaxConnections && clock.now_ns() < end_ns) (*server)->wait(end_ns, listener);
  ASSERT_EQ(listener.connected, StreamEndpoint::kMaxConnections);
  call(kAtOnce);
  while (listener.connected < StreamEndpoint::kMaxConnections + kAtOnce && clock.now_ns() < end_ns) {
    (*server)->wait(end_ns, listener);
    ASSERT_LE(listener.open.size(), StreamEndpoint::kMaxConnections);
  }
  EXPECT_EQ(listener.connected, StreamEndpoint::kMaxConnections + kAtOnce) << "each is let in";
  for (const int caller : callers) ::close(caller);
}

// If no descriptor is left, a caller cannot be let in. Such a caller used to end every wait at once, for ever.
// Data at another descriptor must not end the waits either: standard output is a socket under some supervisors.
TEST(StreamEndpoint, DoesNotSpinWhenNoDescriptorIsLeft) {
  ListeningEndpoint server;
  std::fflush(stdout);
  const int output = ::dup(STDOUT_FILENO);
  std::array<int, 2> ready = {};
  ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM, 0, ready.data()), 0);
  ASSERT_EQ(::write(ready[1], "x", 1), 1);
  const int caller = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  rlimit before = {};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
  const int next = ::dup(0);  // the lowest free descriptor
  ::close(next);
  const rlimit none = {.rlim_cur = static_cast<rlim_t>(next), .rlim_max = before.rlim_max};
  sockaddr_in to = {};
  to.sin_family = AF_INET;
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  to.sin_port = htons(server.endpoint->local_address().port);
  ASSERT_EQ(::connect(caller, reinterpret_cast<const sockaddr*>(&to), sizeof to), 0);
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &none), 0);
  ::dup2(ready[0], STDOUT_FILENO);
  SteadyClock clock;
  const std::int64_t end_ns = clock.now_ns() + 600 * kNanosecondsPerMillisecond;
  int waits = 0;
  for (; clock.now_ns() < end_ns; ++waits) server.endpoint->wait(end_ns, server);
  ::dup2(output, STDOUT_FILENO);
  ::setrlimit(RLIMIT_NOFILE, &before);
  for (const int each : {output, ready[0], ready[1]}) ::close(each);
  EXPECT_LT(waits, 30);
  EXPECT_GT(waits, 2) << "but it looks again before the end of a long wait";
  // It lets the caller in when a descriptor is free again.
  EXPECT_TRUE(poll_until({&server}, [&] { return server.peers.size() == 1; }));
  ::close(caller);
}

TEST(StreamEndpoint, AWaitEndsWhenItIsWoken) {
  ListeningEndpoint waiting;
  SteadyClock clock;
  std::thread other([&] { waiting.endpoint->wake(); });
  waiting.endpoint->wait(clock.now_ns() + 3600 * kNanosecondsPerSecond, waiting);
  other.join();
}

TEST(StreamEndpoint, AnAddressThatCannotBeOpenedIsReported) {
  const ListeningEndpoint first;
  const auto second = StreamEndpoint::open(to_string(first.endpoint->local_address()), 3883);
  ASSERT_FALSE(second);
  EXPECT_THAT(second.error().what, HasSubstr("another program holds this port"));
  EXPECT_THAT(StreamEndpoint::open("192.0.2.1:0", 1).error().what, HasSubstr("no such address"));
  EXPECT_THAT(StreamEndpoint::open("127.0.0.1:x", 1).error().what, HasSubstr("port 'x'"));
}

// A VRPN server sends its positions to the clients in datagrams.
TEST(StreamEndpoint, AnIpv6EndpointSendsDatagramsToIpv4Clients) {
  ListeningEndpoint server("[::]:0");
  if (!server.endpoint) GTEST_SKIP() << "this machine has no IPv6";
  ListeningEndpoint client;
  Address to = client.endpoint->local_address();
  to.port = server.endpoint->local_address().port;
  ASSERT_TRUE(client.endpoint->send_datagram(to, bytes_of("call me")));
  ASSERT_TRUE(poll_until({&server}, [&] { return !server.datagrams.empty(); }));
  EXPECT_EQ(server.last_from, client.endpoint->local_address());
  ASSERT_TRUE(server.endpoint->send_datagram(server.last_from, bytes_of("a position")));
  ASSERT_TRUE(poll_until({&client}, [&] { return !client.datagrams.empty(); }));
  EXPECT_EQ(client.datagrams.front(), "a position");
}

TEST(StreamEndpoint, AnIpv4EndpointSendsNothingToIpv6) {
  ListeningEndpoint ipv4;
  EXPECT_FALSE(ipv4.endpoint->send_datagram(*parse_address("[::1]:4950"), bytes_of("x")));
}

TEST(StreamEndpoint, SpeaksIpv6AsWell) {
  ListeningEndpoint server("[::1]:0");
  if (!server.endpoint) GTEST_SKIP() << "this machine has no IPv6";
  ListeningEndpoint client("[::1]:0");
  ASSERT_NE(client.endpoint->connect(server.endpoint->local_address()), 0U);
  EXPECT_TRUE(poll_until({&server, &client}, [&] { return !server.peers.empty(); }));
}

}  // namespace
}  // namespace hapton
