#include "link/known_moves.h"

#include <gtest/gtest.h>

#include <cstring>
#include <vector>

#include "link/commanded_move.h"

namespace hapton {
namespace {

constexpr std::int64_t kSecondNs = 1'000'000'000;
const Vec3 kPivotAtRest(0.1, 0.0, 0.0);
const Quat kTurn(Eigen::AngleAxisd(1.5, Vec3::UnitZ()));

ObjectMove announced_at_rest(std::uint32_t source, std::int32_t object) {
  return {.source = source, .object = object, .from_p_m = kPivotAtRest, .to_p_m = kPivotAtRest};
}

// A move that takes two seconds.
ObjectMove announced_move(std::uint32_t serial, std::int64_t start_ns, const Vec3& from, const Vec3& to) {
  return {
      .source = 5, .serial = serial, .object = 2, .start_ns = start_ns, .end_ns = start_ns + 2 * kSecondNs, .from_p_m = from, .to_p_m = to};
}

TEST(KnownMoves, AnObjectThatWasNotAnnouncedIsUnknown) {
  KnownMoves known;
  known.take(announced_at_rest(5, 1), Arrival::newest);
  EXPECT_FALSE(known.find(2, 0.0));
  const auto placed = known.find(1, 7.0);
  ASSERT_TRUE(placed);
  EXPECT_EQ(placed->at, (Keyframe{7.0, kPivotAtRest, Quat::Identity()}));
  EXPECT_FALSE(placed->is_moving);
}

// The position must be the one that haptics and pictures compute (CommandedMotion).
TEST(KnownMoves, AnObjectIsWhereItsMovesHaveItAtThatTime) {
  KnownMoves known;
  CommandedMotion expected(kPivotAtRest);
  known.take(announced_at_rest(5, 2), Arrival::newest);
  const Vec3 half_way(0.1, 0.1, 0.0);
  for (const ObjectMove& move :
       {announced_move(1, kSecondNs, kPivotAtRest, Vec3(0.1, 0.2, 0.0)), announced_move(2, 2 * kSecondNs, half_way, Vec3(0.4, 0.0, 0.0))}) {
    known.take(move, Arrival::newest);
    expected.begin(to_command(move));
  }
  for (const double time_s : {0.0, 1.0, 1.7, 2.0, 2.9, 4.0, 9.0}) {
    const auto placed = known.find(2, time_s);
    ASSERT_TRUE(placed);
    EXPECT_EQ(placed->at.p_S, expected.keyframe_at(time_s).p_S) << time_s;
    EXPECT_EQ(placed->at.time_s, time_s);
    EXPECT_EQ(placed->is_moving, time_s < 4.0) << time_s;
  }
}

// The program joined after the moves before.
TEST(KnownMoves, BeforeItsFirstKnownMoveAnObjectIsWhereThatOneBegan) {
  KnownMoves known;
  ObjectMove move = announced_move(9, 5 * kSecondNs, Vec3(0.1, 0.2, 0.0), Vec3(0.4, 0.0, 0.0));
  move.from_q = kTurn;
  known.take(move, Arrival::newest);
  for (const double time_s : {0.0, 1.0, 4.9, 5.0}) {
    const auto placed = known.find(2, time_s);
    ASSERT_TRUE(placed);
    EXPECT_EQ(placed->at.p_S, move.from_p_m) << time_s;
    EXPECT_EQ(placed->at.turn.coeffs(), kTurn.coeffs()) << time_s;
  }
  EXPECT_EQ(known.find(2, 7.0)->at.p_S, move.to_p_m);
}

TEST(KnownMoves, AnotherHapticsProcessHasOtherMovesAndNames) {
  KnownMoves known;
  known.take(announced_at_rest(5, 1), Arrival::newest);
  known.take(announced_move(1, 0, kPivotAtRest, Vec3(0.4, 0.0, 0.0)), Arrival::newest);
  known.note_name("lid", 2);
  EXPECT_EQ(known.find_named("lid").object, 2);
  EXPECT_EQ(known.find_name(2), "lid");
  EXPECT_FALSE(known.find_named("li").object);
  known.take(announced_at_rest(6, 2), Arrival::newest);
  EXPECT_EQ(known.find(2, 7.0)->at.p_S, kPivotAtRest);
  EXPECT_FALSE(known.find(1, 7.0)) << "not announced by this one yet";
  EXPECT_FALSE(known.find_named("lid").object);
  known.take(announced_move(2, kSecondNs, kPivotAtRest, Vec3(0.4, 0.0, 0.0)), Arrival::reordered);
  EXPECT_EQ(known.find(2, 7.0)->at.p_S, kPivotAtRest) << "of the process before, and late";
}

TEST(KnownMoves, AnObjectIsKnownByTheNameThatItsMovesHave) {
  KnownMoves known;
  const auto announce = [&](std::int32_t object, const char* name) {
    ObjectMove move = announced_at_rest(5, object);
    std::strcpy(move.name.data(), name);
    known.take(move, Arrival::newest);
  };
  announce(4, "door");
  announce(1, "lid");
  announce(2, "bolt");
  announce(3, "bolt");
  announce(0, "");  // no name: a haptics node of an earlier build
  EXPECT_EQ(known.objects(), (std::vector<std::int32_t>{0, 1, 2, 3, 4}));
  EXPECT_EQ(known.find_named("door").object, 4);
  EXPECT_EQ(known.find_name(1), "lid");
  EXPECT_EQ(known.find_name(0), "");
  EXPECT_EQ(known.find_named("bolt").count, 2U);
  EXPECT_EQ(known.find_named("bolt").object, 2);
  EXPECT_EQ(known.find_named("").count, 0U);
}

TEST(KnownMoves, ObjectsOfAnyNumbersTakeLittleMemory) {
  KnownMoves known;
  for (std::int32_t object = 0; object < 70'000; ++object) {
    ObjectMove move = announced_at_rest(5, object);
    move.name = {"a"};
    known.take(move, Arrival::newest);
  }
  EXPECT_EQ(known.objects().size(), KnownMoves::kMaxObjects);
  EXPECT_EQ(known.find_named("a").count, KnownMoves::kMaxObjects);
  EXPECT_TRUE(known.find(0, 0.0));
  known.note_name("b", 0);
  EXPECT_EQ(known.find_name(0), "b") << "a known object still takes a name";
}

}  // namespace
}  // namespace hapton
