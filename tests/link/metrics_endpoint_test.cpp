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
int connect_and_send(const Address& to, const std::string& text) {
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
  std::string response;
  char buffer[4096];
  for (ssize_t bytes = 0; (bytes = ::recv(client, buffer, sizeof buffer, 0)) > 0;) response.append(buffer, static_cast<std::size_t>(bytes));
  ::close(client);
  return response;
}

// Longer than a request with a reply takes, and shorter than the time after which a silent client is dropped.
constexpr std::int64_t kSlowNs = kNanosecondsPerSecond;

// If the endpoint's thread stalls for as long as it waits for a client, it drops the client. Then the request is repeated.
std::string get(const Address& to, const std::string& text) {
  const SteadyClock clock;
  for (int attempt = 1;; ++attempt) {
    const std::int64_t begin_ns = clock.now_ns();
    std::string response = read_all(connect_and_send(to, text));
    if (!response.empty() || attempt == 10 || clock.now_ns() - begin_ns < kSlowNs) return response;
  }
}

TEST(MetricsEndpointTest, ServesTheNewestText) {
  const auto endpoint = MetricsEndpoint::open("127.0.0.1:0");
  ASSERT_TRUE(endpoint) << endpoint.error().what;
  const Address at = (*endpoint)->local_address();
  ASSERT_NE(at.port, 0);
  for (const char* text : {"a 1\n", "a 2\n"}) {
    (*endpoint)->set_text(text);
    const std::string response = get(at, "GET /metrics HTTP/1.1\r\nHost: localhost\r\n\r\n");
    EXPECT_THAT(response, StartsWith("HTTP/1.1 200 OK\r\n"));
    EXPECT_THAT(response, HasSubstr("text/plain; version=0.0.4"));
    EXPECT_THAT(response, EndsWith(std::string("\r\n\r\n") + text));
  }
  EXPECT_THAT(get(at, "GET /secrets HTTP/1.1\r\nHost: localhost\r\n\r\n"), StartsWith("HTTP/1.1 404"));
  EXPECT_THAT(get(at, "POST /metrics HTTP/1.1\r\nHost: localhost\r\nContent-Length: 0\r\n\r\n"), StartsWith("HTTP/1.1 405"));
}

TEST(MetricsEndpointTest, ARequestGetsATextThatIsNewerThanItself) {
  const auto endpoint = MetricsEndpoint::open("127.0.0.1:0");
  ASSERT_TRUE(endpoint) << endpoint.error().what;
  // The endpoint does not wait longer than kFreshNs for a text: if this test itself stands still for as long, it tries again.
  const SteadyClock clock;
  std::string response;
  std::int64_t elapsed_ns = 0;
  for (int attempt = 0; attempt < 10; ++attempt) {
    (*endpoint)->set_text("old 1\n");
    EXPECT_FALSE((*endpoint)->take_request());
    const std::int64_t begin_ns = clock.now_ns();
    const int client = connect_and_send((*endpoint)->local_address(), "GET /metrics HTTP/1.1\r\nHost: localhost\r\n\r\n");
    EXPECT_TRUE(wait_until([&] { return (*endpoint)->take_request(); }));
    EXPECT_FALSE((*endpoint)->take_request()) << "once";
    (*endpoint)->set_text("fresh 1\n");
    elapsed_ns = clock.now_ns() - begin_ns;
    response = read_all(client);
    if (elapsed_ns < MetricsEndpoint::kFreshNs / 2) break;
  }
  EXPECT_TRUE(response.ends_with("fresh 1\n") || elapsed_ns >= MetricsEndpoint::kFreshNs / 2) << response;
}

TEST(MetricsEndpointTest, HostileClientsNeitherStopNorFillIt) {
  const auto endpoint = MetricsEndpoint::open("127.0.0.1:0");
  ASSERT_TRUE(endpoint) << endpoint.error().what;
  (*endpoint)->set_text("alive 1\n");
  const Address at = (*endpoint)->local_address();
  EXPECT_THAT(get(at, std::string(20'000, 'x') + "\r\n\r\n"), testing::Not(HasSubstr("200 OK")));
  // More than the limit of connections, none of them completing a request.
  std::vector<int> silent_clients;
  for (int n = 0; n < 40; ++n) silent_clients.push_back(connect_and_send(at, "GET /met"));
  for (const int client : silent_clients) ::close(client);
  std::string response;
  for (int n = 0; n < 1000 && response.find("alive 1") == std::string::npos; ++n) {
    response = get(at, "GET /metrics HTTP/1.1\r\nHost: localhost\r\n\r\n");
    if (response.empty()) ::usleep(20'000);
  }
  EXPECT_THAT(response, HasSubstr("alive 1"));
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
    const std::string response = get(at, "GET /metrics HTTP/1.1\r\nHost: " + std::string(name) + "\r\n\r\n");
    EXPECT_THAT(response, StartsWith("HTTP/1.1 403")) << name;
    EXPECT_THAT(response, testing::Not(HasSubstr("alive"))) << name;
  }
  EXPECT_THAT(get(at, "GET /metrics HTTP/1.0\r\n\r\n"), HasSubstr("alive 1")) << "a browser always names a host";
  EXPECT_THAT(get(at, "GET /metrics HTTP/1.1\r\nHost:\r\n\r\n"), HasSubstr("alive 1")) << "nor does a browser leave it empty";
}

TEST(MetricsEndpointTest, AHeadHasTheLengthOfTheTextWithoutIt) {
  const auto endpoint = MetricsEndpoint::open("127.0.0.1:0");
  ASSERT_TRUE(endpoint) << endpoint.error().what;
  (*endpoint)->set_text("alive 1\n");
  const std::string response = get((*endpoint)->local_address(), "HEAD /metrics HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_THAT(response, StartsWith("HTTP/1.1 200 OK\r\n"));
  EXPECT_THAT(response, HasSubstr("Content-Length: 8\r\n"));
  EXPECT_THAT(response, EndsWith("\r\n\r\n"));
}

TEST(MetricsEndpointTest, SilentConnectionsKeepNoOtherOut) {
  const auto endpoint = MetricsEndpoint::open("127.0.0.1:0");
  ASSERT_TRUE(endpoint) << endpoint.error().what;
  (*endpoint)->set_text("alive 1\n");
  const Address at = (*endpoint)->local_address();
  const SteadyClock clock;
  std::string response;
  for (int attempt = 0; attempt < 10 && response.empty(); ++attempt) {
    std::vector<int> silent_clients;
    for (int n = 0; n < 16; ++n) silent_clients.push_back(connect_and_send(at, "GET /met"));
    ::usleep(50'000);
    const std::int64_t begin_ns = clock.now_ns();
    response = read_all(connect_and_send(at, "GET /metrics HTTP/1.1\r\nHost: localhost\r\n\r\n"));
    const bool is_slow = clock.now_ns() - begin_ns >= kSlowNs;
    for (const int client : silent_clients) ::close(client);
    if (!is_slow) break;
  }
  EXPECT_THAT(response, HasSubstr("alive 1")) << "at the first try that the endpoint had time for";
}

TEST(MetricsEndpointTest, StaysOnThisMachine) {
  for (const char* elsewhere : {"0.0.0.0:0", "192.0.2.1:0", "[::]:0"}) {
    const auto endpoint = MetricsEndpoint::open(elsewhere);
    ASSERT_FALSE(endpoint) << elsewhere;
    EXPECT_THAT(endpoint.error().what, HasSubstr("this machine only"));
  }
  const auto first = MetricsEndpoint::open("127.0.0.1:0");
  ASSERT_TRUE(first);
  const auto rejected = MetricsEndpoint::open(to_string((*first)->local_address()));
  ASSERT_FALSE(rejected);
  EXPECT_THAT(rejected.error().what, HasSubstr("cannot serve metrics"));
}

}  // namespace
}  // namespace hapton
