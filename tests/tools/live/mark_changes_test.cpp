#include "tools/live/mark_changes.h"

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <variant>

#include "link/hub_peers.h"
#include "link/memory_endpoint.h"

namespace hapton {
namespace {

// A line that is on from its second reading until it is gone.
class PressedLine final : public DigitalLine {
 public:
  Result<bool> is_on() override {
    if (is_gone) return fail("the line is gone");
    return readings_++ > 0;
  }
  std::optional<std::uint64_t> changes() override { return 3; }

  bool is_gone = false;

 private:
  int readings_ = 0;
};

// A hub and a client in simulated time. The hub works only inside should_continue, so its last reply is on its way when the loop ends.
struct MarkChangesTest : testing::Test {
  MarkChangesTest() {
    for (int turn = 0; turn < 10 && client.state() != JoinState::joined; ++turn) {
      Datagram datagram;
      (void)client.receive(datagram, clock.now_ns() + kNanosecondsPerMillisecond);
      (void)hub.receive(datagram, clock.now_ns());
    }
    EXPECT_EQ(client.state(), JoinState::joined);
    network.set_impairments({.delay_ns = 20 * kNanosecondsPerMillisecond});
  }
  // Receives a datagram at the hub and replies if it is a marker. Returns whether it was one.
  bool take_marker() {
    Datagram datagram;
    const PeerEvent event = hub.receive(datagram, clock.now_ns());
    const auto* sent = std::get_if<Marker>(&datagram.message);
    if (event.kind != PeerEvent::Kind::message || sent == nullptr) return false;
    return hub.send_to(event.peer, MarkerReply{.request = sent->request, .sample = 77});
  }
  std::string error_of(const std::function<bool()>& should_continue) {
    const auto missed_changes = mark_changes(line, marker, client, clock, should_continue);
    if (!missed_changes) return missed_changes.error().what;
    EXPECT_EQ(*missed_changes, 2U);
    return {};
  }

  SimulatedClock clock;
  MemoryNetwork network{clock};
  std::unique_ptr<Endpoint> hub_endpoint = *network.open(memory_address(1, 4950));
  std::unique_ptr<Endpoint> client_endpoint = *network.open(memory_address(2, 0));
  HubPeers hub{*hub_endpoint, clock, 1, 1000.0};
  HubClient client{*client_endpoint, clock, NodeRole::tool, hub_endpoint->local_address()};
  PressedLine line;
  LineMarker marker{Edges::on, "up", "down"};
};

TEST_F(MarkChangesTest, AReplyThatIsOnItsWayAtTheEndIsCounted) {
  EXPECT_EQ(error_of([&] { return !take_marker(); }), "");
  EXPECT_EQ(marker.counts().marked, 1U);
  EXPECT_EQ(marker.counts().given_up, 0U);
}

TEST_F(MarkChangesTest, AMarkerWithoutAReplyAtTheEndIsGivenUp) {
  EXPECT_EQ(error_of([&] { return !marker.has_pending(); }), "");
  EXPECT_EQ(marker.counts().marked, 0U);
  EXPECT_EQ(marker.counts().given_up, 1U);
}

TEST_F(MarkChangesTest, AfterTheLineIsGoneRepliesAreStillTaken) {
  const auto should_continue = [&] {
    line.is_gone = line.is_gone || take_marker();
    return true;
  };
  EXPECT_EQ(error_of(should_continue), "the line is gone");
  EXPECT_EQ(marker.counts().marked, 1U);
}

}  // namespace
}  // namespace hapton
