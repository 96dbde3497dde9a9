#include "link/bare_echo_endpoint.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstddef>
#include <cstring>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "link/udp_endpoint.h"
#include "runtime/clock.h"
#include "tests/support/open_files.h"

namespace hapton {
namespace {

void expect_echo(const char* bind_address) {
  auto echo = BareEchoEndpoint::open(bind_address);
  ASSERT_TRUE(echo) << echo.error().what;
  ASSERT_NE(echo->local_address().port, 0);
  auto endpoint = open_udp_endpoint(bind_address);
  ASSERT_TRUE(endpoint) << endpoint.error().what;
  std::atomic<bool> stop = false;
  std::thread server([&] {
    while (!stop) {
      echo->serve_one();
    }
  });
  const SteadyClock clock;
  for (std::size_t bytes = kEchoMarkBytes; bytes <= kMaxDatagramBytes; bytes += 298) {
    std::vector<std::byte> out(bytes);
    for (std::size_t i = 0; i < bytes; ++i) {
      out[i] = static_cast<std::byte>(i * 7 + bytes);
    }
    std::memcpy(out.data(), kEchoRequest.data(), kEchoMarkBytes);
    EXPECT_TRUE((*endpoint)->send(echo->local_address(), out));
    std::memcpy(out.data(), kEchoReply.data(), kEchoMarkBytes);
    std::vector<std::byte> in(kMaxDatagramBytes);
    const Received received = (*endpoint)->receive(in, clock.now_ns() + 5 * kNanosecondsPerSecond);
    in.resize(received.bytes);
    EXPECT_EQ(in, out);
    EXPECT_EQ(received.from, echo->local_address());
  }
  stop = true;
  server.join();
  EXPECT_EQ(echo->served(), 5U) << "one datagram of each size";
}

TEST(BareEchoEndpoint, ReturnsWhatItGets) { expect_echo("127.0.0.1:0"); }

// Also after a move: the object that was moved from has no socket any more.
TEST(BareEchoEndpoint, ItsSocketIsClosedWithIt) {
  EXPECT_FALSE(leaves_files_open([] {
    auto echo = BareEchoEndpoint::open("127.0.0.1:0");
    ASSERT_TRUE(echo);
    const BareEchoEndpoint moved = std::move(*echo);
    EXPECT_NE(moved.local_address().port, 0);
  }));
}

TEST(BareEchoEndpoint, IgnoresWhatIsNoRequest) {
  auto echo = BareEchoEndpoint::open("127.0.0.1:0");
  auto endpoint = open_udp_endpoint("127.0.0.1:0");
  ASSERT_TRUE(echo && endpoint);
  for (const std::string_view text : {"hapecho!", "hapecho", "x", "something else altogether"}) {
    EXPECT_TRUE((*endpoint)->send(echo->local_address(), std::as_bytes(std::span(text))));
    EXPECT_TRUE(echo->serve_one());
  }
  EXPECT_EQ(echo->served(), 0U);
  EXPECT_EQ(echo->ignored(), 4U);
  std::vector<std::byte> in(kMaxDatagramBytes);
  EXPECT_EQ((*endpoint)->receive(in, 0).bytes, 0U);
}

// An attacker sends one datagram to one echo, with the address of the other echo as its sender.
TEST(BareEchoEndpoint, TwoOfThemDoNotLoop) {
  for (const std::string_view text : {"hapecho? and so on", "hapecho! and so on", "and so on"}) {
    auto one = BareEchoEndpoint::open("127.0.0.1:0");
    ASSERT_TRUE(one);
    auto forger = open_udp_endpoint("127.0.0.1:0");
    ASSERT_TRUE(forger);
    EXPECT_TRUE((*forger)->send(one->local_address(), std::as_bytes(std::span(text))));
    const std::string other_address = to_string((*forger)->local_address());
    forger->reset();
    auto other = BareEchoEndpoint::open(other_address);
    ASSERT_TRUE(other) << other.error().what;
    for (int turn = 0; turn < 4; ++turn) {
      one->serve_one();
      other->serve_one();
    }
    EXPECT_LE(one->served(), 1U) << text;
    EXPECT_EQ(other->served(), 0U) << text;
  }
}

TEST(BareEchoEndpoint, SpeaksIpv6) {
  if (!open_udp_endpoint("[::1]:0")) {
    GTEST_SKIP() << "this host has no IPv6 loopback";
  }
  expect_echo("[::1]:0");
}

TEST(BareEchoEndpoint, APortInUseIsAnErrorThatNamesIt) {
  const auto first = BareEchoEndpoint::open("127.0.0.1:0");
  ASSERT_TRUE(first);
  const std::string address = to_string(first->local_address());
  const auto second = BareEchoEndpoint::open(address);
  ASSERT_FALSE(second);
  EXPECT_NE(second.error().what.find(address), std::string::npos);
}

TEST(BareEchoEndpoint, AnAddressOfAnotherHostIsAnErrorThatSaysSo) {
  const auto echo = BareEchoEndpoint::open("192.0.2.1:0");  // reserved for documentation (RFC 5737): no host has it
  ASSERT_FALSE(echo);
  EXPECT_NE(echo.error().what.find("use an address of this host"), std::string::npos) << echo.error().what;
}

}  // namespace
}  // namespace hapton
