// Recordings that lack something or are damaged: what is uncertain is not compared, and nothing takes for ever.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <limits>

#include "tests/support/one_line.h"
#include "tests/tools/session/session_replay_fixture.h"

namespace hapton {
namespace {

// The recording lacks a view in which the sphere was farther away: where the hand was free then, the replay may have contact.
TEST_F(SessionReplayTest, WithAViewThatIsMissingNothingIsCompared) {
  slide(60);
  ViewTransform away{.revision = 3};
  away.X_WS[3] = -0.02F;
  ASSERT_TRUE(live.turn_scene(away));
  slide(40);
  ASSERT_FALSE(recorded.back().second->contact);
  const ViewTransform back{.revision = 4};
  ASSERT_TRUE(live.turn_scene(back));
  slide_in_again(100);
  SessionReplay replay = make_replay();
  replay.on_view(back);
  feed(replay);
  EXPECT_EQ(replay.counts().missing_views, 40U);
  EXPECT_EQ(replay.counts().unknown_method, 40U);
  EXPECT_EQ(replay.counts().compared, 60U + 50U);
  EXPECT_EQ(replay.counts().different, 0U) << replay.counts().first_difference;
}

// A program, or a restarted vision node, may use a revision twice: a reply does not tell with which of the two poses it was computed.
TEST_F(SessionReplayTest, ForcesInAViewWhoseRevisionHasTwoPosesAreNotCompared) {
  slide(60);
  ViewTransform near{.revision = 3};
  near.X_WS[3] = 0.0005F;
  ASSERT_TRUE(live.turn_scene(near));
  slide(40);
  ViewTransform away{.revision = 3};
  away.X_WS[3] = -0.02F;
  ASSERT_TRUE(live.turn_scene(away));
  slide(100);
  ASSERT_FALSE(recorded.back().second->contact);
  const ViewTransform back{.revision = 4};
  ASSERT_TRUE(live.turn_scene(back));
  slide_in_again(200);
  SessionReplay replay = make_replay();
  for (std::size_t n = 0; n < recorded.size(); ++n) {
    if (n == 60 || n == 70) replay.on_view(near);  // the hub repeats it
    if (n == 100) replay.on_view(away);
    if (n == 200) replay.on_view(back);
    replay.on_state(recorded[n].first);
    ASSERT_TRUE(replay.on_reply(kSender, *recorded[n].second));
  }
  ASSERT_TRUE(replay.finish());
  EXPECT_EQ(replay.counts().missing_views, 140U);
  EXPECT_EQ(replay.counts().unknown_method, 140U);
  EXPECT_EQ(replay.counts().compared, 60U + 50U);
  EXPECT_EQ(replay.counts().different, 0U) << replay.counts().first_difference;
}

TEST_F(SessionReplayTest, APoseOfRevisionZeroIsAnotherThanThatOfTheSceneFile) {
  slide(60);
  ViewTransform moved;
  moved.X_WS[3] = 0.0005F;
  ASSERT_TRUE(live.turn_scene(moved));
  slide(100);
  SessionReplay replay = make_replay();
  replay.on_view(moved);
  feed(replay);
  EXPECT_EQ(replay.counts().missing_views, 160U);
  EXPECT_EQ(replay.counts().different, 0U) << replay.counts().first_difference;
}

TEST_F(SessionReplayTest, AFirstReplyWithoutASenderIsRejectedInOneLine) {
  slide(1);
  SessionReplay replay = make_replay();
  const auto done = replay.on_reply(0, *recorded[0].second);
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().what.find("does not name"), std::string::npos);
  EXPECT_THAT(done.error().what, IsOneLine());
}

// The damaged serial claims four billion changes, none of which is in the recording. Looking for each of them would take minutes.
TEST_F(SessionReplayTest, AfterADamagedSerialNothingIsCompared) {
  slide(100);
  for (std::uint32_t ForceCommand::*serial :
       {&ForceCommand::method_serial, &ForceCommand::material_serial, &ForceCommand::move_serial, &ForceCommand::shape_serial}) {
    ForceCommand& damaged = *recorded[59].second;
    damaged.*serial = std::numeric_limits<std::uint32_t>::max();
    SessionReplay replay = make_replay();
    feed(replay);
    EXPECT_EQ(replay.counts().compared, 59U);
    EXPECT_EQ(replay.counts().different, 0U) << replay.counts().first_difference;
    damaged.*serial = 0;
  }
}

TEST_F(SessionReplayTest, AfterAMethodSerialThatDecreasesNothingIsComparedUntilFreeSpace) {
  slide(60);
  live.replace(make_sphere_touch("reference"));
  send_setup("reference");
  slide(40);
  recorded[79].second->method_serial = 0;
  slide_in_again(100);
  SessionReplay replay = make_replay();
  feed(replay);
  EXPECT_GE(replay.counts().compared, 79U + 39U) << "a force fades in the air";
  EXPECT_EQ(replay.counts().compared + replay.counts().not_compared, 150U);
  EXPECT_GE(replay.counts().not_compared, 21U);
  EXPECT_EQ(replay.counts().different, 0U) << replay.counts().first_difference;
}

}  // namespace
}  // namespace hapton
