// A rigid tool pushes a body: haptics node and dynamics with a link between them, on simulated time.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <limits>

#include "core/tool/held_tool.h"
#include "haptic_step/haptics_setup.h"
#include "haptic_step/method_text.h"
#include "haptic_step/object_mover.h"
#include "scene/tool_obstacles.h"
#include "tests/tools/dynamics/pushed_scene.h"
#include "tools/dynamics/dynamics_driver.h"

namespace hapton::dynamics {
namespace {

constexpr std::int64_t kTickNs = 1'000'000;
constexpr double kPushSpeed = 0.05;
constexpr double kSpringNPerM = 500.0;

class ToolLoop {
 public:
  ToolLoop(Scene scene, const TriangleMesh& tool, int link_ms, double damping_share = DynamicsDriver::kDampingShare)
      : scene_(std::move(scene)), driver_(*DynamicsDriver::make(scene_, {.damping_share = damping_share})), link_ms_(link_ms) {
    const TouchScene touch = scene_.touch_scene();
    step_ = std::make_unique<HapticsStep>(std::make_unique<TouchStep>(*make_method({}, touch), touch), 1e-5);
    mover_ = std::make_unique<ObjectMover>(scene_, 42);
    ToolObstacles obstacles = make_tool_obstacles(touch);
    tool_ = std::make_unique<HeldTool>(std::move(*ToolStep::make(tool, std::move(obstacles.meshes), {.stiffness_n_per_m = kSpringNPerM},
                                                                 std::move(obstacles.friction), nullptr, obstacles.part_of)));
    step_->hold(tool_.get(), std::move(obstacles.parts));
    HapticsSetup setup;
    put_text(to_text(tool_->tool().coupling(), 12), setup.method);
    driver_.take(setup);
  }

  ForceCommand step(const Vec3& hand, const Quat& turn = Quat::Identity()) {
    const std::int64_t now_ns = kTickNs * ++sample_;
    step_->offer({.sample = static_cast<std::uint64_t>(sample_), .sample_time_ns = now_ns, .p_WD = hand, .q_WT = turn});
    const ForceCommand reply = step_->reply();
    tool_->follow();
    if (sample_ % 4 == 0 && mover_->has_request()) {
      const ObjectMover::Outcome outcome = mover_->carry_out(*step_);
      deliver_later([this, outcome] { driver_.take(outcome.reply); });
    }
    const ProbeState state = {.sample = reply.echo_sample,
                              .sample_time_ns = now_ns,
                              .p_WD = hand,
                              .visual_offset_m = reply.visual_offset_m,
                              .force_n = reply.force_n,
                              .contact = reply.contact,
                              .object = reply.object,
                              .scene_time_ns = reply.scene_time_ns,
                              .push = reply.push};
    if (sample_ % 4 == 0) deliver_later([this, state] { driver_.take(state); });
    while (!pending_.empty() && pending_.front().first <= sample_) {
      pending_.front().second();
      pending_.pop_front();
    }
    if (const auto request = driver_.next_request(now_ns)) deliver_later([this, request] { mover_->request(*request); });
    return reply;
  }
  Keyframe place() const { return driver_.world().place(kBox); }
  const HeldTool& tool() const { return *tool_; }

 private:
  void deliver_later(std::function<void()> deliver) { pending_.emplace_back(sample_ + link_ms_, std::move(deliver)); }

  Scene scene_;
  DynamicsDriver driver_;
  std::unique_ptr<HapticsStep> step_;
  std::unique_ptr<ObjectMover> mover_;
  std::unique_ptr<HeldTool> tool_;
  int link_ms_;
  std::int64_t sample_ = 0;
  std::deque<std::pair<std::int64_t, std::function<void()>>> pending_;
};

// A cube of 20 mm that comes from the left; its side starts 5 mm before the side of the box.
const TriangleMesh kPusher = made::box(Vec3::Constant(-0.01), Vec3::Constant(0.01));
Vec3 pusher_at(int ms, double travel_m, double y, double z) {
  return {-kBoxSideM / 2 - 0.015 + std::min(travel_m, kPushSpeed * std::max(0.0, 1e-3 * ms - 0.1)), y, z};
}

TEST(ToolPushes, ABoxGoesWhereTheToolPushesIt) {
  for (const int link_ms : {1, 10}) {
    ToolLoop loop(table_scene(), kPusher, link_ms);
    const Vec3 start = loop.place().p_S;
    double max_n = 0.0;
    double min_n = std::numeric_limits<double>::infinity();
    for (int ms = 0; ms < 1500; ++ms) {
      const ForceCommand reply = loop.step(pusher_at(ms, 0.045, kBoxSideM / 2, 0.0));
      if (ms < 500 || ms >= 900) continue;
      max_n = std::max(max_n, reply.force_n.norm());
      min_n = std::min(min_n, reply.force_n.norm());
    }
    const Vec3 displacement = loop.place().p_S - start;
    EXPECT_NEAR(displacement.x(), 0.045 - 0.005, 0.003) << link_ms << " ms";
    EXPECT_NEAR(displacement.z(), 0.0, 1e-3);
    EXPECT_LT(turn_between(Quat::Identity(), loop.place().turn).norm(), 0.05);
    EXPECT_GT(min_n, 0.1 * max_n) << "it stays at the tool, " << link_ms << " ms";
    EXPECT_LT(max_n, 5.0);
  }
}

// The tool also slides on the table, pressed down: the table's force on the tool must not act on the box.
TEST(ToolPushes, ForcesOfTheToolOnOtherObjectsDoNotActOnTheBody) {
  ToolLoop loop(table_scene(), kPusher, 1);
  const Keyframe start = loop.place();
  double down_n = 0.0;
  for (int ms = 0; ms < 1500; ++ms) {
    // In the end the hand is 10 mm below the place where the cube's lower side touches the table: 5 N.
    down_n = loop.step(pusher_at(ms, 0.045, std::max(0.0, 0.05 - 1e-3 * ms), 0.0)).force_n.y();
  }
  EXPECT_NEAR(down_n, 5.0, 0.2);
  const Vec3 displacement = loop.place().p_S - start.p_S;
  EXPECT_NEAR(displacement.x(), 0.040, 0.003);
  EXPECT_NEAR(displacement.y(), 0.0, 5e-4);
  EXPECT_LT(turn_between(start.turn, loop.place().turn).norm(), 0.05);
}

// Pushed beside its middle the box turns, as the contact's force has a lever.
TEST(ToolPushes, APushBesideItsMiddleTurnsTheBox) {
  ToolLoop loop(table_scene(), kPusher, 1);
  for (int ms = 0; ms < 1200; ++ms) loop.step(pusher_at(ms, 0.02, kBoxSideM / 2, 0.022));
  const Vec3 turn = turn_between(Quat::Identity(), loop.place().turn);
  EXPECT_GT(turn.y(), 0.1) << "towards +x at +z: from z to x is positive";
}

// The forces of two contacts nearly cancel: the line of the force that is left is far away, but the body is damped where the body is.
TEST(ToolPushes, ACoupleTurnsTheBoxWhateverIsLeftOfItsForce) {
  for (const double remaining_n : {0.0, 1e-12, 1e-9, 1e-6, 1e-300}) {
    const Scene scene = table_scene();
    DynamicsDriver driver = *DynamicsDriver::make(scene, {});
    HapticsSetup setup;
    put_text(to_text(ToolCoupling{.stiffness_n_per_m = kSpringNPerM, .rotational_stiffness_nm_per_rad = 0.05}, 12), setup.method);
    driver.take(setup);
    for (int ms = 0; ms < 400; ++ms) {
      driver.take(ProbeState{.sample = static_cast<std::uint64_t>(ms),
                             .sample_time_ns = kTickNs * ms,
                             .p_WD = driver.world().place(kBox).p_S,
                             .contact = true,
                             .object = kBox,
                             .scene_time_ns = kTickNs * ms,
                             .push = ObjectPush{.force_n = {remaining_n, 0.0, 0.0}, .torque_nm = {0.0, 0.05, 0.0}}});
    }
    EXPECT_GT(turn_between(Quat::Identity(), driver.world().place(kBox).turn).y(), 0.02) << remaining_n;
  }
}

// In the end F = B v and torque = B w, with B from the tool's springs and the delay that is assumed before one is measured.
TEST(ToolPushes, ABodyIsDampedByTheDelayInItsMotionAndItsTurn) {
  const Scene scene = table_scene({.height_m = 0.1});
  DynamicsDriver driver = *DynamicsDriver::make(scene, {.gravity_W = Vec3::Zero()});
  HapticsSetup setup;
  put_text(to_text(ToolCoupling{.stiffness_n_per_m = kSpringNPerM, .rotational_stiffness_nm_per_rad = 0.05}, 12), setup.method);
  driver.take(setup);
  Keyframe before;
  for (int ms = 0; ms <= 400; ++ms) {
    if (ms == 300) before = driver.world().place(kBox);
    driver.take(ProbeState{.sample = static_cast<std::uint64_t>(ms),
                           .sample_time_ns = kTickNs * ms,
                           .p_WD = driver.world().place(kBox).p_S,
                           .contact = true,
                           .object = kBox,
                           .scene_time_ns = kTickNs * ms,
                           .push = ObjectPush{.force_n = {0.1, 0.0, 0.0}, .torque_nm = {1e-3, 0.0, 0.0}}});
  }
  const Keyframe after = driver.world().place(kBox);
  const double delay_s = 0.02;
  const double interval_s = 0.1;
  const double speed = 0.1 / (DynamicsDriver::kDampingShare * kSpringNPerM * delay_s);
  const double turn_rate = 1e-3 / (DynamicsDriver::kDampingShare * 0.05 * delay_s);
  EXPECT_NEAR((after.p_S - before.p_S).x() / interval_s, speed, 0.03 * speed);
  EXPECT_NEAR(turn_between(before.turn, after.turn).x() / interval_s, turn_rate, 0.03 * turn_rate);
}

}  // namespace
}  // namespace hapton::dynamics
