#include "link/metrics_endpoint.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <vector>

#include "link/udp_endpoint.h"
#include "tests/support/patience.h"

namespace hapton {
namespace {

using testing::EndsWith;
using testing::HasSubstr;
using testing::StartsWith;

// Connects a client that sends these bytes. Returns its socket; -1: the system has none left.
int say(const Address& to, const std::string& text) {
  const int client = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(to.port);
  EXPECT_EQ(::connect(client, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  EXPECT_EQ(::send(client, text.data(), text.size(), MSG_NOSIGNAL), static_cast<ssize_t>(text.size()));
  return client;
}

std::string read_all(int client) {
  std::string arrived;
  char buffer[4096];
  for (ssize_t bytes = 0; (bytes = ::recv(client, buffer, sizeof buffer, 0)) > 0;) arrived.append(buffer, static_cast<std::size_t>(bytes));
  ::close(client);
  return arrived;
}

// Longer than a request takes that gets a reply, and shorter than the time after which a silent client is dropped.
constexpr std::int64_t kSlowNs = kNanosecondsPerSecond;

// An endpoint whose thread stands still for as long as it waits for a client drops the client: then the request is repeated.
std::string get(const Address& to, const std::string& text) {
  const SteadyClock clock;
  for (int attempt = 1;; ++attempt) {
    const std::int64_t begin_ns = clock.now_ns();
    std::string arrived = read_all(say(to, text));
    if (!arrived.empty() || attempt == 10 || clock.now_ns() - begin_ns < kSlowNs) return arrived;
  }
}

TEST(MetricsEndpointTest, ServesTheNewestText) {
  const auto endpoint = MetricsEndpoint::open("127.0.0.1:0");
  ASSERT_TRUE(endpoint) << endpoint.error().what;
  const Address at = (*endpoint)->local_address();
  ASSERT_NE(at.port, 0);
  for (const char* text : {"a 1\n", "a 2\n"}) {
    (*endpoint)->set_text(text);
    const std::string arrived = get(at, "GET /metrics HTTP/1.1\r\nHost: localhost\r\n\r\n");
    EXPECT_THAT(arrived, StartsWith("HTTP/1.1 200 OK\r\n"));
    EXPECT_THAT(arrived, HasSubstr("text/plain; version=0.0.4"));
    EXPECT_THAT(arrived, EndsWith(std::string("\r\n\r\n") + text));
  }
  EXPECT_THAT(get(at, "GET /secrets HTTP/1.1\r\nHost: localhost\r\n\r\n"), StartsWith("HTTP/1.1 404"));
  EXPECT_THAT(get(at, "POST /metrics HTTP/1.1\r\nHost: localhost\r\nContent-Length: 0\r\n\r\n"), StartsWith("HTTP/1.1 405"));
}

TEST(MetricsEndpointTest, ARequestGetsATextThatIsNewerThanItself) {
  const auto endpoint = MetricsEndpoint::open("127.0.0.1:0");
  ASSERT_TRUE(endpoint) << endpoint.error().what;
  // The endpoint does not wait longer than kFreshNs for a text: if this test itself stands still for as long, it tries again.
  const SteadyClock clock;
  std::string arrived;
  std::int64_t took_ns = 0;
  for (int attempt = 0; attempt < 10; ++attempt) {
    (*endpoint)->set_text("old 1\n");
    EXPECT_FALSE((*endpoint)->take_request());
    const std::int64_t begin_ns = clock.now_ns();
    const int client = say((*endpoint)->local_address(), "GET /metrics HTTP/1.1\r\nHost: localhost\r\n\r\n");
    EXPECT_TRUE(wait_until([&] { return (*endpoint)->take_request(); }));
    EXPECT_FALSE((*endpoint)->take_request()) << "once";
    (*endpoint)->set_text("fresh 1\n");
    took_ns = clock.now_ns() - begin_ns;
    arrived = read_all(client);
    if (took_ns < MetricsEndpoint::kFreshNs / 2) break;
  }
  EXPECT_TRUE(arrived.ends_with("fresh 1\n") || took_ns >= MetricsEndpoint::kFreshNs / 2) << arrived;
}

TEST(MetricsEndpointTest, HostileClientsNeitherStopNorFillIt) {
  const auto endpoint = MetricsEndpoint::open("127.0.0.1:0");
  ASSERT_TRUE(endpoint) << endpoint.error().what;
  (*endpoint)->set_text("alive 1\n");
  const Address at = (*endpoint)->local_address();
  EXPECT_THAT(get(at, std::string(20'000, 'x') + "\r\n\r\n"), testing::Not(HasSubstr("200 OK")));
  // More than the limit of connections, none of them completing a request.
  std::vector<int> silent;
  for (int n = 0; n < 40; ++n) silent.push_back(say(at, "GET /met"));
  for (const int client : silent) ::close(client);
  std::string arrived;
  for (int n = 0; n < 1000 && arrived.find("alive 1") == std::string::npos; ++n) {
    arrived = get(at, "GET /metrics HTTP/1.1\r\nHost: localhost\r\n\r\n");
    if (arrived.empty()) ::usleep(20'000);
  }
  EXPECT_THAT(arrived, HasSubstr("alive 1"));
}

// A foreign web page whose host name was made to resolve to 127.0.0.1 sends that name (DNS rebinding).
TEST(MetricsEndpointTest, RepliesToTheNamesOfThisMachineAlone) {
  const auto endpoint = MetricsEndpoint::open("127.0.0.1:0");
  ASSERT_TRUE(endpoint) << endpoint.error().what;
  (*endpoint)->set_text("alive 1\n");
  const Address at = (*endpoint)->local_address();
  for (const char* name : {"localhost", "LocalHost:9464", "127.0.0.1", "127.0.0.1:9464", "[::1]:9464", "127.8.8.8"}) {
    EXPECT_THAT(get(at, "GET /metrics HTTP/1.1\r\nHost: " + std::string(name) + "\r\n\r\n"), HasSubstr("alive 1")) << name;
  }
  for (const char* name : {"evil.example", "localhost.evil.example:9464", "192.0.2.1", "[2001:db8::1]", "127.0.0.1.evil.example", "["}) {
    const std::string arrived = get(at, "GET /metrics HTTP/1.1\r\nHost: " + std::string(name) + "\r\n\r\n");
    EXPECT_THAT(arrived, StartsWith("HTTP/1.1 403")) << name;
    EXPECT_THAT(arrived, testing::Not(HasSubstr("alive"))) << name;
  }
  EXPECT_THAT(get(at, "GET /metrics HTTP/1.0\r\n\r\n"), HasSubstr("alive 1")) << "who names no host is not a browser";
  EXPECT_THAT(get(at, "GET /metrics HTTP/1.1\r\nHost:\r\n\r\n"), HasSubstr("alive 1")) << "nor who leaves it empty";
}

TEST(MetricsEndpointTest, AHeadHasTheLengthOfTheTextWithoutIt) {
  const auto endpoint = MetricsEndpoint::open("127.0.0.1:0");
  ASSERT_TRUE(endpoint) << endpoint.error().what;
  (*endpoint)->set_text("alive 1\n");
  const std::string arrived = get((*endpoint)->local_address(), "HEAD /metrics HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_THAT(arrived, StartsWith("HTTP/1.1 200 OK\r\n"));
  EXPECT_THAT(arrived, HasSubstr("Content-Length: 8\r\n"));
  EXPECT_THAT(arrived, EndsWith("\r\n\r\n"));
}

TEST(MetricsEndpointTest, SilentConnectionsKeepNoOtherOut) {
  const auto endpoint = MetricsEndpoint::open("127.0.0.1:0");
  ASSERT_TRUE(endpoint) << endpoint.error().what;
  (*endpoint)->set_text("alive 1\n");
  const Address at = (*endpoint)->local_address();
  const SteadyClock clock;
  std::string arrived;
  for (int attempt = 0; attempt < 10 && arrived.empty(); ++attempt) {
    std::vector<int> silent;
    for (int n = 0; n < 16; ++n) silent.push_back(say(at, "GET /met"));
    ::usleep(50'000);
    const std::int64_t begin_ns = clock.now_ns();
    arrived = read_all(say(at, "GET /metrics HTTP/1.1\r\nHost: localhost\r\n\r\n"));
    const bool is_slow = clock.now_ns() - begin_ns >= kSlowNs;
    for (const int client : silent) ::close(client);
    if (!is_slow) break;
  }
  EXPECT_THAT(arrived, HasSubstr("alive 1")) << "at the first try that the endpoint had time for";
}

TEST(MetricsEndpointTest, StaysOnThisMachine) {
  for (const char* elsewhere : {"0.0.0.0:0", "192.0.2.1:0", "[::]:0"}) {
    const auto endpoint = MetricsEndpoint::open(elsewhere);
    ASSERT_FALSE(endpoint) << elsewhere;
    EXPECT_THAT(endpoint.error().what, HasSubstr("this machine only"));
  }
  const auto taken = MetricsEndpoint::open("127.0.0.1:0");
  ASSERT_TRUE(taken);
  const auto rejected = MetricsEndpoint::open(to_string((*taken)->local_address()));
  ASSERT_FALSE(rejected);
  EXPECT_THAT(rejected.error().what, HasSubstr("cannot serve metrics"));
}

}  // namespace
}  // namespace hapton
