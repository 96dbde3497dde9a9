#include "io_node/probe_history.h"

#include <gtest/gtest.h>

#include "core/force/force_method.h"
#include "core/math/contact_resumption.h"

namespace hapton {
namespace {

DeviceSample sample_at(std::uint64_t number, double x_m) {
  DeviceSample sample;
  sample.time_ns = static_cast<std::int64_t>(number) * 1'000'000;
  sample.p_WD = Vec3(x_m, 0, 0);
  return sample;
}

ForceCommand reply_to(std::uint64_t number, bool contact) {
  ForceCommand command;
  command.echo_sample = number;
  command.contact = contact;
  command.visual_offset_m = Vec3(0, 0, 0.002);
  command.object = 4;
  command.haptons = 3;
  return command;
}

struct ProbeHistories : testing::Test {
  ProbeHistory history;
  ProbeState probe;
};

TEST_F(ProbeHistories, ShowsPoseAndOffsetOfOneSample) {
  history.note_sample(1, sample_at(1, 0.1));
  history.note_reply(reply_to(1, true));
  history.note_sample(2, sample_at(2, 0.2));
  history.show(false, probe);
  EXPECT_EQ(probe.sample, 1U);
  EXPECT_EQ(probe.sample_time_ns, 1'000'000);
  EXPECT_EQ(probe.p_WD.x(), 0.1);
  EXPECT_TRUE(probe.contact);
  EXPECT_EQ(probe.visual_offset_m.z(), 0.002);
  EXPECT_EQ(probe.object, 4);
  EXPECT_EQ(probe.haptons, 3U);
}

TEST_F(ProbeHistories, WithoutRepliesShowsTheNewestSampleAsItIsAndNeverGoesBack) {
  history.note_sample(1, sample_at(1, 0.1));
  history.note_sample(2, sample_at(2, 0.2));
  history.show(true, probe);
  EXPECT_EQ(probe.sample, 2U);
  EXPECT_FALSE(probe.contact);
  EXPECT_EQ(probe.visual_offset_m, Vec3(Vec3::Zero()));
  EXPECT_EQ(probe.object, -1);
  EXPECT_EQ(probe.haptons, std::nullopt) << "nobody has replied";
  history.note_reply(reply_to(1, true));
  history.show(false, probe);
  EXPECT_EQ(probe.sample, 2U);
}

// Objects that move by keyframes stay where they were when they were last felt.
TEST_F(ProbeHistories, ShowsTheSceneTimeOfTheLastReply) {
  history.note_sample(1, sample_at(1, 0.1));
  ForceCommand command = reply_to(1, true);
  command.scene_time_ns = 70'000'000;
  history.note_reply(command);
  history.show(false, probe);
  EXPECT_EQ(probe.scene_time_ns, 70'000'000);
  history.note_sample(2, sample_at(2, 0.2));
  history.show(true, probe);
  EXPECT_EQ(probe.sample, 2U);
  EXPECT_EQ(probe.scene_time_ns, 70'000'000);
  EXPECT_EQ(probe.haptons, 0U) << "a tool may be held";
}

TEST_F(ProbeHistories, ShowsTheTurnOfAToolAndWhatItPressesAsLongAsThereAreReplies) {
  history.note_sample(1, sample_at(1, 0.1));
  ForceCommand command = reply_to(1, true);
  command.visual_turn = Vec3(0, 0.1, 0);
  command.push = ObjectPush{Vec3(0, 0, -2), Vec3(0.01, 0, 0)};
  history.note_reply(command);
  history.show(false, probe);
  EXPECT_EQ(probe.visual_turn, command.visual_turn);
  EXPECT_EQ(probe.push, command.push);
  history.note_sample(2, sample_at(2, 0.2));
  history.show(true, probe);
  EXPECT_EQ(probe.visual_turn, Vec3(Vec3::Zero()));
  EXPECT_EQ(probe.push, ObjectPush()) << "a tool may be held";
  history.note_reply(reply_to(2, true));
  history.show(false, probe);
  EXPECT_EQ(probe.push, std::nullopt) << "no tool is held";
}

TEST_F(ProbeHistories, AReplyToAForgottenSampleHasNoPose) {
  for (std::uint64_t n = 1; n <= 1 + ProbeHistory::kSamples; ++n) history.note_sample(n, sample_at(n, 0.1));
  history.note_reply(reply_to(1, true));
  history.show(false, probe);
  EXPECT_EQ(probe.sample, 1 + ProbeHistory::kSamples);
  EXPECT_FALSE(probe.contact);
}

TEST_F(ProbeHistories, ANewHapticsNodeKeepsTheProbeInPlaceUntilItReplies) {
  history.note_sample(1, sample_at(1, 0.1));
  history.note_reply(reply_to(1, true));
  EXPECT_FALSE(history.find_resume_point(Vec3(0.1, 0, 0)));
  history.note_new_haptics();
  EXPECT_EQ(history.find_resume_point(Vec3(0.1, 0, 0)), Vec3(0.1, 0, 0.002));
  EXPECT_FALSE(history.find_resume_point(Vec3(0.1 + 2 * kResumeReachM, 0, 0)));
  history.forget_probe_position();
  EXPECT_FALSE(history.find_resume_point(Vec3(0.1, 0, 0)));
  history.note_reply(reply_to(1, false));
  history.note_new_haptics();
  EXPECT_FALSE(history.find_resume_point(Vec3(0.1, 0, 0)));  // no position is kept without contact
}

// The surface is 2 mm above the device. Beyond the surface contact is not resumed: it would hold the hand from the wrong side.
TEST_F(ProbeHistories, ContactIsNotResumedForADeviceThatHasLeftTheSurface) {
  history.note_sample(1, sample_at(1, 0.1));
  history.note_reply(reply_to(1, true));
  history.note_new_haptics();
  EXPECT_TRUE(history.find_resume_point(Vec3(0.105, 0.001, 0.0019)));
  EXPECT_FALSE(history.find_resume_point(Vec3(0.1, 0, 0.0021)));
  EXPECT_FALSE(history.find_resume_point(Vec3(0.105, 0.001, 0.01)));
  // The device may come back: then contact is resumed where it was.
  EXPECT_EQ(history.find_resume_point(Vec3(0.1, 0, 0.001)), Vec3(0.1, 0, 0.002));
}

TEST_F(ProbeHistories, AReplyToASampleFromBeforeTheRequestDoesNotCount) {
  history.note_sample(1, sample_at(1, 0.1));
  history.note_reply(reply_to(1, true));
  history.note_sample(2, sample_at(2, 0.1));
  history.note_new_haptics();
  history.note_reply(reply_to(2, true));  // replies to a sample from before the request
  EXPECT_TRUE(history.is_haptics_new());
  history.note_resumed(2);
  EXPECT_TRUE(history.is_haptics_new());
  history.note_sample(3, sample_at(3, 0.1));
  history.note_resumed(3);
  EXPECT_FALSE(history.is_haptics_new());
}

// A needle is drawn at its tip, but contact goes on from the point where the surface holds the needle.
TEST_F(ProbeHistories, ContactGoesOnFromTheProxyWhereverTheProbeIsDrawn) {
  history.note_sample(1, sample_at(1, 0.1));
  ForceCommand command = reply_to(1, true);
  command.held_offset_m = Vec3(0, 0, 0.007);
  history.note_reply(command);
  history.show(false, probe);
  EXPECT_EQ(probe.visual_offset_m.z(), 0.002);
  EXPECT_EQ(*history.find_probe(), Vec3(0.1, 0, 0.007));
  history.note_new_haptics();
  EXPECT_EQ(*history.find_resume_point(Vec3(0.1, 0, 0)), Vec3(0.1, 0, 0.007));
}

// Where the device side has computed the force until now, it also knows the probe of a hand without contact.
TEST_F(ProbeHistories, AFreeHandIsGivenToANodeThatIsToGoOn) {
  for (const bool was_local : {false, true}) {
    history.note_sample(1, sample_at(1, 0.1));
    ForceCommand free = reply_to(1, false);
    free.visual_offset_m.setZero();
    history.note_local(free);
    was_local ? history.note_resume_request() : history.note_new_haptics();
    history.note_sample(2, sample_at(2, 0.101));
    const std::optional<Vec3> resume_point = history.find_resume_point(Vec3(0.101, 0, 0));
    ASSERT_EQ(resume_point.has_value(), was_local) << "a node that has just joined begins at the device by itself";
    if (resume_point) {
      EXPECT_NEAR(resume_point->x(), 0.1 + MethodSettings().offset_m, 1e-15) << "the node begins farther off by its offset";
      EXPECT_NEAR(history.find_resume_point(Vec3(0.10009, 0, 0))->x(), 0.1 + MethodSettings().offset_m, 1e-15);
      EXPECT_EQ(history.find_resume_point(Vec3(0.100005, 0, 0)), Vec3(0.100005, 0, 0));
    }
    EXPECT_FALSE(history.find_resume_point(Vec3(0.1 + 2 * kResumeReachM, 0, 0)));
    history.note_reply(reply_to(2, false));
    EXPECT_FALSE(history.find_resume_point(Vec3(0.101, 0, 0)));
  }
  history.note_resume_request();
  history.forget_probe_position();
  EXPECT_FALSE(history.find_resume_point(Vec3(0.101, 0, 0))) << "the scene was turned";
}

}  // namespace
}  // namespace hapton
