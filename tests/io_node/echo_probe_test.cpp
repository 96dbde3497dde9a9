#include "io_node/echo_probe.h"

#include <gtest/gtest.h>

#include <cstring>
#include <vector>

#include "link/bare_echo_endpoint.h"
#include "tests/io_node/scripted_endpoint.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

const Address kResponder{{1}, 7};

struct Probe : testing::Test {
  SimulatedClock clock{1'000'000'000};
  ScriptedEndpoint endpoint{clock};
  EchoProbe probe{endpoint, clock, kResponder};
  std::size_t request_bytes = 0;
  void reply_after(std::int64_t delay_ns) {
    endpoint.on_send_raw = [this, delay_ns](const Address& to, std::span<const std::byte> sent) {
      request_bytes = sent.size();
      endpoint.arrive_raw(clock.now_ns() + delay_ns, to, reply_to(sent));
    };
  }
  // The reply that BareEchoEndpoint would make.
  static std::vector<std::byte> reply_to(std::span<const std::byte> request) {
    std::vector<std::byte> reply(request.begin(), request.end());
    EXPECT_EQ(std::memcmp(reply.data(), kEchoRequest.data(), kEchoMarkBytes), 0);
    std::memcpy(reply.data(), kEchoReply.data(), kEchoMarkBytes);
    return reply;
  }
};

TEST_F(Probe, MeasuresTheRoundTripOfADatagramAsLongAsADeviceState) {
  reply_after(20 * kUs);
  for (int n = 0; n < 10; ++n) probe.probe(clock.now_ns() + 300 * kUs);
  EXPECT_EQ(probe.counts().replied, 10U);
  EXPECT_EQ(probe.round_trip().max_ns(), 20 * kUs);
  EXPECT_GT(request_bytes, 70U);
  EXPECT_LT(request_bytes, 200U);
}

TEST_F(Probe, ALateReplyIsCountedAndNotTakenForTheNextOne) {
  reply_after(500 * kUs);
  const std::int64_t begin = clock.now_ns();
  probe.probe(begin + 300 * kUs);
  EXPECT_EQ(clock.now_ns(), begin + 300 * kUs);
  reply_after(250 * kUs);
  probe.probe(clock.now_ns() + 300 * kUs);
  EXPECT_EQ(probe.counts().late, 1U);
  EXPECT_EQ(probe.counts().replied, 1U);
  EXPECT_EQ(probe.round_trip().max_ns(), 250 * kUs);
}

TEST_F(Probe, UnknownPeersAreNotTakenForTheResponder) {
  endpoint.on_send_raw = [this](const Address&, std::span<const std::byte> sent) {
    const auto reply = reply_to(sent);
    endpoint.arrive_raw(clock.now_ns() + kUs, Address{{2}, 7}, reply);
    endpoint.arrive_raw(clock.now_ns() + kUs, kResponder, std::span(reply).first(reply.size() - 1));
    endpoint.arrive_raw(clock.now_ns() + kUs, kResponder, sent);
  };
  probe.probe(clock.now_ns() + 300 * kUs);
  EXPECT_EQ(probe.counts().foreign, 3U);
  EXPECT_EQ(probe.counts().replied, 0U);
}

}  // namespace
}  // namespace hapton
