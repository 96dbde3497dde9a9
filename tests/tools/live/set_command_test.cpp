// What `hapton set` sends to a hub.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include "link/hub_peers.h"
#include "link/link_key.h"
#include "link/random_id.h"
#include "link/sealed_hub.h"
#include "link/udp_endpoint.h"
#include "runtime/clock.h"
#include "tests/support/scratch_folder.h"
#include "tests/tools/command_run.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

// A hub with a haptics node that takes every setting. It keeps the first of each kind: a request may come again.
class WillingHub {
 public:
  explicit WillingHub(const LinkKey& key) : key_(key), thread_([this] { run(); }) {}
  ~WillingHub() { end(); }
  std::string address() const { return to_string(endpoint_->local_address()); }
  // What came is complete and can be read from now on.
  void end() {
    ends_ = true;
    if (thread_.joinable()) thread_.join();
  }

  std::optional<Settings> settings;
  std::optional<MaterialRequest> material;

 private:
  void run() {
    SealedHub sealed(*endpoint_, clock_, key_);
    HubPeers peers(sealed, clock_, make_random_id(), 1000.0);
    Datagram datagram;
    while (!ends_) {
      const PeerEvent event = peers.receive(datagram, clock_.now_ns() + kNanosecondsPerMillisecond);
      if (event.kind == PeerEvent::Kind::message) take(peers, event.peer, datagram.message);
    }
  }

  void take(HubPeers& peers, std::size_t peer, const Message& message) {
    if (const auto* request = std::get_if<Settings>(&message)) {
      if (!settings) settings = *request;
      if (request->servo_rate_hz > 0.0) peers.set_servo_rate_hz(request->servo_rate_hz);
      peers.send_to(peer, HapticsSetup{.method_request = request->method_request});
    }
    if (const auto* request = std::get_if<MaterialRequest>(&message)) {
      if (!material) material = *request;
      peers.send_to(peer, HapticsSetup{});
      peers.send_to(peer, MaterialState{.request = request->request});
    }
  }

  LinkKey key_;
  SteadyClock clock_;
  std::unique_ptr<Endpoint> endpoint_ = *open_udp_endpoint("127.0.0.1:0");
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

struct SetCommandTest : testing::Test {
  void SetUp() override {
    ASSERT_TRUE(make_key_file(key_file));
    hub = std::make_unique<WillingHub>(*read_key_file(key_file));
  }
  CommandRun set(std::vector<std::string> words) {
    words.insert(words.begin(), {"set", "--hub", hub->address(), "--key", key_file});
    CommandRun run = run_hapton(std::move(words));
    hub->end();
    return run;
  }

  ScratchFolder folder;
  std::string key_file = (folder.path() / "key").string();
  std::unique_ptr<WillingHub> hub;
};

TEST_F(SetCommandTest, EachNumberOfAMaterialIsSentAsItself) {
  const CommandRun run =
      set({"--object", "cube", "--stiffness", "400", "--damping", "0.5", "--friction-static", "0.4", "--friction-dynamic", "0.3"});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("material of 'cube' in use"));
  ASSERT_TRUE(hub->material);
  EXPECT_STREQ(hub->material->object.data(), "cube");
  const MaterialChange& change = hub->material->change;
  EXPECT_EQ(change.given, MaterialChange::kAll);
  EXPECT_EQ(change.stiffness_n_per_m, 400.0);
  EXPECT_EQ(change.damping_ns_per_m, 0.5);
  EXPECT_EQ(change.friction_static, 0.4);
  EXPECT_EQ(change.friction_dynamic, 0.3);
  EXPECT_FALSE(hub->settings);
}

TEST_F(SetCommandTest, OnlyWhatIsGivenChanges) {
  const CommandRun run = set({"--damping", "0.5", "--friction-dynamic", "0.1"});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("material of all objects in use"));
  ASSERT_TRUE(hub->material);
  EXPECT_EQ(hub->material->object[0], '\0');
  EXPECT_EQ(hub->material->change.given, MaterialChange::kDamping | MaterialChange::kFrictionDynamic);
  EXPECT_EQ(hub->material->change.damping_ns_per_m, 0.5);
  EXPECT_EQ(hub->material->change.friction_dynamic, 0.1);
}

TEST_F(SetCommandTest, OneFrictionIsBothStaticAndDynamic) {
  EXPECT_EQ(set({"--friction", "0.2"}).code, 0);
  ASSERT_TRUE(hub->material);
  EXPECT_EQ(hub->material->change.given, MaterialChange::kFrictionStatic | MaterialChange::kFrictionDynamic);
  EXPECT_EQ(hub->material->change.friction_static, 0.2);
  EXPECT_EQ(hub->material->change.friction_dynamic, 0.2);
}

TEST_F(SetCommandTest, RateMethodAndReportAreSentAndResetNoFault) {
  const CommandRun run = set({"--rate", "2000", "--method", "sweep", "--report"});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("Hz; method sweep in use; report requested"));
  ASSERT_TRUE(hub->settings);
  EXPECT_EQ(hub->settings->servo_rate_hz, 2000.0);
  EXPECT_STREQ(hub->settings->method.data(), "sweep");
  EXPECT_TRUE(hub->settings->report_now);
  EXPECT_FALSE(hub->settings->reset_faults);
  EXPECT_FALSE(hub->material);
}

}  // namespace
}  // namespace hapton
