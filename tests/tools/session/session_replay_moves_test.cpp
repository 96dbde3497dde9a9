// Replays of sessions in which programs moved objects.
#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <vector>

#include "link/commanded_move.h"
#include "tests/tools/session/session_replay_fixture.h"

namespace hapton {
namespace {

std::unique_ptr<TouchStep> make_commanded_touch() {
  TouchScene scene = one_sphere();
  scene.objects[0].command_pivot = Vec3(0.001, 0, 0);
  return std::make_unique<TouchStep>(*make_method({.name = "proxy"}, scene), scene);
}

struct MovesReplayTest : SessionReplayTest {
  ObjectMoves moves;

  MovesReplayTest() : SessionReplayTest(make_commanded_touch()) {
    announce({.source = 1, .from_p_m = Vec3(0.001, 0, 0), .to_p_m = Vec3(0.001, 0, 0)});
  }

  void announce(const ObjectMove& move) { moves[{kSender, move.serial, move.object}] = move; }

  // Moves the object as a program requests it at this sample.
  ObjectMove move_to(const Vec3& p, double seconds) {
    const std::int64_t now_ns = live.scene_time_ns();
    const Keyframe from = live.touch().find_commanded(0)->keyframe_at(1e-9 * static_cast<double>(now_ns));
    const ObjectMove move{.source = 1,
                          .serial = static_cast<std::uint32_t>(live.counts().moves_taken) + 1,
                          .start_ns = now_ns,
                          .end_ns = now_ns + static_cast<std::int64_t>(1e9 * seconds),
                          .from_p_m = from.p_S,
                          .from_q = from.turn,
                          .to_p_m = p,
                          .to_q = Quat(Eigen::AngleAxisd(3.0 * p.x(), Vec3::UnitZ()))};
    EXPECT_TRUE(live.command(0, to_command(move)));
    announce(move);
    return move;
  }
  // Five moves of 80 ms each: the last ones begin before the previous move has ended.
  void slide_and_move() {
    slide(60);
    for (int n = 0; n < 5; ++n) {
      move_to(Vec3(0.001 + (n % 2 == 0 ? 0.004 : -0.002), 0.001 * n, 0.0), 0.08);
      slide(n < 2 ? 100 : 37);
    }
    slide(100);
  }
  SessionReplay make_replay() {
    SessionReplay replay = replay_with(make_commanded_touch);
    replay.use_moves(moves);
    return replay;
  }
};

TEST_F(MovesReplayTest, MovesGiveTheSameForcesToTheLastBit) {
  slide_and_move();
  SessionReplay replay = make_replay();
  feed(replay);
  EXPECT_EQ(replay.counts().compared, recorded.size());
  EXPECT_GT(replay.counts().contact_steps, 200U);
  EXPECT_EQ(replay.counts().different, 0U) << replay.counts().first_difference;
}

// This test can fail: if one move starts a sample later, the forces differ.
TEST_F(MovesReplayTest, AnotherStartIsAnotherForce) {
  slide_and_move();
  ObjectMove& third = moves.at({kSender, 3, 0});
  third.start_ns += 1'000'000;
  SessionReplay replay = make_replay();
  feed(replay);
  EXPECT_GT(replay.counts().different, 0U);
}

TEST_F(MovesReplayTest, RepliesThatWereLostAreRepeatedWithTheirMoves) {
  slide_and_move();
  for (std::size_t n = 30; n < 300; n += 3) {
    for (std::size_t k = n; k < n + 2; ++k) recorded[k].second.reset();
  }
  SessionReplay replay = make_replay();
  feed(replay);
  EXPECT_GT(replay.counts().lost_replies, 100U);
  EXPECT_GT(replay.counts().compared, 200U);
  EXPECT_EQ(replay.counts().different, 0U) << replay.counts().first_difference;
}

// The recording lacks a move: no force is reported as different because of it.
TEST_F(MovesReplayTest, AfterALostMoveNothingIsCompared) {
  slide_and_move();
  moves.erase({kSender, 2, 0});
  SessionReplay replay = make_replay();
  feed(replay);
  EXPECT_EQ(replay.counts().compared, 160U) << "up to the second move";
  EXPECT_EQ(replay.counts().unknown_method, recorded.size() - 160U);
  EXPECT_EQ(replay.counts().different, 0U);
}

// The recording began after the haptics node, which then announced the newest move of each object.
TEST_F(MovesReplayTest, ARecordingThatBeginsLaterKnowsWhereObjectsAre) {
  slide_and_move();
  const std::uint64_t before = sample;
  slide_in_again(before);
  recorded.erase(recorded.begin(), recorded.begin() + static_cast<std::ptrdiff_t>(before));
  for (const std::uint32_t serial : {1, 2, 3, 4}) moves.erase({kSender, serial, 0});
  SessionReplay replay = make_replay();
  feed(replay);
  EXPECT_GT(replay.counts().compared, 40U);
  EXPECT_GT(replay.counts().contact_steps, 20U);
  EXPECT_EQ(replay.counts().different, 0U) << replay.counts().first_difference;
  moves.clear();
  SessionReplay without = make_replay();
  feed(without);
  EXPECT_EQ(without.counts().compared, 0U) << "nothing says where the object is";
}

// The recording of a scene in which no program moves objects has neither serials nor moves.
TEST_F(SessionReplayTest, ARecordingWithoutMovesIsReplayedAsBefore) {
  slide(100);
  SessionReplay replay = make_replay();
  replay.use_moves({});
  feed(replay);
  EXPECT_EQ(replay.counts().compared, 100U);
  EXPECT_EQ(replay.counts().different, 0U);
}

}  // namespace
}  // namespace hapton
