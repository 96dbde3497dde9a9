#include "haptic_step/object_mover.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <string>

#include "link/commanded_move.h"
#include "scene/object_motion.h"
#include "scene/object_reader.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

SceneObject box_object(const char* name, const Vec3& low, const Vec3& high, bool by_program) {
  SceneObject object;
  object.name = name;
  object.mesh = made::shared(made::box(low, high));
  if (by_program) {
    ObjectSpec spec;
    spec.motion.by_program = true;
    object.commanded = std::make_shared<const CommandedObject>(spec, SceneFit(), *object.mesh);
  }
  return object;
}

// 0: a floor that no program moves; 1: a plate above it; 2 and 3: two objects with the same name.
Scene movers_scene() {
  Scene scene;
  scene.objects.push_back(box_object("floor", {-0.2, -0.2, -0.06}, {0.2, 0.2, -0.05}, false));
  scene.objects.push_back(box_object("plate", {-0.05, -0.05, -0.004}, {0.05, 0.05, 0.0}, true));
  scene.objects.push_back(box_object("leg", {0.1, 0.0, 0.0}, {0.11, 0.01, 0.01}, true));
  scene.objects.push_back(box_object("leg", {0.1, 0.1, 0.0}, {0.11, 0.11, 0.01}, true));
  return scene;
}

constexpr std::uint32_t kSource = 42;

struct ObjectMoverTest : testing::Test {
  Scene scene = movers_scene();
  HapticsStep step{std::make_unique<TouchStep>(*make_method({}, scene.touch_scene()), scene.touch_scene()), 1e-5};
  ObjectMover mover{scene, kSource};
  std::uint64_t sample = 0;
  std::uint32_t last_request = 100;

  ForceCommand reply_to(const Vec3& hand = {0.01, 0.02, 0.02}) {
    ++sample;
    step.offer({.sample = sample, .sample_time_ns = 1'000'000 * static_cast<std::int64_t>(sample), .p_WD = hand});
    return step.reply();
  }
  MoveRequest lift_request(double height_m, std::optional<double> over_s = std::nullopt) {
    return {.request = ++last_request, .object = {"plate"}, .p_m = Vec3(0, 0, height_m), .over_s = over_s};
  }
  ObjectMover::Outcome execute(const MoveRequest& request) {
    mover.request(request);
    EXPECT_TRUE(mover.has_request());
    return mover.carry_out(step);
  }
  std::string rejection_of(const MoveRequest& request) {
    const ObjectMover::Outcome outcome = execute(request);
    EXPECT_FALSE(outcome.move);
    EXPECT_EQ(outcome.reply.request, request.request);
    return outcome.reply.rejection.data();
  }
  double height() const {
    return step.touch().find_commanded(1)->pose_at(1e-9 * static_cast<double>(step.scene_time_ns())).translation().z();
  }
};

// The motion in the forces, the announced motion and the reply agree.
TEST_F(ObjectMoverTest, ARequestMovesTheObjectAndItsForce) {
  for (int i = 0; i < 10; ++i) reply_to();
  const ObjectMover::Outcome outcome = execute(lift_request(0.03, 0.4));
  ASSERT_TRUE(outcome.move);
  EXPECT_STREQ(outcome.move->name.data(), "plate");
  EXPECT_STREQ(outcome.reply.rejection.data(), "");
  EXPECT_EQ(outcome.reply.object, 1);
  EXPECT_DOUBLE_EQ(outcome.reply.over_s, 0.4);
  EXPECT_EQ(outcome.reply.serial, 1U);
  EXPECT_EQ(outcome.move->source, kSource);
  EXPECT_EQ(outcome.move->serial, 1U);
  EXPECT_EQ(outcome.move->object, 1);
  EXPECT_EQ(outcome.move->start_ns, 9'000'000) << "the scene time of the last reply";
  EXPECT_EQ(outcome.move->end_ns, 409'000'000);
  EXPECT_EQ(mover.moves()[0].serial, 1U);
  CommandedMotion announced_motion(scene.objects[1].commanded->pivot());
  announced_motion.begin(to_command(*outcome.move));
  int contacts = 0;
  for (int i = 0; i < 600; ++i) {
    const ForceCommand reply = reply_to();
    EXPECT_EQ(reply.move_serial, 1U);
    const double top = announced_motion.pose_at(1e-9 * static_cast<double>(reply.scene_time_ns)).translation().z();
    ASSERT_NEAR(reply.force_n.z(), 1000.0 * std::max(0.0, top - 0.02), 1e-3) << i;
    contacts += reply.contact ? 1 : 0;
  }
  EXPECT_GT(contacts, 200);
  EXPECT_EQ(height(), 0.03);
}

TEST_F(ObjectMoverTest, MovesAreSlowedToTheLargestSurfaceSpeed) {
  reply_to();
  const ObjectMover::Outcome slowed = execute(lift_request(0.05, 0.01));
  ASSERT_TRUE(slowed.move);
  EXPECT_NEAR(slowed.reply.over_s, 0.05 / kMaxSurfaceSpeed, 1e-9) << "not 0.01 s";
  const ObjectMover::Outcome fastest = execute(lift_request(0.05));
  EXPECT_NEAR(fastest.reply.over_s, 0.05 / kMaxSurfaceSpeed, 1e-9);
  double previous_height = height();
  for (int i = 0; i < 300; ++i) {
    reply_to();
    EXPECT_LE(height() - previous_height, 1e-3 * kMaxSurfaceSpeed * (1.0 + 1e-9));
    previous_height = height();
  }
  EXPECT_EQ(height(), 0.05);
  MoveRequest turn{.request = 7, .object = {"plate"}, .q = Quat(Eigen::AngleAxisd(1.0, Vec3::UnitZ()))};
  const double radius = scene.objects[1].commanded->radius_m();
  EXPECT_NEAR(execute(turn).reply.over_s, radius / kMaxSurfaceSpeed, 1e-9);
}

TEST_F(ObjectMoverTest, ANewerRequestTakesOverWithoutAJump) {
  reply_to();
  execute(lift_request(0.05, 1.0));
  std::mt19937 random(3);
  std::uniform_real_distribution<double> target(-0.04, 0.05);
  double previous_height = height();
  for (int i = 0; i < 2000; ++i) {
    if (i % 7 == 0) execute(lift_request(target(random), 0.02));
    EXPECT_EQ(height(), previous_height) << "at the moment of the request, " << i;
    reply_to();
    ASSERT_LE(std::abs(height() - previous_height), 1e-3 * kMaxSurfaceSpeed * (1.0 + 1e-9)) << i;
    previous_height = height();
  }
  EXPECT_EQ(step.counts().moves_taken, 1U + 286U) << "the first one, and one at every seventh of 2000 samples";
}

TEST_F(ObjectMoverTest, AMissingPositionOrRotationIsUnchanged) {
  reply_to();
  execute(lift_request(0.02, 0.1));
  for (int i = 0; i < 200; ++i) reply_to();
  const Quat turned(Eigen::AngleAxisd(0.5, Vec3::UnitX()));
  const ObjectMover::Outcome outcome = execute({.request = 5, .object = {"plate"}, .q = turned});
  ASSERT_TRUE(outcome.move);
  EXPECT_EQ(outcome.move->to_p_m, Vec3(0, 0, 0.02));
  EXPECT_LT(outcome.move->to_q.angularDistance(turned), 1e-12);
}

TEST_F(ObjectMoverTest, ARepeatedRequestGetsTheSameReplyAndNoNewMove) {
  reply_to();
  const MoveRequest first = lift_request(0.02, 0.5);
  const ObjectMover::Outcome outcome = execute(first);
  const MoveRequest second = lift_request(-0.01, 0.5);
  execute(second);
  const ObjectMover::Outcome again = execute(first);
  EXPECT_FALSE(again.move) << "it would take over from the second";
  EXPECT_EQ(again.reply.serial, outcome.reply.serial);
  EXPECT_EQ(again.reply.over_s, outcome.reply.over_s);
  EXPECT_EQ(step.counts().moves_taken, 2U);
  const MoveRequest unknown{.request = 900, .object = {"lid"}, .p_m = Vec3::Zero()};
  EXPECT_EQ(rejection_of(unknown), rejection_of(unknown));
}

// A sender repeats its request until the reply comes, a few samples later at the earliest.
TEST_F(ObjectMoverTest, ARepetitionOfARequestThatWaitsIsThatRequest) {
  reply_to();
  const MoveRequest only = lift_request(0.02, 0.5);
  for (int n = 0; n < 3; ++n) mover.request(only);
  const ObjectMover::Outcome outcome = mover.carry_out(step);
  EXPECT_TRUE(outcome.move);
  EXPECT_EQ(outcome.reply.request, only.request);
  EXPECT_STREQ(outcome.reply.rejection.data(), "");
  EXPECT_FALSE(mover.has_request());
}

TEST_F(ObjectMoverTest, ARepetitionOfWhatWasCarriedOutDisplacesNothingNew) {
  reply_to();
  const MoveRequest first = lift_request(0.02, 0.5);
  execute(first);
  const MoveRequest second = lift_request(-0.01, 0.5);
  mover.request(second);
  mover.request(first);
  const ObjectMover::Outcome outcome = mover.carry_out(step);
  ASSERT_TRUE(outcome.move);
  EXPECT_EQ(outcome.reply.request, second.request);
  EXPECT_EQ(outcome.move->to_p_m, Vec3(0, 0, -0.01));
}

TEST_F(ObjectMoverTest, ATurnBeginsWhereTheOneBeforeHasEnded) {
  reply_to();
  const Quat turned(Eigen::AngleAxisd(0.3, Vec3::UnitZ()));
  ASSERT_TRUE(execute({.request = 5, .object = {"plate"}, .q = turned, .over_s = 0.1}).move);
  for (int i = 0; i < 400; ++i) reply_to();
  const ObjectMover::Outcome back = execute({.request = 6, .object = {"plate"}, .q = Quat::Identity(), .over_s = 0.1});
  ASSERT_TRUE(back.move);
  EXPECT_LT(back.move->from_q.angularDistance(turned), 1e-9);
  const Pose before = step.touch().find_commanded(1)->pose_at(1e-9 * static_cast<double>(step.scene_time_ns()));
  EXPECT_LT(Quat(before.linear()).angularDistance(turned), 1e-9) << "no jump";
}

TEST_F(ObjectMoverTest, InvalidRequestsAreRejectedWithOneLine) {
  reply_to();
  const auto request_for = [&](const char* name) {
    MoveRequest request{.request = ++last_request, .p_m = Vec3::Zero()};
    std::copy_n(name, std::char_traits<char>::length(name), request.object.begin());
    return request;
  };
  EXPECT_THAT(rejection_of(request_for("floor")),
              HasSubstr("programs may not move 'floor': give it moved_by = \"program\" in the scene file"));
  EXPECT_THAT(rejection_of(request_for("plat")), HasSubstr("there is no object 'plat'; programs may move 'plate' and others"));
  EXPECT_THAT(rejection_of(request_for("leg")), HasSubstr("2 objects are named 'leg': give the number of one"));
  EXPECT_THAT(rejection_of({.request = 1, .number = 4, .p_m = Vec3::Zero()}), HasSubstr("there is no object 4: the scene has 4"));
  EXPECT_THAT(rejection_of({.request = 2, .number = 0, .p_m = Vec3::Zero()}), HasSubstr("programs may not move 'floor'"));
  EXPECT_THAT(rejection_of(lift_request(1e9)), HasSubstr("it may take a day at most"));
  EXPECT_EQ(step.counts().moves_taken, 0U);
  EXPECT_TRUE(execute({.request = 3, .number = 3, .p_m = Vec3::Zero()}).move) << "by its number";
  Scene immovable_scene = movers_scene();
  for (SceneObject& object : immovable_scene.objects) object.commanded.reset();
  ObjectMover idle_mover(immovable_scene, kSource);
  idle_mover.request(request_for("lid"));
  EXPECT_THAT(idle_mover.carry_out(step).reply.rejection.data(), HasSubstr("none that programs may move (moved_by = \"program\""));
  EXPECT_TRUE(idle_mover.moves().empty());
}

// Of several pending requests for one object only the newest is executed; the others are rejected, with the reason.
TEST_F(ObjectMoverTest, AFloodKeepsOneRequestForEachObject) {
  reply_to();
  std::vector<MoveRequest> flood;
  for (int n = 0; n < 5000; ++n) flood.push_back(lift_request(0.01 + 1e-6 * n));
  for (const MoveRequest& request : flood) mover.request(request);
  mover.request({.request = 1, .number = 3, .p_m = Vec3::Zero()});
  const ObjectMover::Outcome outcome = mover.carry_out(step);
  ASSERT_TRUE(outcome.move);
  EXPECT_EQ(outcome.reply.request, flood.back().request);
  EXPECT_EQ(mover.carry_out(step).reply.object, 3);
  EXPECT_FALSE(mover.has_request());
  // This is one of the last kMaxReplies requests, whose replies are kept.
  EXPECT_THAT(execute(flood[4990]).reply.rejection.data(), HasSubstr("a newer request for 'plate' replaced this one"));
  EXPECT_EQ(step.counts().moves_taken, 2U);
}

TEST_F(ObjectMoverTest, RequestsBeyondTheQueueAreCounted) {
  Scene many = movers_scene();
  for (int n = 0; n < 30; ++n) many.objects.push_back(box_object("more", {0.1 * n, 0.0, 0.0}, {0.1 * n + 0.05, 0.1, 0.1}, true));
  ObjectMover full_mover(many, kSource);
  for (std::int32_t n = 0; n < 30; ++n)
    full_mover.request({.request = 500U + static_cast<std::uint32_t>(n), .number = n, .p_m = Vec3::Zero()});
  EXPECT_EQ(full_mover.overflows(), 30U - ObjectMover::kMaxWaiting);
}

// Requests use no heap, whether valid or not and however many: the loop that replies to the device handles them.
TEST_F(ObjectMoverTest, UsesNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  reply_to();
  std::vector<MoveRequest> requests = {lift_request(0.02, 0.5),
                                       lift_request(1e9),
                                       {.request = 1, .object = {"floor"}, .p_m = Vec3::Zero()},
                                       {.request = 2, .object = {"leg"}, .p_m = Vec3::Zero()},
                                       {.request = 3, .number = 77, .p_m = Vec3::Zero()}};
  MoveRequest long_name{.request = 4, .p_m = Vec3::Zero()};
  std::fill(long_name.object.begin(), long_name.object.end() - 1, 'x');
  requests.push_back(long_name);
  const AllocationGuard guard;
  for (std::uint32_t n = 0; n < 300; ++n) {
    MoveRequest request = requests[n % requests.size()];
    request.request = 1000 + n;
    mover.request(request);
    if (n % 3 == 0) mover.carry_out(step);
    reply_to();
  }
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_GT(step.counts().moves_taken, 10U);
}

// The announced moves, applied at the same samples as in a replay, give the same forces as the requests, to the last bit.
TEST_F(ObjectMoverTest, TheAnnouncedMovesGiveTheSameForces) {
  std::vector<std::pair<std::size_t, ObjectMove>> announced;
  std::vector<ForceCommand> live;
  for (std::size_t n = 0; n < 800; ++n) {
    live.push_back(reply_to());
    if (n % 50 == 10) announced.emplace_back(n + 1, *execute(lift_request(n % 100 < 50 ? 0.05 : 0.01, 0.03)).move);
  }
  HapticsStep replay{std::make_unique<TouchStep>(*make_method({}, scene.touch_scene()), scene.touch_scene()), 1e-5};
  std::size_t next = 0;
  int contacts = 0;
  for (std::size_t n = 0; n < live.size(); ++n) {
    for (; next < announced.size() && announced[next].first == n; ++next) replay.command(1, to_command(announced[next].second));
    replay.offer({.sample = n + 1, .sample_time_ns = 1'000'000 * static_cast<std::int64_t>(n + 1), .p_WD = {0.01, 0.02, 0.02}});
    const ForceCommand reply = replay.reply();
    ASSERT_EQ(reply.force_n, live[n].force_n) << n;
    ASSERT_EQ(reply.move_serial, live[n].move_serial) << n;
    contacts += reply.contact ? 1 : 0;
  }
  EXPECT_GT(contacts, 100);
}

// The hub has to know of a move before it begins: until then the object is where it was.
TEST_F(ObjectMoverTest, AMoveStartsAfterTheLead) {
  for (int i = 0; i < 10; ++i) reply_to();
  mover.set_lead_ns(100'000'000);
  const ObjectMover::Outcome outcome = execute(lift_request(0.03, 0.4));
  ASSERT_TRUE(outcome.move);
  EXPECT_EQ(outcome.move->start_ns, 109'000'000);
  EXPECT_EQ(outcome.move->end_ns, 509'000'000);
  for (int i = 0; i < 100; ++i) reply_to();
  EXPECT_EQ(height(), 0.0);
  for (int i = 0; i < 200; ++i) reply_to();
  EXPECT_NEAR(height(), 0.015, 1e-12);
}

// The lead has become shorter, so the newer move starts before the pending one. The newer move replaces it at once, without the minimum
// time that is otherwise between two moves.
TEST_F(ObjectMoverTest, AMoveThatStartsBeforeThePendingOneIsNotDelayed) {
  for (int i = 0; i < 10; ++i) reply_to();
  mover.set_lead_ns(500'000'000);
  ASSERT_TRUE(execute(lift_request(0.03, 0.1)).move);
  mover.set_lead_ns(498'000'000);
  const ObjectMover::Outcome outcome = execute(lift_request(0.02, 0.1));
  ASSERT_TRUE(outcome.move);
  EXPECT_EQ(outcome.move->start_ns, 507'000'000);
  for (int i = 0; i < 1000; ++i) reply_to();
  EXPECT_NEAR(height(), 0.02, 1e-12);
}

// A program that sends poses without pause: at most kMaxFutureMoves moves, half of what a CommandedMotion keeps, wait for their start, and
// the object follows without a jump.
TEST_F(ObjectMoverTest, PendingMovesAreLimitedToHalfOfThoseKept) {
  mover.set_lead_ns(1'000'000'000);
  std::uint64_t moves = 0;
  double previous_height = 0.0;
  for (int i = 0; i < 4000; ++i) {
    mover.request(lift_request(0.01 * std::sin(0.002 * i), 0.01));
    const ObjectMover::Outcome outcome = mover.carry_out(step);
    moves += outcome.move ? 1 : 0;
    reply_to();
    ASSERT_LE(std::abs(height() - previous_height), 1e-3 * kMaxSurfaceSpeed * (1.0 + 1e-9)) << i;
    previous_height = height();
  }
  EXPECT_LE(moves, std::uint64_t{4000} * 1'000'000U * static_cast<std::uint64_t>(ObjectMover::kMaxFutureMoves) / 1'000'000'000U + 2U);
  EXPECT_GT(moves, 100U);
  EXPECT_NEAR(previous_height, 0.01 * std::sin(0.002 * 3000), 0.001) << "it follows, a second later";
}

}  // namespace
}  // namespace hapton
