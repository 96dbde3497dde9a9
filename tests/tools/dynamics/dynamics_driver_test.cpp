#include "tools/dynamics/dynamics_driver.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <limits>
#include <utility>

#include "haptic_step/material_tuning.h"
#include "haptic_step/object_mover.h"
#include "tests/tools/dynamics/pushed_scene.h"

namespace hapton::dynamics {
namespace {

using ::testing::HasSubstr;

constexpr std::int64_t kMs = 1'000'000;

// The haptics node and the dynamics, in simulated time, with a link between them that has a delay each way. The hand follows its path
// whatever force it feels: the hardest case for stability, as such a hand adds no damping of its own.
class Loop {
 public:
  Loop(Scene scene, DynamicsDriver::Settings settings, int link_ms)
      : scene_(std::move(scene)), driver_(*DynamicsDriver::make(scene_, settings)), link_ms_(link_ms) {
    start_haptics();
  }

  void start_haptics() {
    step_ = std::make_unique<HapticsStep>(std::make_unique<TouchStep>(*make_method({}, scene_.touch_scene()), scene_.touch_scene()), 1e-5);
    mover_ = std::make_unique<ObjectMover>(scene_, 42);
  }

  // Simulates one millisecond.
  ForceCommand step(const Vec3& hand) {
    const std::int64_t now_ns = kMs * ++sample_;
    step_->offer({.sample = static_cast<std::uint64_t>(sample_), .sample_time_ns = now_ns, .p_WD = hand});
    const ForceCommand reply = step_->reply();
    if (sample_ % 4 == 0 && mover_->has_request()) {
      const ObjectMover::Outcome outcome = mover_->carry_out(*step_);
      deliver_later(link_ms_, [this, outcome] { driver_.take(outcome.reply); });
    }
    const ProbeState state = {.sample = reply.echo_sample,
                              .sample_time_ns = now_ns,
                              .p_WD = hand,
                              .visual_offset_m = reply.visual_offset_m,
                              .force_n = reply.force_n,
                              .contact = reply.contact,
                              .object = reply.object,
                              .scene_time_ns = reply.scene_time_ns};
    if (sample_ % state_every_ms == 0) deliver_later(link_ms_, [this, state] { driver_.take(state); });
    while (!pending_.empty() && pending_.front().due_at <= sample_) {
      pending_.front().deliver();
      pending_.pop_front();
    }
    if (const auto request = driver_.next_request(now_ns)) {
      ++requests_sent_;
      if (!is_request_lost || !is_request_lost(requests_sent_)) deliver_later(link_ms_, [this, request] { mover_->request(*request); });
    }
    return reply;
  }

  Vec3 haptics_position() const {
    return step_->touch().find_commanded(kBox)->keyframe_at(1e-9 * static_cast<double>(step_->scene_time_ns())).p_S;
  }
  Vec3 dynamics_position() const { return driver_.world().place(kBox).p_S; }
  DynamicsDriver& driver() { return driver_; }
  // Sets the stiffness as `hapton set --stiffness` does, for the haptics node and, if is_sent_to_dynamics, for the dynamics.
  void set_stiffness(double n_per_m, bool is_sent_to_dynamics) {
    MaterialState state{.serial = 1, .object_count = 1};
    state.objects[0].change = {.fields = MaterialChange::kStiffness, .stiffness_n_per_m = n_per_m};
    step_->set_materials(tuned_materials(scene_.touch_scene(), state, 0.0));
    if (is_sent_to_dynamics) driver_.take(state);
  }

  std::function<bool(std::uint64_t)> is_request_lost = {};  // by the number of the request
  int state_every_ms = 4;                                   // about the default of io_node's --vision-rate

 private:
  struct PendingMessage {
    std::int64_t due_at;  // sample
    std::function<void()> deliver;
  };
  void deliver_later(int ms, std::function<void()> deliver) {
    const auto place = std::ranges::find_if(pending_, [&](const PendingMessage& w) { return w.due_at > sample_ + ms; });
    pending_.insert(place, {sample_ + ms, std::move(deliver)});
  }

  Scene scene_;
  std::unique_ptr<HapticsStep> step_;
  std::unique_ptr<ObjectMover> mover_;
  DynamicsDriver driver_;
  int link_ms_;
  std::int64_t sample_ = 0;
  std::uint64_t requests_sent_ = 0;
  std::deque<PendingMessage> pending_;
};

// The hand moves from the left of the box, at half its height, to the right at 0.1 m/s, 40 mm beyond the first contact; then it stays.
constexpr double kHandGapM = 0.005;
constexpr double kHandTravelM = 0.04;
constexpr double kHandSpeed = 0.1;
Vec3 hand_at(double t_s) {
  const double travel = std::clamp(kHandSpeed * (t_s - 0.2), 0.0, kHandGapM + kHandTravelM);
  return Vec3(-kBoxSideM / 2 - kHandGapM + travel, kBoxSideM / 2, 0.001);
}

struct PushForces {
  double max_n = 0.0;
  double min_end_n = std::numeric_limits<double>::infinity();  // in the last half second
  double max_end_n = 0.0;
};
PushForces push(Loop& loop, double seconds = 3.0) {
  PushForces forces;
  for (int i = 0; i < static_cast<int>(1000 * seconds); ++i) {
    const ForceCommand reply = loop.step(hand_at(1e-3 * i));
    forces.max_n = std::max(forces.max_n, reply.force_n.norm());
    if (i < static_cast<int>(1000 * seconds) - 500) continue;
    forces.max_end_n = std::max(forces.max_end_n, reply.force_n.norm());
    forces.min_end_n = std::min(forces.min_end_n, reply.force_n.norm());
  }
  return forces;
}

TEST(DynamicsDriver, ABoxGoesWhereTheHandPushesIt) {
  Loop loop(table_scene(), {}, 1);
  const Vec3 start = loop.haptics_position();
  const PushForces forces = push(loop);
  const double travel = loop.haptics_position().x() - start.x();
  EXPECT_NEAR(travel, kHandTravelM, 0.002);
  EXPECT_LT((loop.haptics_position() - loop.dynamics_position()).norm(), 1e-5)
      << "haptics and dynamics have it at different places in the end";
  EXPECT_GT(loop.driver().counts().pushes, 100U);
  EXPECT_GT(forces.max_n, 0.4 * kBoxKg * 9.81) << "friction on the table";
}

struct LoopCase {
  double mass_kg;
  double stiffness_n_per_m;
  int link_ms;
};

// The smallest and the largest force while the hand goes on at its speed: from 0.4 s after the contact, for 0.4 s.
std::pair<double, double> forces_while_moving(Loop& loop) {
  double max_n = 0.0;
  double min_n = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 900; ++i) {
    const double force = loop.step(Vec3(-kBoxSideM / 2 - 0.01 + 1e-3 * kHandSpeed * i, kBoxSideM / 2, 0.0)).force_n.norm();
    if (i < 500) continue;
    max_n = std::max(max_n, force);
    min_n = std::min(min_n, force);
  }
  return {min_n, max_n};
}

// No body bounces off the hand that pushes it, whatever its mass, its material and the link.
TEST(DynamicsDriver, ABodyStaysAtTheHandThatPushesIt) {
  for (const double mass : {0.02, 0.2, 2.0}) {
    for (const double stiffness : {300.0, 2000.0}) {
      for (const auto& [link_ms, state_every_ms] : {std::pair(1, 1), {1, 4}, {5, 4}, {15, 1}, {15, 10}}) {
        Loop loop(table_scene({.mass_kg = mass, .stiffness_n_per_m = stiffness}), {.friction = 0.1}, link_ms);
        loop.state_every_ms = state_every_ms;
        const auto [min_n, max_n] = forces_while_moving(loop);
        SCOPED_TRACE(fmt::format("{} kg, {} N/m, {} ms each way: delay {:.1f} ms, {:.2f} to {:.2f} N", mass, stiffness, link_ms,
                                 1e3 * loop.driver().delay_s(), min_n, max_n));
        EXPECT_GT(min_n, 0.2 * max_n);
        // The forces of the damping and of friction, and of an oscillation about their sum.
        const double damping_n = DynamicsDriver::kDampingShare * stiffness * loop.driver().delay_s() * kHandSpeed;
        EXPECT_LT(max_n, 1.6 * (damping_n + 0.1 * mass * 9.81 + std::sqrt(stiffness * mass) * kHandSpeed));
      }
    }
  }
}

TEST(DynamicsDriver, WithoutDampingABodyBouncesOff) {
  for (const int link_ms : {1, 15}) {
    Loop loop(table_scene({.stiffness_n_per_m = 2000}), {.friction = 0.1, .damping_share = 0.0}, link_ms);
    EXPECT_EQ(forces_while_moving(loop).first, 0.0);
  }
}

TEST(DynamicsDriver, AStiffnessChangedWhileRunningIsDampedToo) {
  for (const bool is_sent_to_dynamics : {true, false}) {
    Loop loop(table_scene({.stiffness_n_per_m = 100}), {.friction = 0.1}, 15);
    loop.set_stiffness(2000, is_sent_to_dynamics);
    const auto [min_n, max_n] = forces_while_moving(loop);
    EXPECT_EQ(min_n > 0.2 * max_n, is_sent_to_dynamics) << min_n << " to " << max_n << " N";
  }
}

TEST(DynamicsDriver, AnotherHapticsNodeHasTheStiffnessOfTheScene) {
  Loop loop(table_scene({.stiffness_n_per_m = 2000}), {.friction = 0.1}, 15);
  loop.set_stiffness(100, true);
  for (int i = 0; i < 100; ++i) loop.step(Vec3(-0.1, 0.1, 0));
  loop.start_haptics();
  const auto [min_n, max_n] = forces_while_moving(loop);
  EXPECT_GT(min_n, 0.2 * max_n) << min_n << " to " << max_n << " N";
}

// A force below the limit of friction moves nothing, so it stays as it is.
TEST(DynamicsDriver, AtRestTheForceIsSteady) {
  for (const LoopCase& c : std::vector<LoopCase>{{0.2, 300, 1}, {0.2, 2000, 15}, {2.0, 300, 15}, {2.0, 2000, 1}}) {
    Loop loop(table_scene({.mass_kg = c.mass_kg, .stiffness_n_per_m = c.stiffness_n_per_m}), {}, c.link_ms);
    const PushForces forces = push(loop);
    EXPECT_LT(forces.max_end_n - forces.min_end_n, 0.2) << c.mass_kg << " kg, " << c.stiffness_n_per_m << " N/m, " << c.link_ms << " ms";
  }
}

TEST(DynamicsDriver, LostRequestsAreSentAgain) {
  Loop loop(table_scene(), {}, 1);
  loop.is_request_lost = [](std::uint64_t n) { return n % 3 != 0; };
  push(loop);
  EXPECT_LT((loop.haptics_position() - loop.dynamics_position()).norm(), 1e-5);
}

TEST(DynamicsDriver, AnotherHapticsNodeGetsTheBodiesWhereTheyAre) {
  Loop loop(table_scene(), {}, 1);
  push(loop);
  const Vec3 before = loop.dynamics_position();
  loop.start_haptics();
  EXPECT_GT((loop.haptics_position() - before).norm(), 0.02);
  for (int i = 0; i < 1000; ++i) loop.step(Vec3(-0.1, 0.1, 0));
  EXPECT_LT((loop.haptics_position() - before).norm(), 1e-4);
  EXPECT_EQ(loop.driver().counts().restarts, 1U);
}

// An obstacle that keyframes move.
TEST(DynamicsDriver, AnObstacleThatKeyframesMoveCarriesABody) {
  Scene scene = table_scene();
  scene.objects[kTable].motion = std::make_shared<const KeyframeMotion>(
      Vec3::Zero(), std::vector<Keyframe>{{0.1, Vec3::Zero(), Quat::Identity()}, {0.3, Vec3(0, 0.02, 0), Quat::Identity()}}, false);
  DynamicsDriver driver = *DynamicsDriver::make(scene, {});
  ProbeState state;
  driver.take(state);
  const double start = driver.world().place(kBox).p_S.y();
  for (int ms = 1; ms <= 500; ++ms) {
    state.scene_time_ns = kMs * ms;
    driver.take(state);
  }
  EXPECT_NEAR(driver.world().place(kBox).p_S.y() - start, 0.02, 3e-4);
}

// An obstacle that the stylus picks up and puts down lower.
TEST(DynamicsDriver, ABodyFollowsAnObstacleThatIsPutDownElsewhere) {
  Scene scene = table_scene();
  scene.objects[kTable].is_movable = true;
  DynamicsDriver driver = *DynamicsDriver::make(scene, {});
  ProbeState state;
  const auto run_until = [&](int ms) {
    for (; state.scene_time_ns < kMs * ms; state.scene_time_ns += kMs) driver.take(state);
    driver.take(state);
  };
  run_until(100);
  const double start = driver.world().place(kBox).p_S.y();
  driver.take(ObjectPose{.serial = 1, .object = kTable});
  driver.take(ObjectPose{.serial = 1, .object = kBox, .is_held = true});
  driver.take(ObjectPose{.serial = 1, .object = 9, .is_held = true});
  run_until(200);
  EXPECT_NEAR(driver.world().place(kBox).p_S.y(), start, 1e-5) << "nothing was picked up";
  driver.take(ObjectPose{.serial = 2, .object = kTable, .is_held = true});
  run_until(250);
  EXPECT_LT(driver.world().place(kBox).p_S.y() - start, -0.005);
  driver.take(ObjectPose{.serial = 3, .object = kTable, .p_m = Vec3(0, -0.05, 0)});
  driver.take(ObjectPose{.serial = 2, .object = kTable, .is_held = true}, Arrival::reordered);
  run_until(1'000);
  EXPECT_NEAR(driver.world().place(kBox).p_S.y() - start, -0.05, 3e-4);
}

// In a scene that is turned and moved, the hand pushes at its own position, opposite to the force that it feels.
TEST(DynamicsDriver, AHandPushesInTheFrameOfTheScene) {
  const Scene scene = table_scene({.height_m = 0.05});
  const auto displaced = [&](const Pose& X_WS) {
    DynamicsDriver driver = *DynamicsDriver::make(scene, {.gravity_W = Vec3::Zero()});
    HapticsSetup setup;
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) {
        setup.X_WS[static_cast<std::size_t>(4 * row + column)] = static_cast<float>(X_WS.matrix()(row, column));
      }
    }
    driver.take(setup);
    const Keyframe start = driver.world().place(kBox);
    // The hand is 1 mm deep in the side of the box, above its middle.
    const Vec3 tip_S = start.p_S + Vec3(-kBoxSideM / 2, kBoxSideM / 4, 0);
    ProbeState state{.p_WD = X_WS * (tip_S + Vec3(0.001, 0, 0)),
                     .visual_offset_m = X_WS.linear() * Vec3(-0.001, 0, 0),
                     .force_n = X_WS.linear() * Vec3(-1.0, 0, 0),
                     .contact = true,
                     .object = kBox};
    for (int ms = 0; ms <= 20; ++ms) {
      state.scene_time_ns = kMs * ms;
      driver.take(state);
    }
    EXPECT_EQ(driver.counts().pushes, 21U);
    const Keyframe end = driver.world().place(kBox);
    return std::pair<Vec3, Vec3>(end.p_S - start.p_S, (end.turn * start.turn.inverse()).vec());
  };
  const auto [straight_m, straight_turn] = displaced(Pose::Identity());
  EXPECT_GT(straight_m.x(), 1e-4);
  EXPECT_LT(straight_turn.z(), -1e-3) << "above the middle: it tips forwards";
  Pose X_WS = Pose::Identity();
  X_WS.linear() = Eigen::AngleAxisd(2.0, Vec3(1, 2, 2) / 3.0).toRotationMatrix();
  X_WS.translation() = Vec3(0.3, -0.2, 0.1);
  const auto [turned_m, turned_turn] = displaced(X_WS);
  EXPECT_LT((turned_m - straight_m).norm(), 1e-6);
  EXPECT_LT((turned_turn - straight_turn).norm(), 1e-5);
}

struct DriverAlone : testing::Test {
  void SetUp() override { state.status = ProbeStatus::ok; }
  void advance_to(std::int64_t ms) {
    state.scene_time_ns = kMs * ms;
    driver.take(state);
  }

  Scene scene = table_scene({.height_m = 0.05});
  DynamicsDriver driver = *DynamicsDriver::make(scene, {});
  ProbeState state;
};

TEST_F(DriverAlone, TimeIsSceneTime) {
  advance_to(1000);
  const Vec3 start = driver.world().place(kBox).p_S;
  for (int i = 0; i < 50; ++i) advance_to(1000);  // without a device, scene time stands still
  EXPECT_EQ(driver.counts().steps, 0U);
  EXPECT_EQ(driver.world().place(kBox).p_S, start);
  advance_to(1010);
  EXPECT_EQ(driver.counts().steps, 10U);
  advance_to(5000);  // a long gap
  EXPECT_EQ(driver.counts().steps, 110U);
  EXPECT_EQ(driver.counts().left_out_ns, 3890 * kMs);
}

TEST_F(DriverAlone, GravityFollowsTheView) {
  HapticsSetup setup;
  // The scene lies on its side: x of S is up.
  setup.X_WS = {0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0};
  driver.take(setup);
  advance_to(0);
  const Vec3 start = driver.world().place(kBox).p_S;
  advance_to(50);
  const Vec3 displacement = driver.world().place(kBox).p_S - start;
  EXPECT_LT(displacement.x(), -0.005);
  EXPECT_NEAR(displacement.y(), 0.0, 1e-6);
}

// The table is lifted by another program: the box on it goes along.
TEST(DynamicsDriver, AnObstacleThatAProgramMovesCarriesABody) {
  Scene scene = table_scene();
  make_commanded(scene.objects[kTable]);
  DynamicsDriver driver = *DynamicsDriver::make(scene, {});
  const Vec3 pivot = scene.objects[kTable].commanded->pivot();
  driver.take({.source = 5,
               .serial = 1,
               .object = kTable,
               .start_ns = 100 * kMs,
               .end_ns = 300 * kMs,
               .from_p_m = pivot,
               .to_p_m = pivot + Vec3(0, 0.02, 0)},
              Arrival::newest);
  ProbeState state;
  driver.take(state);
  const double start = driver.world().place(kBox).p_S.y();
  for (int ms = 1; ms <= 500; ++ms) {
    state.scene_time_ns = kMs * ms;
    driver.take(state);
  }
  EXPECT_NEAR(driver.world().place(kBox).p_S.y() - start, 0.02, 3e-4);
}

// There are 200 requests a second in all, and each moves its body for the time until the next request for the same body.
TEST(DynamicsDriver, BodiesTakeTurns) {
  Scene scene = table_scene({.height_m = 0.3});
  SceneObject other = scene.objects[kBox];
  other.mesh = moved(*other.mesh, {0.1, 0, 0});
  make_commanded(other);
  const int kOther = static_cast<int>(scene.objects.size());
  scene.objects.push_back(std::move(other));
  DynamicsDriver driver = *DynamicsDriver::make(scene, {.first_request = 0xFFFFFFFFU});
  ProbeState state;
  EXPECT_FALSE(driver.next_request(0)) << "no state has come";
  std::vector<int> objects;
  std::vector<std::uint32_t> numbers;
  for (int ms = 0; ms < 40; ++ms) {
    state.scene_time_ns = kMs * ms;
    driver.take(state);
    const auto request = driver.next_request(kMs * ms);
    ASSERT_EQ(request.has_value(), ms % 5 == 0) << ms;
    if (!request) continue;
    EXPECT_NEAR(*request->over_s, 0.01, 1e-12) << "two bodies that fall";
    objects.push_back(request->number);
    numbers.push_back(request->request);
  }
  EXPECT_EQ(objects, (std::vector<int>{kBox, kOther, kBox, kOther, kBox, kOther, kBox, kOther}));
  for (std::size_t n = 0; n < numbers.size(); ++n) EXPECT_EQ(numbers[n], n + 1) << "0 is not a number";
}

// The delay: the time from the request to the reply, one interval between states, and the duration of the move itself (5 ms).
TEST_F(DriverAlone, TheDelayIsMeasured) {
  advance_to(0);
  EXPECT_DOUBLE_EQ(driver.delay_s(), 0.02) << "assumed";
  const auto request = driver.next_request(0);
  ASSERT_TRUE(request);
  advance_to(30);
  advance_to(40);
  driver.take(MoveReply{.request = request->request});
  EXPECT_NEAR(driver.delay_s(), 0.04 + 0.01 + 0.005, 1e-12);
  const auto quick = driver.next_request(40 * kMs);
  ASSERT_TRUE(quick);
  advance_to(41);
  driver.take(MoveReply{.request = quick->request});
  EXPECT_NEAR(driver.delay_s(), 0.995 * 0.055, 1e-12) << "a shorter one counts little by little";
  const auto slow = driver.next_request(50 * kMs);
  ASSERT_TRUE(slow);
  advance_to(1000);
  driver.take(MoveReply{.request = slow->request});
  EXPECT_DOUBLE_EQ(driver.delay_s(), 0.2) << "no more damping than for that";
}

// A request without a reply is repeated unchanged if the body has not moved.
TEST_F(DriverAlone, ALostRequestIsRepeatedAfterFiftyMilliseconds) {
  advance_to(0);
  const auto request = driver.next_request(0);
  ASSERT_TRUE(request);
  EXPECT_FALSE(driver.next_request(50 * kMs - 1));
  const auto again = driver.next_request(50 * kMs);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->request, request->request);
  EXPECT_EQ(again->p_m, request->p_m);
  EXPECT_FALSE(driver.next_request(100 * kMs - 1));
  EXPECT_TRUE(driver.next_request(100 * kMs));
  EXPECT_EQ(driver.counts().requests, 3U);
}

TEST(DynamicsDriver, ABodyThatFallsOutIsReportedOnce) {
  Scene scene = table_scene();
  scene.objects[kBox].mesh = moved(*scene.objects[kBox].mesh, {0.5, 0, 0});  // beside the table
  make_commanded(scene.objects[kBox]);
  DynamicsDriver driver = *DynamicsDriver::make(scene, {});
  ProbeState state;
  for (int ms = 0; ms < 20'000 && driver.counts().fallen == 0; ms += 50) {
    state.scene_time_ns = kMs * ms;
    driver.take(state);
  }
  EXPECT_EQ(driver.counts().fallen, 1U);
  EXPECT_EQ(driver.take_fallen(), std::vector<int>{kBox});
  EXPECT_TRUE(driver.take_fallen().empty());
}

TEST_F(DriverAlone, ARejectionIsReported) {
  advance_to(0);
  const auto request = driver.next_request(0);
  ASSERT_TRUE(request);
  MoveReply reply = {.request = request->request, .rejection = {"no"}};
  driver.take(reply);
  EXPECT_EQ(driver.take_rejection(), "no");
  EXPECT_EQ(driver.take_rejection(), "");
  reply.request += 1;  // a reply to another program
  driver.take(reply);
  EXPECT_EQ(driver.take_rejection(), "");
  // It is requested again, although the body is at rest: another program may have taken its place for a moment.
  EXPECT_FALSE(driver.next_request(49 * kMs));
  const auto again = driver.next_request(50 * kMs);
  ASSERT_TRUE(again);
  EXPECT_NE(again->request, request->request);
  driver.take(MoveReply{.request = again->request});
  EXPECT_FALSE(driver.next_request(200 * kMs));
}

TEST_F(DriverAlone, OneRequestAtATimeAndNoneForABodyAtRest) {
  advance_to(0);
  ASSERT_TRUE(driver.next_request(0));
  for (int ms = 1; ms < 2000; ++ms) {
    advance_to(ms);
    if (const auto request = driver.next_request(kMs * ms)) driver.take(MoveReply{.request = request->request});
  }
  const std::uint64_t requests = driver.counts().requests;
  EXPECT_GT(requests, 20U);
  EXPECT_LE(requests, 401U);
  // Bullet lets the body sleep after two seconds, which may move it once, by micrometres.
  int requests_at_rest = 0;
  for (int ms = 2000; ms < 6000; ++ms) {
    advance_to(ms);
    const auto request = driver.next_request(kMs * ms);
    if (!request) continue;
    ++requests_at_rest;
    driver.take(MoveReply{.request = request->request});
  }
  EXPECT_LE(requests_at_rest, 1);
}

}  // namespace
}  // namespace hapton::dynamics
