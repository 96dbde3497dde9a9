// On simulated time, with a hub: messages overtaken on the network by a newer one of their kind, and a hand that starts inside a body.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <string_view>
#include <thread>

#include "haptics_node/reply_loop.h"
#include "tests/haptics_node/reply_loop_stage.h"
#include "tests/support/made_scene.h"

namespace hapton {
namespace {

class ReplyLoopOvertaken : public ReplyLoopStage {
 protected:
  ReplyLoopOvertaken() {
    loop_.set_patch_sender(&patches_);
    for (int i = 0; i < 10 && client_.state() != JoinState::joined; ++i) exchange();
    exchange();
  }

  ForceCommand exchange() {
    send(DeviceState{.sample = ++sample_, .sample_time_ns = clock_.now_ns(), .p_WD = Vec3(0.01, 0.01, 0.001)});
    loop_.turn(clock_.now_ns() + kMs);
    receive_at_hub();
    return force_;
  }
  void take(const Message& message) override {
    if (const auto* got = std::get_if<ForceCommand>(&message)) force_ = *got;
    if (const auto* got = std::get_if<HapticsSetup>(&message)) method_ = got->method;
  }
  // Delays this message by 3 ms, so that what is sent next arrives first.
  void send_late(const Message& message) {
    network_.set_impairments({.delay_ns = 3 * kMs});
    send(message);
    network_.set_impairments({});
  }

  const TouchScene scene_ = scene_of(made::sheet(0.1, 0.0, 6));
  HapticsStep step_{std::make_unique<TouchStep>(*make_method({}, scene_), scene_), 1e-5};
  MethodBuilder builder_{{}, scene_};
  PatchSender patches_{scene_, 0.0, 42, true};
  ReplyLoop loop_{client_, clock_, step_, builder_, {.scene_hash = 42}};
  ForceCommand force_;
  decltype(HapticsSetup::method) method_ = {};
  std::uint64_t sample_ = 0;
};

TEST_F(ReplyLoopOvertaken, AViewDoesNotTurnTheSceneBack) {
  ASSERT_EQ(client_.state(), JoinState::joined);
  ViewTransform raised{.revision = 1};
  raised.X_WS[11] = 0.003F;
  send_late(raised);
  send(ViewTransform{.revision = 2});
  for (int n = 0; n < 10; ++n) EXPECT_EQ(exchange().force_n, Vec3::Zero()) << "nothing is where the hand is";
  EXPECT_EQ(step_.view().revision, 2U);
  EXPECT_EQ(step_.counts().views_applied, 1U);
}

// Otherwise the haptics node would take a hub that has parts for one that has none, and an object could be lifted off these parts.
TEST_F(ReplyLoopOvertaken, AnOvertakenStatusIsIgnored) {
  ASSERT_EQ(client_.state(), JoinState::joined);
  send_late(PatchStatus{.is_wanted = false, .request = 5});
  send(PatchStatus{.is_wanted = true, .request = 5});
  for (int n = 0; n < 10; ++n) {
    exchange();
    EXPECT_TRUE(patches_.is_requested(hub_.session()));
  }
}

// It would undo the newer request, although a tool may have received the reply to the newer one already.
TEST_F(ReplyLoopOvertaken, ARequestIsNotCarriedOutAfterANewerOne) {
  ASSERT_EQ(client_.state(), JoinState::joined);
  const auto request = [](std::string_view method, std::uint32_t number) {
    Settings settings{.method_request = number};
    std::copy(method.begin(), method.end(), settings.method.begin());
    return settings;
  };
  send_late(request("smooth", 1));
  send(request("sweep", 2));
  const auto exchange_until = [&](std::uint64_t changes, int max_exchanges) {  // the builder's thread needs real time
    for (int n = 0; n < max_exchanges && step_.counts().method_changes < changes; ++n) {
      exchange();
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  };
  exchange_until(1, 6000);
  exchange_until(2, 40);
  EXPECT_EQ(step_.counts().method_changes, 1U);
  EXPECT_TRUE(std::string_view(method_.data()).starts_with("name=sweep")) << method_.data();
}

class ReplyLoopInside : public ReplyLoopStage {
 protected:
  ReplyLoopInside() {
    loop_.set_inside_body_warning(&warning_);
    for (int i = 0; i < 10 && client_.state() != JoinState::joined; ++i) exchange(Vec3::Zero());
  }

  void exchange(const Vec3& hand) {
    send(DeviceState{.sample = ++sample_, .sample_time_ns = clock_.now_ns(), .p_WD = hand});
    loop_.turn(clock_.now_ns() + kMs);
    receive_at_hub();
  }
  void take(const Message& message) override {
    if (const auto* got = std::get_if<SceneFacts>(&message)) is_reported_inside_ = got->is_hand_inside;
  }
  // Keeps the hand at this place until the hub gets that report. The thread that checks this needs real time.
  bool wait_for_report(bool is_inside, const Vec3& hand) {
    for (int n = 0; n < 6000 && is_reported_inside_ != is_inside; ++n) {
      exchange(hand);
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return is_reported_inside_ == is_inside;
  }

  const TouchScene scene_ = scene_of(made::box(Vec3::Constant(-0.02), Vec3::Constant(0.02)), {.two_sided = false});
  HapticsStep step_{std::make_unique<TouchStep>(*make_method({}, scene_), scene_), 1e-5};
  MethodBuilder builder_{{}, scene_};
  InsideBodyWarning warning_{scene_};
  ReplyLoop loop_{client_, clock_, step_, builder_, {.scene_hash = 42}, false, {.given_hash = 9}};
  bool is_reported_inside_ = false;
  std::uint64_t sample_ = 0;
};

TEST_F(ReplyLoopInside, AHandThatStartsInsideABodyIsReportedUntilItIsOutside) {
  ASSERT_EQ(client_.state(), JoinState::joined);
  EXPECT_TRUE(wait_for_report(true, Vec3::Zero()));
  for (double z = 0.0; z < 0.03; z += 0.001) exchange(Vec3(0, 0, z));
  EXPECT_TRUE(wait_for_report(false, Vec3(0, 0, 0.03)));
}

}  // namespace
}  // namespace hapton
