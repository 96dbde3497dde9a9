#include "haptics_node/reply_loop.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <optional>
#include <thread>
#include <vector>

#include "core/math/contact_resumption.h"
#include "link/hub_peers.h"
#include "link/memory_endpoint.h"
#include "plugin/plugin_method.h"
#include "scene/scene_file.h"
#include "tests/standins/paths.h"
#include "tests/support/made_meshes.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

TouchScene one_sheet() { return {.objects = {{made::shared(made::sheet(0.1, 0.0, 6)), {}}}}; }

// A hub and a haptics node in one process on simulated time.
class ReplyLoopTest : public ::testing::Test {
 protected:
  ReplyLoopTest() {
    start_hub(1);
    for (int i = 0; i < 10 && client_.state() != JoinState::joined; ++i) {
      turn(1 * kMs);
      receive_reply();
    }
  }

  void start_hub(std::uint64_t session) {
    hub_.reset();
    hub_.emplace(*hub_endpoint_, clock_, session, 1000.0);
  }

  void turn(std::int64_t wait_ns) { loop_.turn(clock_.now_ns() + wait_ns); }

  // Receives at the hub for 1 ms. Returns the last force command that came, if any came.
  std::optional<ForceCommand> receive_reply() {
    std::optional<ForceCommand> command;
    const std::int64_t end_ns = clock_.now_ns() + kMs;
    Datagram datagram;
    while (clock_.now_ns() < end_ns) {
      if (hub_->receive(datagram, end_ns).kind == PeerEvent::Kind::message) {
        if (const auto* got = std::get_if<ForceCommand>(&datagram.message)) {
          command = *got;
          ++commands_;
        }
        if (const auto* got = std::get_if<HapticsSetup>(&datagram.message)) setups_.push_back(*got);
        if (const auto* got = std::get_if<SceneFacts>(&datagram.message)) scenes_.push_back(*got);
        if (const auto* got = std::get_if<MaterialState>(&datagram.message)) materials_.push_back(*got);
      }
    }
    return command;
  }

  void send(const Message& message) { hub_->send_to_role(NodeRole::haptics, message); }
  void send_state(const Vec3& p_WD) { send(DeviceState{.sample = ++sample_, .sample_time_ns = clock_.now_ns(), .p_WD = p_WD}); }

  std::optional<ForceCommand> exchange(const Vec3& p_WD) {
    send_state(p_WD);
    turn(1 * kMs);
    return receive_reply();
  }

  SimulatedClock clock_;
  MemoryNetwork network_{clock_};
  std::unique_ptr<Endpoint> hub_endpoint_ = *network_.open(memory_address(1, 4950));
  std::unique_ptr<Endpoint> endpoint_ = *network_.open(memory_address(2, 0));
  std::optional<HubPeers> hub_;
  HubClient client_{*endpoint_, clock_, NodeRole::haptics, memory_address(1, 4950)};
  HapticsStep step_{std::make_unique<TouchStep>(*make_method({.name = "sweep"}, one_sheet())), 1e-5};
  MethodBuilder builder_{{.name = "sweep"}, one_sheet()};
  ReplyLoop loop_{client_, clock_, step_, builder_, {.scene_hash = 42}};
  std::vector<HapticsSetup> setups_;
  std::vector<SceneFacts> scenes_;
  std::vector<MaterialState> materials_;
  std::uint64_t sample_ = 0;
  int commands_ = 0;
};

TEST_F(ReplyLoopTest, EveryStateGetsAReply) {
  ASSERT_EQ(client_.state(), JoinState::joined);
  ASSERT_TRUE(exchange({0.01, 0.01, 0.001}));
  const auto pressed = exchange({0.01, 0.01, -0.002});
  ASSERT_TRUE(pressed);
  EXPECT_EQ(pressed->echo_sample, 2U);
  EXPECT_NEAR(pressed->force_n[2], 2.0, 1e-9);
  EXPECT_EQ(commands_, 2);
  EXPECT_EQ(loop_.compute_times().count(), 2U);
  EXPECT_EQ(loop_.step_times().count(), 2U);
  EXPECT_LE(loop_.step_times().max_ns(), loop_.compute_times().max_ns());
}

TEST_F(ReplyLoopTest, AToolIsFeltAndRejectsRequestsForAProbe) {
  HeldTool tool(std::move(*ToolStep::make(made::box(Vec3::Constant(-0.01), Vec3::Constant(0.01)), {one_sheet().objects[0].mesh}, {})));
  step_.hold(&tool);
  std::optional<ForceCommand> command;
  for (int n = 0; n < 30; ++n) {
    command = exchange({0.01, 0.01, 0.0109 - 0.0001 * n});
    tool.follow();
  }
  ASSERT_TRUE(command);
  EXPECT_NEAR(command->force_n.z(), 1000.0 * (0.01 - (0.0109 - 0.0029)), 0.2);
  EXPECT_TRUE(command->contact);
  Settings settings{.method_request = 9};
  settings.method = {'p', 'r', 'o', 'x', 'y'};
  for (int n = 0; n < 300 && setups_.back().method_request != 9; ++n) {
    send(settings);
    exchange({0.01, 0.01, 0.008});
  }
  EXPECT_EQ(setups_.back().method_request, 9U);
  EXPECT_NE(std::string_view(setups_.back().rejection.data()).find("rigid tool"), std::string_view::npos);
  EXPECT_EQ(step_.counts().method_changes, 0U);
}

TEST_F(ReplyLoopTest, ABacklogGetsOneReplyToItsNewest) {
  send_state({0.01, 0.01, 0.003});
  send_state({0.01, 0.01, 0.002});
  send_state({0.01, 0.01, 0.001});
  turn(1 * kMs);
  const auto command = receive_reply();
  ASSERT_TRUE(command);
  EXPECT_EQ(command->echo_sample, 3U);
  EXPECT_EQ(command->skipped_samples, 2U);
  EXPECT_EQ(commands_, 1);
}

TEST_F(ReplyLoopTest, ViewTransformsTurnTheScene) {
  exchange({0.01, 0.01, 0.001});
  ViewTransform raised{.revision = 1};
  raised.X_WS[11] = 0.003F;
  send(raised);
  const auto command = exchange({0.01, 0.01, 0.001});
  ASSERT_TRUE(command);
  EXPECT_NEAR(command->force_n[2], 2.0, 1e-6);
}

TEST_F(ReplyLoopTest, AMethodChangesWhileInContact) {
  exchange({0.01, 0.01, 0.001});
  ASSERT_TRUE(exchange({0.01, 0.01, -0.002})->contact);
  Settings settings;
  const std::string_view name = "sweep";
  std::copy(name.begin(), name.end(), settings.method.begin());
  send(settings);
  for (int i = 0; i < 6000 && step_.counts().method_changes == 0; ++i) {
    const auto command = exchange({0.01, 0.01, -0.002});
    ASSERT_TRUE(command);
    ASSERT_NEAR(command->force_n[2], 2.0, 1e-9);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));  // the builder's thread needs real time
  }
  EXPECT_EQ(step_.counts().method_changes, 1U);
  EXPECT_NEAR(exchange({0.01, 0.01, -0.002})->force_n[2], 2.0, 1e-9);
}

TEST_F(ReplyLoopTest, ARequesterOfAMethodIsNotifiedOfTheResult) {
  exchange({0.01, 0.01, 0.001});
  const auto request_method = [&](std::string_view name, std::uint32_t number) {
    Settings settings{.method_request = number};
    std::copy(name.begin(), name.end(), settings.method.begin());
    for (int i = 0; i < 6000 && setups_.back().method_request != number; ++i) {
      send(settings);  // repeated, because datagrams may be lost
      exchange({0.01, 0.01, 0.001});
      std::this_thread::sleep_for(std::chrono::milliseconds(5));  // the builder's thread needs real time
    }
    return setups_.back();
  };
  const HapticsSetup rejected = request_method("magic", 7);
  EXPECT_EQ(rejected.method_request, 7U);
  EXPECT_NE(std::string_view(rejected.rejection.data()).find("'magic' is not known"), std::string_view::npos) << rejected.rejection.data();
  EXPECT_EQ(step_.counts().method_changes, 0U);

  const HapticsSetup accepted = request_method("proxy", 8);
  EXPECT_EQ(accepted.method_request, 8U);
  EXPECT_STREQ(accepted.rejection.data(), "");
  EXPECT_EQ(accepted.method_serial, 1U);
  EXPECT_EQ(std::string_view(accepted.method.data()).substr(0, 10), "name=proxy");
  for (int i = 0; i < 20; ++i) {
    exchange({0.01, 0.01, 0.001});
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_EQ(step_.counts().method_changes, 1U) << "requested again and again, built once";
}

TEST_F(ReplyLoopTest, TheHubGetsTheSetupAtOnceSoonAgainOnceASecondAndWhenTheMethodChanges) {
  ASSERT_EQ(setups_.size(), 1U);
  EXPECT_EQ(setups_[0].scene_hash, 42U);
  const std::int64_t begin_ns = clock_.now_ns();
  while (clock_.now_ns() < begin_ns + 350 * kMs) exchange({0.01, 0.01, 0.001});
  EXPECT_EQ(setups_.size(), 4U) << "and three times more, 100 ms apart";
  while (clock_.now_ns() < begin_ns + 2350 * kMs) exchange({0.01, 0.01, 0.001});
  EXPECT_EQ(setups_.size(), 6U) << "then once a second";
  Settings settings;
  const std::string_view name = "sweep";
  std::copy(name.begin(), name.end(), settings.method.begin());
  send(settings);
  for (int i = 0; i < 6000 && step_.counts().method_changes == 0; ++i) {
    exchange({0.01, 0.01, 0.001});
    std::this_thread::sleep_for(std::chrono::milliseconds(5));  // the builder's thread needs real time
  }
  exchange({0.01, 0.01, 0.001});
  EXPECT_EQ(setups_.back().method_serial, 1U);
  EXPECT_STREQ(setups_.back().method.data(), "name=sweep");
}

TEST_F(ReplyLoopTest, TheFirstReplyWaitsUntilWhatIsNearIsBuilt) {
  const MethodSettings proxy{.name = "proxy", .build_on_approach = true};
  HapticsStep step(std::make_unique<TouchStep>(*make_method(proxy, one_sheet())), 1e-5);
  MethodBuilder builder(proxy, one_sheet(), step.touch().share_method());
  ReplyLoop loop(client_, clock_, step, builder, {}, true);
  std::optional<ForceCommand> first;
  for (int i = 0; i < 6000 && !first; ++i) {
    send_state({0.01, 0.01, 0.001});
    loop.turn(clock_.now_ns() + kMs);
    first = receive_reply();
    std::this_thread::sleep_for(std::chrono::milliseconds(5));  // the builder's thread needs real time
  }
  ASSERT_TRUE(first);
  EXPECT_NE(step.touch().method().describe().find("1 of 1 objects built"), std::string::npos) << step.touch().method().describe();
  EXPECT_EQ(step.counts().replied, 1U);
  // From now on every sample gets a reply, also where the probe starts anew.
  send_state({0.01, 0.01, -0.002});
  loop.turn(clock_.now_ns() + kMs);
  EXPECT_TRUE(receive_reply()->contact);
  send_state({0.01, 0.01, 0.05});
  loop.turn(clock_.now_ns() + kMs);
  ASSERT_TRUE(receive_reply());
  send_state({0.01, 0.01, -0.05});  // farther than a hand moves in one cycle
  loop.turn(clock_.now_ns() + kMs);
  const auto anew = receive_reply();
  ASSERT_TRUE(anew) << "at once";
  EXPECT_FALSE(anew->contact);
}

// A method whose slow task, prepare(), lasts until the test ends it.
class SlowMethod : public ForceMethod {
 public:
  SlowMethod(std::unique_ptr<ForceMethod> method, std::atomic<bool>& done) : method_(std::move(method)), done_(done) {}
  MethodOutput step(const MethodInput& input) noexcept override { return method_->step(input); }
  void reset(const Vec3& p_SD) noexcept override { method_->reset(p_SD); }
  void set_materials(std::span<const Material>) noexcept override {}
  std::string describe() const override { return method_->describe(); }
  bool prepare() override {
    while (!done_) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return false;
  }

 private:
  std::unique_ptr<ForceMethod> method_;
  std::atomic<bool>& done_;
};

TEST_F(ReplyLoopTest, WhileTheFirstReplyIsPendingVisionIsNotifiedForHowLong) {
  std::atomic<bool> done{false};
  HapticsStep step(std::make_unique<TouchStep>(std::make_unique<SlowMethod>(*make_method({}, one_sheet()), done)), 1e-5);
  MethodBuilder builder({}, one_sheet(), step.touch().share_method());
  struct Release {
    ~Release() { done = true; }
    std::atomic<bool>& done;
  } const release{done};  // ends prepare() before the builder waits for its thread
  const SceneFacts scene{.given_hash = 9};
  ReplyLoop loop(client_, clock_, step, builder, {}, true, scene);
  const auto run_turns = [&](int turns) {
    for (int i = 0; i < turns; ++i) {
      send_state({0.01, 0.01, 0.001});
      loop.turn(clock_.now_ns() + kMs);
      receive_reply();
    }
  };
  run_turns(2000);  // a millisecond each
  ASSERT_FALSE(scenes_.empty());
  EXPECT_GT(scenes_.back().preparing_s, 1.7F);
  EXPECT_GE(scenes_.size(), 10U) << "several times a second";
  EXPECT_EQ(step.counts().replied, 0U);
  done = true;
  for (int i = 0; i < 6000 && step.counts().replied == 0; ++i) {
    run_turns(1);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  run_turns(5);
  ASSERT_GT(step.counts().replied, 0U);
  EXPECT_EQ(scenes_.back().preparing_s, 0.0F) << "and at once when it is done";
}

TEST_F(ReplyLoopTest, ANewHubSessionResumesWhereTheHandStillIsAndRestartsElsewhere) {
  std::uint64_t session = 1;
  for (const double depth : {0.002, 1.1 * kResumeReachM}) {
    exchange({0.01, 0.01, 0.001});
    ASSERT_TRUE(exchange({0.01, 0.01, -0.002})->contact);
    start_hub(++session);
    for (int i = 0; i < 2000 && client_.session() != session; ++i) {
      turn(1 * kMs);
      receive_reply();
    }
    ASSERT_EQ(client_.session(), session);
    const auto command = exchange({0.01, 0.01, -depth});
    ASSERT_TRUE(command);
    EXPECT_EQ(command->contact, depth < kResumeReachM) << depth;
  }
}

TEST_F(ReplyLoopTest, AnOvertakenStateGetsNoReplyAfterANewerOne) {
  network_.set_impairments({.seed = 7, .reorder = 0.5, .reorder_by_ns = 3 * kMs});
  const std::int64_t begin_ns = clock_.now_ns();
  std::uint64_t newest = 0;
  for (int i = 0; i < 300; ++i) {
    send_state({0.01, 0.01, 0.001});
    const std::uint64_t replied_before = step_.counts().replied;
    turn(1 * kMs);
    if (step_.counts().replied > replied_before) {
      const auto command = receive_reply();
      if (command) {
        newest = std::max(newest, command->echo_sample);
      }
    }
  }
  EXPECT_GT(client_.sequence_counts().reordered, 20U);
  // A Welcome may be overtaken as well, and counts as reordered; the hub sends one for each Hello.
  const auto welcomes = static_cast<std::uint64_t>((clock_.now_ns() - begin_ns) / HubClient::kHelloPeriodNs + 1);
  EXPECT_LE(step_.counts().replied + step_.counts().skipped + client_.sequence_counts().reordered, 300U + welcomes);
  EXPECT_GT(newest, 250U);
}

// The same node with a task that computes changes of materials.
class TunedLoopTest : public ReplyLoopTest {
 protected:
  static Scene named_sheet() {
    Scene scene;
    scene.objects.push_back({.name = "hull", .mesh = one_sheet().objects[0].mesh, .material = {}});
    return scene;
  }
  static MaterialRequest request(std::uint32_t number, std::string_view object, double stiffness_n_per_m) {
    MaterialRequest made{.request = number, .change = {.fields = MaterialChange::kStiffness, .stiffness_n_per_m = stiffness_n_per_m}};
    std::copy(object.begin(), object.end(), made.object.begin());
    return made;
  }
  TunedLoopTest() { loop_.set_material_task(&material_task_); }

  // Presses 2 mm deep until the reply to the request comes. The request is repeated, because datagrams may be lost.
  MaterialState send_until_reply(const MaterialRequest& repeated) {
    for (int i = 0; i < 6000 && (materials_.empty() || materials_.back().request != repeated.request); ++i) {
      send(repeated);
      const auto command = exchange({0.01, 0.01, -0.002});
      if (command) forces_n_.push_back(command->force_n[2]);
      std::this_thread::sleep_for(std::chrono::milliseconds(5));  // the thread of material_task_ needs real time
    }
    return materials_.empty() ? MaterialState() : materials_.back();
  }

  MaterialTask material_task_{named_sheet(), 0.0};
  std::vector<double> forces_n_;
};

TEST_F(TunedLoopTest, AMaterialChangesInContactAndFades) {
  exchange({0.01, 0.01, 0.001});
  ASSERT_NEAR(exchange({0.01, 0.01, -0.002})->force_n[2], 2.0, 1e-9);
  const MaterialState state = send_until_reply(request(7, "hull", 1500.0));
  EXPECT_EQ(state.request, 7U);
  EXPECT_STREQ(state.rejection.data(), "");
  EXPECT_EQ(state.serial, 1U);
  ASSERT_EQ(state.object_count, 1U);
  EXPECT_EQ(state.objects[0].object, 0);
  EXPECT_EQ(state.objects[0].change.stiffness_n_per_m, 1500.0);
  for (int i = 0; i < 120; ++i) forces_n_.push_back(exchange({0.01, 0.01, -0.002})->force_n[2]);
  EXPECT_NEAR(forces_n_.back(), 3.0, 1e-9);
  // From one exchange to the next the clock advances by 2 ms at most.
  for (std::size_t i = 1; i < forces_n_.size(); ++i) EXPECT_LE(std::abs(forces_n_[i] - forces_n_[i - 1]), 0.03) << i;
  for (int i = 0; i < 20; ++i) {
    send(request(7, "hull", 1500.0));
    exchange({0.01, 0.01, -0.002});
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_EQ(step_.counts().materials_taken, 1U) << "requested again and again, changed once";
}

TEST_F(TunedLoopTest, WhatIsRejectedSaysWhyAndChangesNothing) {
  exchange({0.01, 0.01, 0.001});
  const MaterialState unknown = send_until_reply(request(8, "hul", 1500.0));
  EXPECT_STREQ(unknown.rejection.data(), "the scene has no object 'hul'; did you mean 'hull'?");
  const MaterialState too_stiff = send_until_reply(request(9, "", 2e6));
  EXPECT_NE(std::string_view(too_stiff.rejection.data()).find("at most 1000000"), std::string_view::npos) << too_stiff.rejection.data();
  EXPECT_EQ(step_.counts().materials_taken, 0U);
  EXPECT_EQ(too_stiff.serial, 0U);
  EXPECT_NEAR(exchange({0.01, 0.01, -0.002})->force_n[2], 2.0, 1e-9);
}

TEST_F(TunedLoopTest, AnotherMethodTakesOverWithTheMaterialsInUse) {
  exchange({0.01, 0.01, 0.001});
  ASSERT_EQ(send_until_reply(request(7, "", 1500.0)).serial, 1U);
  Settings settings{.method_request = 3};
  const std::string_view name = "proxy";
  std::copy(name.begin(), name.end(), settings.method.begin());
  send(settings);
  for (int i = 0; i < 6000 && step_.counts().method_changes == 0; ++i) {
    exchange({0.01, 0.01, -0.002});
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  for (int i = 0; i < 120; ++i) exchange({0.01, 0.01, -0.002});
  EXPECT_NEAR(exchange({0.01, 0.01, -0.002})->force_n[2], 3.0, 1e-4);
  EXPECT_EQ(setups_.back().material_serial, 1U) << "a replay needs to know that the method came after that change";
  EXPECT_EQ(setups_.front().material_serial, 0U);
}

// The hub has requested the parts of the scene, to compute forces itself: materials may be changed nevertheless.
TEST_F(TunedLoopTest, WhileTheHubComputesForcesItselfMaterialsChange) {
  PatchSender patches(one_sheet(), 0.0, 42, true);
  loop_.set_patch_sender(&patches);
  exchange({0.01, 0.01, 0.001});
  send(PatchStatus{.is_wanted = true});
  exchange({0.01, 0.01, 0.001});
  const MaterialState state = send_until_reply(request(7, "hull", 1500.0));
  EXPECT_STREQ(state.rejection.data(), "");
  EXPECT_EQ(state.serial, 1U);
  EXPECT_EQ(step_.counts().materials_taken, 1U);
  loop_.set_patch_sender(nullptr);
}

// While the stylus presses, the scene file is saved with another sheet, 1 mm lower, and another material.
TEST_F(TunedLoopTest, AnotherSceneFadesInAndIsAnnounced) {
  exchange({0.01, 0.01, 0.001});
  exchange({0.01, 0.01, -0.002});
  ASSERT_EQ(send_until_reply(request(7, "hull", 1500.0)).serial, 1U);
  for (int i = 0; i < 120; ++i) forces_n_.push_back(exchange({0.01, 0.01, -0.002})->force_n[2]);
  auto new_scene = std::make_shared<NewScene>();
  new_scene->touch = {.objects = {{made::shared(made::sheet(0.1, -0.001, 6)), {.stiffness_n_per_m = 800.0}}}};
  new_scene->materials = {new_scene->touch.objects[0].material};
  new_scene->hash = 77;
  new_scene->facts.given_hash = 78;
  new_scene->revision = 1;
  ASSERT_TRUE(builder_.rebuild_for(new_scene));
  for (int i = 0; i < 200; ++i) forces_n_.push_back(exchange({0.01, 0.01, -0.002})->force_n[2]);
  EXPECT_NEAR(forces_n_.back(), 0.8, 1e-4) << "1 mm deep, and the changed stiffness was that of the former scene";
  for (std::size_t i = 1; i < forces_n_.size(); ++i) EXPECT_LE(std::abs(forces_n_[i] - forces_n_[i - 1]), 0.07) << i;
  EXPECT_EQ(setups_.back().scene_hash, 77U);
  EXPECT_EQ(setups_.back().method_serial, 1U);
  EXPECT_EQ(scenes_.back().given_hash, 78U) << "vision nodes compare it with theirs";
  EXPECT_EQ(materials_.back().serial, 2U);
  EXPECT_EQ(materials_.back().object_count, 0U);
  // The material task still has the former scene, whose materials must not come into use.
  const MaterialState late = send_until_reply(request(9, "hull", 300.0));
  EXPECT_NE(std::string_view(late.rejection.data()).find("read again"), std::string_view::npos) << late.rejection.data();
  EXPECT_NEAR(exchange({0.01, 0.01, -0.002})->force_n[2], 0.8, 1e-4);
}

// A recording and a report need to know of these effects.
TEST_F(ReplyLoopTest, EffectsFromFilesAreInTheSetupAlsoAfterAChangeOfMethodAndWhenCutOff) {
  PluginEffects effects(clock_);
  ASSERT_TRUE(effects.add(*parse_plugin_choice(standin::library("plugins/odd_effect.so") + ":does=nan,after=3")));
  step_.use_effects(&effects);
  loop_.set_effects(&effects);
  const auto newest_method = [&] {
    for (int n = 0; n < 4; ++n) {
      clock_.advance_ns(200 * kMs);
      turn(1 * kMs);
      receive_reply();
    }
    return std::string(setups_.back().method.data());
  };
  EXPECT_NE(newest_method().find(" effects=odd_one@"), std::string::npos) << newest_method();
  MethodBuilder::MethodName name = {};
  std::copy_n("proxy", 5, name.begin());
  builder_.request(name);
  for (int n = 0; n < 3000 && step_.counts().method_changes == 0; ++n) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    turn(1 * kMs);
  }
  EXPECT_NE(newest_method().find("name=proxy"), std::string::npos);
  EXPECT_NE(newest_method().find(" effects=odd_one@"), std::string::npos);
  for (int n = 0; n < 5; ++n) ASSERT_TRUE(exchange({0.01, 0.01, 0.002}));
  EXPECT_NE(newest_method().find("!cut"), std::string::npos) << newest_method();
}

TEST_F(ReplyLoopTest, AMethodFromAFileThatIsCutOffIsInTheSetupUntilAnotherTakesItsPlace) {
  SimulatedClock still;
  auto method = PluginMethod::make(*parse_plugin_choice(standin::library("plugins/odd_method.so") + ":does=nan"), one_sheet(), still);
  ASSERT_TRUE(method);
  const auto before = step_.replace(std::make_unique<TouchStep>(std::move(*method)));
  ASSERT_TRUE(exchange({0.01, 0.01, 0.002}));
  const auto newest_method = [&] {
    for (int n = 0; n < 6; ++n) {
      clock_.advance_ns(200 * kMs);
      turn(1 * kMs);
      receive_reply();
    }
    return std::string(setups_.back().method.data());
  };
  EXPECT_NE(newest_method().find(" cut=method"), std::string::npos) << newest_method();
  step_.replace(std::make_unique<TouchStep>(*make_method({.name = "sweep"}, one_sheet())));
  ASSERT_TRUE(exchange({0.01, 0.01, 0.002}));
  EXPECT_EQ(newest_method().find(" cut=method"), std::string::npos) << newest_method();
}

}  // namespace
}  // namespace hapton
