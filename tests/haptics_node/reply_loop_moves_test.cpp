// Objects that programs move, in the loop of the haptics node: in simulated time, with a hub.
#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "haptics_node/reply_loop.h"
#include "link/commanded_move.h"
#include "scene/object_reader.h"
#include "tests/haptics_node/reply_loop_stage.h"
#include "tests/support/log_of.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

const Vec3 kHandOverPlate(0.01, 0.01, 0.01);

Scene plate_scene() {
  Scene scene;
  for (const char* name : {"plate", "wall"}) {
    SceneObject object;
    object.name = name;
    const double x = scene.objects.empty() ? 0.0 : 0.3;
    object.mesh = made::shared(made::box(Vec3(x - 0.05, -0.05, -0.02), Vec3(x + 0.05, 0.05, 0.0)));
    ObjectSpec spec;
    spec.motion.by_program = true;
    object.commanded = std::make_shared<const CommandedObject>(spec, SceneFit(), *object.mesh);
    scene.objects.push_back(object);
  }
  return scene;
}

class ReplyLoopMoves : public ReplyLoopStage {
 protected:
  ReplyLoopMoves() {
    loop_.set_object_mover(&mover_);
    for (int i = 0; i < 10 && client_.state() != JoinState::joined; ++i) cycle();
    cycle();
  }

  // Sends a sample, runs the loop once, and receives at the hub for a millisecond.
  ForceCommand cycle(const Vec3& hand = kHandOverPlate) {
    send(DeviceState{.sample = ++sample_, .sample_time_ns = clock_.now_ns(), .p_WD = hand});
    loop_.turn(clock_.now_ns() + kMs);
    order_.clear();
    receive_at_hub();
    return force_;
  }
  void take(const Message& message) override {
    if (const auto* got = std::get_if<ForceCommand>(&message)) force_ = *got;
    if (std::holds_alternative<ForceCommand>(message) && !moves_before_force_) moves_before_force_ = moves_.size();
    if (const auto* got = std::get_if<MoveReply>(&message)) replies_.push_back(*got);
    if (const auto* got = std::get_if<ObjectMove>(&message)) moves_.push_back(*got);
    if (std::holds_alternative<HapticsSetup>(message)) ++setups_;
  }
  MoveRequest lift_request(std::uint32_t request, double height_m, std::int32_t object = 0) const {
    return {.request = request, .number = object, .p_m = Vec3(0, 0, height_m)};
  }
  std::vector<ObjectMove> moves_with_serial(std::uint32_t serial) const {
    std::vector<ObjectMove> found;
    for (const ObjectMove& move : moves_) {
      if (move.serial == serial) found.push_back(move);
    }
    return found;
  }

  Scene scene_ = plate_scene();
  HapticsStep step_{std::make_unique<TouchStep>(*make_method({}, scene_.touch_scene()), scene_.touch_scene()), 1e-5};
  MethodBuilder builder_{{}, scene_.touch_scene()};
  ObjectMover mover_{scene_, 42};
  ReplyLoop loop_{client_, clock_, step_, builder_, {.scene_hash = 42}};
  std::vector<MoveReply> replies_;
  std::vector<ObjectMove> moves_;
  std::optional<std::size_t> moves_before_force_;  // how many were announced before the first force
  ForceCommand force_;
  int setups_ = 0;
  std::uint64_t sample_ = 0;
};

// The forces are those of the announced motion, evaluated at the scene time of each reply.
TEST_F(ReplyLoopMoves, ForcesAndTheAnnouncedMotionAgree) {
  ASSERT_EQ(client_.state(), JoinState::joined);
  moves_.clear();
  send(lift_request(7, 0.02));
  cycle();
  ASSERT_EQ(replies_.size(), 1U);
  EXPECT_EQ(replies_[0].request, 7U);
  EXPECT_STREQ(replies_[0].rejection.data(), "");
  ASSERT_EQ(moves_with_serial(1).size(), 1U);
  CommandedMotion announced_motion(scene_.objects[0].commanded->pivot());
  announced_motion.begin(to_command(moves_with_serial(1)[0]));
  double largest_force_n = 0.0;
  for (int n = 0; n < 200; ++n) {
    const ForceCommand force = cycle();
    EXPECT_EQ(force.move_serial, 1U);
    const double top = announced_motion.pose_at(1e-9 * static_cast<double>(force.scene_time_ns)).translation().z();
    ASSERT_NEAR(force.force_n.z(), 1000.0 * std::max(0.0, top - kHandOverPlate.z()), 1e-3) << n;
    largest_force_n = std::max(largest_force_n, force.force_n.z());
  }
  EXPECT_NEAR(largest_force_n, 10.0, 1e-3);
}

// A vision node knows the motion before the first sample that is felt with it.
TEST_F(ReplyLoopMoves, TheMotionIsAnnouncedBeforeTheFirstForceWithIt) {
  send(lift_request(7, 0.02));
  EXPECT_EQ(cycle().move_serial, 0U) << "the sample of this cycle gets its reply before the move begins";
  ASSERT_EQ(moves_with_serial(1).size(), 1U);
  EXPECT_EQ(cycle().move_serial, 1U);
  EXPECT_LT(moves_with_serial(1)[0].start_ns, force_.scene_time_ns);
}

TEST_F(ReplyLoopMoves, MovesAreRepeatedForNodesThatMissedThem) {
  send(lift_request(7, 0.02));
  for (int n = 0; n < 600; ++n) cycle();
  EXPECT_GE(moves_with_serial(1).size(), 4U) << "soon, a few times";
  moves_.clear();
  for (int n = 0; n < 2500; ++n) cycle();
  EXPECT_GE(moves_with_serial(1).size(), 1U) << "once a second, for a node that joins later";
  EXPECT_GE(moves_with_serial(0).size(), 1U) << "also those that were not moved: another haptics process may have moved them";
  for (const ObjectMove& move : moves_) EXPECT_EQ(move.source, 42U);
}

TEST_F(ReplyLoopMoves, OnlyTheNewestMoveIsRepeatedSoon) {
  for (int n = 0; n < 600; ++n) cycle();  // at first all moves are announced, a few times
  send(lift_request(7, 0.02, 0));
  for (int n = 0; n < 10; ++n) cycle();
  send(lift_request(8, 0.02, 1));
  for (int n = 0; n < 10; ++n) cycle();
  moves_.clear();
  for (int n = 0; n < 400; ++n) cycle();
  EXPECT_GE(moves_with_serial(2).size(), 3U);
  EXPECT_LE(moves_with_serial(1).size(), 1U) << "only with all others, once a second";
}

// This process has the objects where the scene file has them; a vision node may still have them where an earlier process moved them.
TEST_F(ReplyLoopMoves, PositionsOfObjectsAreAnnouncedBeforeTheFirstForce) {
  EXPECT_EQ(moves_before_force_, 2U) << "both";
  EXPECT_EQ(moves_with_serial(0).size(), moves_.size());
}

// Another process takes this one's place while this one stands still. When the other has left, this one continues with its own moves.
TEST_F(ReplyLoopMoves, PositionsOfObjectsAreAnnouncedBeforeTheFirstForceAfterAnotherProcess) {
  send(lift_request(7, 0.02));
  for (int n = 0; n < 400; ++n) cycle();
  {
    const std::unique_ptr<Endpoint> endpoint = *network_.open(memory_address(3, 0));
    HubClient other(*endpoint, clock_, NodeRole::haptics, memory_address(1, 4950));
    Datagram datagram;
    for (int n = 0; n < 300 && other.state() != JoinState::joined; ++n) {
      other.receive(datagram, 0);
      receive_at_hub();
    }
    ASSERT_EQ(other.state(), JoinState::joined);
    for (int n = 0; n < 300 && client_.state() != JoinState::rejected; ++n) {
      other.receive(datagram, 0);
      other.send(HapticsSetup{});
      cycle();
    }
    ASSERT_EQ(client_.state(), JoinState::rejected);
  }
  moves_.clear();
  moves_before_force_.reset();
  for (int n = 0; n < 300 && !moves_before_force_; ++n) cycle();
  EXPECT_EQ(moves_before_force_, 2U) << "both";
  EXPECT_GE(moves_with_serial(1).size(), 1U) << "the one that was moved is where it was";
}

TEST_F(ReplyLoopMoves, ARequestIsRepeatedUntilItsReplyComes) {
  send(lift_request(7, 0.02));
  cycle();
  for (int n = 0; n < 20; ++n) cycle();
  send(lift_request(7, 0.02));
  for (int n = 0; n < 10; ++n) cycle();
  EXPECT_EQ(replies_.size(), 2U);
  EXPECT_EQ(step_.counts().moves_taken, 1U);
}

// However many requests come, each sample gets its reply before anything else is sent, and one request is executed every few ms.
TEST_F(ReplyLoopMoves, AFloodNeverComesBeforeAForce) {
  const int setups_before = setups_;
  const std::uint64_t replied = step_.counts().replied;
  std::uint32_t request = 100;
  for (int n = 0; n < 400; ++n) {
    for (int k = 0; k < 20; ++k) send(lift_request(++request, 1e-4 * (k % 7), k % 2));
    const std::uint64_t echoed = sample_ + 1;
    ASSERT_EQ(cycle().echo_sample, echoed);
    ASSERT_FALSE(order_.empty());
    ASSERT_EQ(order_[0], Message(ForceCommand()).index()) << n;
    ASSERT_LE(order_.size(), 8U);
  }
  EXPECT_EQ(step_.counts().replied, replied + 400U);
  EXPECT_LE(step_.counts().moves_taken, 400U * 2U / 4U + 2U) << "one in 4 ms, of 20 a cycle of 2 ms";
  EXPECT_GE(step_.counts().moves_taken, 50U);
  EXPECT_LE(setups_ - setups_before, 4);
}

std::size_t count_of_text(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size())) ++count;
  return count;
}

// A program may send hundreds of requests a second.
TEST_F(ReplyLoopMoves, MovesAndRejectedRequestsAreReportedOnceASecondAtMost) {
  std::uint32_t request = 100;
  const auto request_often = [&](std::int32_t object) {
    return log_of([&] {
      for (int n = 0; n < 20; ++n) {
        send(lift_request(++request, 1e-3 * n, object));
        for (int k = 0; k < 3; ++k) cycle();
      }
    });
  };
  for (int second = 0; second < 2; ++second) {
    const std::string moved = request_often(0);
    EXPECT_EQ(count_of_text(moved, "a program moves plate, in "), 1U) << moved;
    EXPECT_EQ(count_of_text(moved, "rejected"), 0U) << moved;
    const std::string rejected = request_often(9);
    EXPECT_EQ(count_of_text(rejected, "a program's request was rejected: "), 1U) << rejected;
    EXPECT_EQ(count_of_text(rejected, "a program moves"), 0U) << rejected;
    for (int n = 0; n < 1100; ++n) cycle();
  }
}

TEST_F(ReplyLoopMoves, WithoutAMoverRequestsAreLeftOut) {
  loop_.set_object_mover(nullptr);
  send(lift_request(7, 0.02));
  for (int n = 0; n < 10; ++n) cycle();
  EXPECT_TRUE(replies_.empty());
  EXPECT_EQ(step_.counts().moves_taken, 0U);
}

}  // namespace
}  // namespace hapton
