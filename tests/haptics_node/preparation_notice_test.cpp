#include "haptics_node/preparation_notice.h"

#include <gtest/gtest.h>

#include <atomic>
#include <mutex>
#include <thread>
#include <vector>

#include "core/force/touch_scene.h"
#include "link/hub_peers.h"
#include "link/udp_endpoint.h"
#include "tests/support/made_meshes.h"
#include "tests/support/patience.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

Result<std::unique_ptr<ForceMethod>> make_any() { return make_method({}, {.objects = {{made::shared(made::sheet(0.1, 0.0, 6)), {}}}}); }

TEST(BuildAndNotify, SaysNothingOfWhatIsBuiltInAMoment) {
  bool notified = false;
  const auto method = build_and_notify(
      make_any, [&](DoneSignal&) { notified = true; }, 60'000 * kMs);
  ASSERT_TRUE(method) << method.error().what;
  EXPECT_NE(*method, nullptr);
  EXPECT_FALSE(notified);
}

TEST(BuildAndNotify, PassesAnErrorOn) {
  const auto method = build_and_notify([]() -> Result<std::unique_ptr<ForceMethod>> { return fail("no such method"); }, [](DoneSignal&) {});
  ASSERT_FALSE(method);
  EXPECT_EQ(method.error().what, "no such method");
}

TEST(BuildAndNotify, NotifiesVisionNodesOfTheTimeTakenUntilItIsDone) {
  SteadyClock clock;
  auto hub_endpoint = std::move(*open_udp_endpoint("127.0.0.1:0"));
  HubPeers hub(*hub_endpoint, clock, 7, 1000.0);
  std::mutex mutex;
  std::vector<SceneFacts> received;
  std::atomic<bool> has_left{false};
  std::atomic<bool> ends{false};
  std::thread listener([&] {
    Datagram datagram;
    while (!ends) {
      const auto event = hub.receive(datagram, clock.now_ns() + 10 * kMs);
      if (event.kind == PeerEvent::Kind::left) has_left = true;
      if (event.kind != PeerEvent::Kind::message) continue;
      const std::lock_guard lock(mutex);
      if (const auto* facts = std::get_if<SceneFacts>(&datagram.message)) received.push_back(*facts);
    }
  });
  const auto has_been_notified = [&] {
    const std::lock_guard lock(mutex);
    return received.size() >= 3 && received.back().preparing_s > 0.7F;
  };
  const auto method = build_and_notify(
      [&] {
        EXPECT_TRUE(wait_until(has_been_notified));
        return make_any();
      },
      [&, began_ns = clock.now_ns()](DoneSignal& done) {
        const auto endpoint = std::move(*open_udp_endpoint("127.0.0.1:0"));
        HubClient client(*endpoint, clock, NodeRole::haptics, hub_endpoint->local_address());
        notify_preparation(client, clock, {.given_hash = 5}, began_ns, done);
      });
  EXPECT_TRUE(wait_until([&] { return has_left.load(); })) << "the place is free for the node that gives forces";
  ends = true;
  listener.join();
  ASSERT_TRUE(method);
  ASSERT_GE(received.size(), 3U);
  EXPECT_EQ(received.front().given_hash, 5U);
  EXPECT_GT(received.front().preparing_s, 0.25F);
  for (std::size_t i = 1; i < received.size(); ++i) EXPECT_GT(received[i].preparing_s, received[i - 1].preparing_s);
  EXPECT_GT(received.back().preparing_s, 0.7F);
}

}  // namespace
}  // namespace hapton
