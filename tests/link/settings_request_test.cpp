#include "link/settings_request.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "link/hub_peers.h"
#include "link/memory_endpoint.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

TEST(SettingsRequests, HoldWhatIsToChangeAndNothingElse) {
  const auto request = make_settings_request(
      {.rate_hz = 2000.0, .method = "smooth", .object = "lid", .material = {.fields = MaterialChange::kDamping, .damping_ns_per_m = 0.5}});
  ASSERT_TRUE(request) << request.error().what;
  EXPECT_TRUE(request->has_settings);
  EXPECT_EQ(request->settings.servo_rate_hz, 2000.0);
  EXPECT_STREQ(request->settings.method.data(), "smooth");
  EXPECT_NE(request->settings.method_request, 0U);
  EXPECT_FALSE(request->settings.report_now || request->settings.reset_faults);
  ASSERT_TRUE(request->material);
  EXPECT_STREQ(request->material->object.data(), "lid");
  EXPECT_NE(request->material->request, 0U);
  EXPECT_EQ(request->material->change.fields, MaterialChange::kDamping);
  EXPECT_EQ(request->material->change.damping_ns_per_m, 0.5);
}

TEST(SettingsRequests, AMaterialAloneNeedsNoSettings) {
  const auto request = make_settings_request({.material = {.fields = MaterialChange::kStiffness, .stiffness_n_per_m = 300.0}});
  ASSERT_TRUE(request && request->material);
  EXPECT_FALSE(request->has_settings);
  EXPECT_EQ(request->material->object[0], '\0');
  EXPECT_EQ(request->settings.method_request, 0U);
  const auto fault = make_settings_request({.resets_faults = true});
  ASSERT_TRUE(fault);
  EXPECT_TRUE(fault->has_settings && fault->settings.reset_faults && !fault->settings.report_now && !fault->material);
  const auto report = make_settings_request({.writes_report = true});
  ASSERT_TRUE(report);
  EXPECT_TRUE(report->has_settings && report->settings.report_now && !report->settings.reset_faults);
}

TEST(SettingsRequests, ANameThatIsTooLongIsRejectedInOneLine) {
  const MaterialChange stiffer{.fields = MaterialChange::kStiffness, .stiffness_n_per_m = 300.0};
  for (const SettingsChange& change :
       {SettingsChange{.method = std::string(16, 'm')}, SettingsChange{.object = std::string(256, 'o'), .material = stiffer}}) {
    const auto made = make_settings_request(change);
    ASSERT_FALSE(made);
    EXPECT_THAT(made.error().what, HasSubstr(change.object.empty() ? "at most 15 bytes, not 16" : "at most 255 bytes, not 256"));
    EXPECT_EQ(made.error().what.find('\n'), std::string::npos);
  }
}

// While the tool waits in receive(), the hub takes its turn.
class WaitingEndpoint final : public Endpoint {
 public:
  explicit WaitingEndpoint(std::unique_ptr<Endpoint> endpoint) : endpoint_(std::move(endpoint)) {}

  bool send(const Address& to, std::span<const std::byte> datagram) noexcept override { return endpoint_->send(to, datagram); }
  Received receive(std::span<std::byte> into, std::int64_t deadline_ns) noexcept override {
    if (meanwhile) meanwhile();
    return endpoint_->receive(into, deadline_ns);
  }
  Address local_address() const override { return endpoint_->local_address(); }

  std::function<void()> meanwhile;

 private:
  std::unique_ptr<Endpoint> endpoint_;
};

HapticsSetup::Text as_text(std::string_view words) {
  HapticsSetup::Text text = {};
  std::copy(words.begin(), words.end(), text.begin());
  return text;
}

// A tool and its hub. The hub itself sends the setup and the state of the materials, as it would relay them from a haptics node.
class ApplySettingsTest : public testing::Test {
 protected:
  ApplySettingsTest() {
    tool_endpoint_.meanwhile = [this] { turn(); };
    Datagram datagram;
    while (tool_.state() != JoinState::joined) (void)tool_.receive(datagram, clock_.now_ns() + kMs);
  }

  void turn() {
    Datagram datagram;
    for (std::uint64_t before = hub_.counts().received + 1; before != hub_.counts().received;) {
      before = hub_.counts().received;
      if (hub_.receive(datagram, 0).kind != PeerEvent::Kind::message) continue;
      if (const auto* settings = std::get_if<Settings>(&datagram.message)) note(*settings);
      if (const auto* request = std::get_if<MaterialRequest>(&datagram.message)) note(*request);
    }
    if (clock_.now_ns() < next_state_ns_) return;
    next_state_ns_ = clock_.now_ns() + 20 * kMs;
    if (setup_) hub_.send_to_role(NodeRole::tool, *setup_);
    if (materials_) hub_.send_to_role(NodeRole::tool, *materials_);
  }

  void note(const Settings& settings) {
    settings_.push_back(settings);
    if (takes_rate_ && settings.servo_rate_hz != 0.0 && settings_.size() > lost_settings_) hub_.set_servo_rate_hz(settings.servo_rate_hz);
    if (setup_ && settings_.size() > lost_requests_) setup_->method_request = settings.method_request;
  }
  void note(const MaterialRequest& request) {
    requests_.push_back(request);
    if (materials_ && requests_.size() > lost_requests_) materials_->request = request.request;
  }

  Result<std::string> apply(const SettingsChange& change) {
    const auto request = make_settings_request(change);
    EXPECT_TRUE(request);
    began_ns_ = clock_.now_ns();
    return apply_settings(tool_, clock_, *request, "the-hub");
  }
  double waited_s() const { return 1e-9 * static_cast<double>(clock_.now_ns() - began_ns_); }

  SimulatedClock clock_;
  MemoryNetwork network_{clock_};
  std::unique_ptr<Endpoint> hub_endpoint_ = *network_.open(memory_address(1, 4950));
  WaitingEndpoint tool_endpoint_{*network_.open(memory_address(2, 0))};
  HubPeers hub_{*hub_endpoint_, clock_, 1, 1000.0};
  HubClient tool_{tool_endpoint_, clock_, NodeRole::tool, hub_endpoint_->local_address()};
  bool takes_rate_ = true;
  std::optional<HapticsSetup> setup_;
  std::optional<MaterialState> materials_;
  std::size_t lost_requests_ = 0;  // how many of the first requests never reach the haptics node
  std::size_t lost_settings_ = 0;  // how many of the first settings never reach the hub
  std::vector<Settings> settings_;
  std::vector<MaterialRequest> requests_;
  std::int64_t began_ns_ = 0;
  std::int64_t next_state_ns_ = 0;
};

constexpr MaterialChange kSoft{.fields = MaterialChange::kStiffness, .stiffness_n_per_m = 300.0};

TEST_F(ApplySettingsTest, AMaterialIsInUseOnceTheHapticsNodeConfirmsThatRequest) {
  setup_.emplace();
  materials_ = MaterialState{.request = 2};  // the reply to another request: those of tools have odd numbers
  const auto all = apply({.material = kSoft});
  ASSERT_TRUE(all) << all.error().what;
  EXPECT_EQ(*all, "hub the-hub: servo rate 1000 Hz; material of all objects in use");
  EXPECT_EQ(requests_.size(), 1U);
  EXPECT_TRUE(settings_.empty()) << "nothing else changes";
  const auto one = apply({.object = "lid", .material = kSoft});
  ASSERT_TRUE(one) << one.error().what;
  EXPECT_THAT(*one, HasSubstr("material of 'lid' in use"));
  const auto letter = apply({.object = "a", .material = kSoft});
  ASSERT_TRUE(letter) << letter.error().what;
  EXPECT_THAT(*letter, HasSubstr("material of 'a' in use"));
}

TEST_F(ApplySettingsTest, AMaterialThatIsNotConfirmedOrRejectedIsOneLine) {
  const auto alone = apply({.material = kSoft});
  ASSERT_FALSE(alone);
  EXPECT_THAT(alone.error().what, HasSubstr("start haptics_node"));
  EXPECT_NEAR(waited_s(), 3.0, 0.1);
  setup_.emplace();
  const auto without_reply = apply({.material = kSoft});
  ASSERT_FALSE(without_reply);
  EXPECT_THAT(without_reply.error().what, HasSubstr("does not confirm the material"));
  EXPECT_NEAR(waited_s(), 5.0, 0.1);
  materials_ = MaterialState{.request = 2};
  lost_requests_ = 1000;
  const auto with_another = apply({.material = kSoft});
  ASSERT_FALSE(with_another) << *with_another;
  EXPECT_THAT(with_another.error().what, HasSubstr("another change was requested since"));
  lost_requests_ = 0;
  materials_->rejection = as_text("?");
  const auto rejected = apply({.object = "lid", .material = kSoft});
  ASSERT_FALSE(rejected);
  EXPECT_EQ(rejected.error().what, "the haptics node rejected it: ?; no material is changed");
}

TEST_F(ApplySettingsTest, ARequestThatIsLostIsRepeatedTwiceASecond) {
  setup_.emplace();
  materials_.emplace();
  lost_requests_ = 3;
  const auto material = apply({.material = kSoft});
  ASSERT_TRUE(material) << material.error().what;
  EXPECT_EQ(requests_.size(), 4U);
  EXPECT_NEAR(waited_s(), 1.5, 0.1);
  for (const MaterialRequest& request : requests_) EXPECT_EQ(request.request, requests_.front().request);
  const auto method = apply({.rate_hz = 2000.0, .method = "smooth"});
  ASSERT_TRUE(method) << method.error().what;
  EXPECT_EQ(*method, "hub the-hub: servo rate 2000 Hz; method smooth in use");
  ASSERT_EQ(settings_.size(), 4U);
  EXPECT_EQ(settings_.front().servo_rate_hz, 2000.0);
  for (const Settings& settings : settings_) EXPECT_EQ(settings.method_request, settings_.front().method_request);
  EXPECT_STREQ(settings_.back().method.data(), "smooth");
  EXPECT_EQ(settings_.back().servo_rate_hz, 0.0) << "only the method is repeated";
}

TEST_F(ApplySettingsTest, AMethodThatIsNotConfirmedOrRejectedIsOneLine) {
  const auto alone = apply({.method = "smooth"});
  ASSERT_FALSE(alone);
  EXPECT_THAT(alone.error().what, HasSubstr("no method is in use; start haptics_node"));
  setup_ = HapticsSetup{.method_request = 2};
  lost_requests_ = 1000;
  const auto with_another = apply({.method = "smooth"});
  ASSERT_FALSE(with_another);
  EXPECT_THAT(with_another.error().what, HasSubstr("does not confirm method smooth"));
  EXPECT_NEAR(waited_s(), 60.0, 0.1);
  lost_requests_ = 0;
  setup_->rejection = as_text("-");
  const auto rejected = apply({.method = "smooth"});
  ASSERT_FALSE(rejected);
  EXPECT_EQ(rejected.error().what, "the haptics node rejected it: -; the current method stays in use");
}

TEST_F(ApplySettingsTest, ARateThatIsLostIsRepeatedTwiceASecond) {
  lost_settings_ = 2;
  const auto rate = apply({.rate_hz = 2000.0, .writes_report = true, .resets_faults = true});
  ASSERT_TRUE(rate) << rate.error().what;
  EXPECT_EQ(*rate, "hub the-hub: servo rate 2000 Hz");
  ASSERT_EQ(settings_.size(), 3U);
  EXPECT_TRUE(settings_.front().report_now && settings_.front().reset_faults);
  EXPECT_EQ(settings_.back().servo_rate_hz, 2000.0);
  EXPECT_FALSE(settings_.back().report_now || settings_.back().reset_faults) << "only the rate is repeated";
}

TEST_F(ApplySettingsTest, ARateThatTheHubDoesNotTakeIsOneLine) {
  takes_rate_ = false;
  const auto stays = apply({.rate_hz = 2000.0});
  ASSERT_FALSE(stays);
  EXPECT_THAT(stays.error().what, HasSubstr("the hub at the-hub stays at 1000 Hz"));
  EXPECT_NEAR(waited_s(), 2.0, 0.1);
  EXPECT_EQ(settings_.size(), 4U) << "twice a second";
  EXPECT_FALSE(apply({.rate_hz = 1001.5}));
  const auto same = apply({.rate_hz = 1000.5});
  EXPECT_TRUE(same) << "a rate within a thousandth is that rate";
}

TEST(SettingsRequestsWithoutAHub, CannotBeSent) {
  SimulatedClock clock;
  MemoryNetwork network(clock);
  const auto endpoint = *network.open(memory_address(2, 0));
  HubClient tool(*endpoint, clock, NodeRole::tool, memory_address(1, 4950));
  const auto request = make_settings_request({.rate_hz = 2000.0});
  ASSERT_TRUE(request);
  const auto sent = apply_settings(tool, clock, *request, "the-hub");
  ASSERT_FALSE(sent);
  EXPECT_EQ(sent.error().what, "the settings could not be sent to the-hub");
}

}  // namespace
}  // namespace hapton
