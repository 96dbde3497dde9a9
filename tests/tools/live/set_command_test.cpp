// What `hapton set` sends to a hub.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "tests/tools/command_run.h"
#include "tests/tools/replying_hub.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

// A hub with a haptics node that takes every setting. It keeps the first of each kind: a request may come again.
struct SetCommandTest : testing::Test {
  CommandRun set(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"set", "--hub", hub.address(), "--key", hub.key_file()});
    CommandRun run = run_hapton(std::move(arguments));
    hub.end();
    return run;
  }
  bool take(HubPeers& peers, std::size_t peer, const Message& message) {
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
    return true;
  }

  std::optional<Settings> settings;
  std::optional<MaterialRequest> material;
  ReplyingHub hub{[this](HubPeers& peers, std::size_t peer, const Message& message) { return take(peers, peer, message); }};
};

TEST_F(SetCommandTest, EachNumberOfAMaterialIsSentAsItself) {
  const CommandRun run =
      set({"--object", "cube", "--stiffness", "400", "--damping", "0.5", "--friction-static", "0.4", "--friction-dynamic", "0.3"});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("material of 'cube' in use"));
  ASSERT_TRUE(material);
  EXPECT_STREQ(material->object.data(), "cube");
  const MaterialChange& change = material->change;
  EXPECT_EQ(change.fields, MaterialChange::kAll);
  EXPECT_EQ(change.stiffness_n_per_m, 400.0);
  EXPECT_EQ(change.damping_ns_per_m, 0.5);
  EXPECT_EQ(change.friction_static, 0.4);
  EXPECT_EQ(change.friction_dynamic, 0.3);
  EXPECT_FALSE(settings);
}

TEST_F(SetCommandTest, OnlyWhatIsGivenChanges) {
  const CommandRun run = set({"--damping", "0.5", "--friction-dynamic", "0.1"});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("material of all objects in use"));
  ASSERT_TRUE(material);
  EXPECT_EQ(material->object[0], '\0');
  EXPECT_EQ(material->change.fields, MaterialChange::kDamping | MaterialChange::kFrictionDynamic);
  EXPECT_EQ(material->change.damping_ns_per_m, 0.5);
  EXPECT_EQ(material->change.friction_dynamic, 0.1);
}

TEST_F(SetCommandTest, OneFrictionIsBothStaticAndDynamic) {
  EXPECT_EQ(set({"--friction", "0.2"}).code, 0);
  ASSERT_TRUE(material);
  EXPECT_EQ(material->change.fields, MaterialChange::kFrictionStatic | MaterialChange::kFrictionDynamic);
  EXPECT_EQ(material->change.friction_static, 0.2);
  EXPECT_EQ(material->change.friction_dynamic, 0.2);
}

TEST_F(SetCommandTest, RateMethodAndReportAreSentAndResetNoFault) {
  const CommandRun run = set({"--rate", "2000", "--method", "sweep", "--report"});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("Hz; method sweep in use; report requested"));
  ASSERT_TRUE(settings);
  EXPECT_EQ(settings->servo_rate_hz, 2000.0);
  EXPECT_STREQ(settings->method.data(), "sweep");
  EXPECT_TRUE(settings->report_now);
  EXPECT_FALSE(settings->reset_faults);
  EXPECT_FALSE(material);
}

}  // namespace
}  // namespace hapton
