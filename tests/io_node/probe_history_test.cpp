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

struct Memory : testing::Test {
  ProbeHistory memory;
  ProbeState shown;
};

TEST_F(Memory, ShowsPoseAndOffsetOfOneSample) {
  memory.note_sample(1, sample_at(1, 0.1));
  memory.note_reply(reply_to(1, true));
  memory.note_sample(2, sample_at(2, 0.2));
  memory.show(false, shown);
  EXPECT_EQ(shown.sample, 1U);
  EXPECT_EQ(shown.sample_time_ns, 1'000'000);
  EXPECT_EQ(shown.p_WD.x(), 0.1);
  EXPECT_TRUE(shown.contact);
  EXPECT_EQ(shown.visual_offset_m.z(), 0.002);
  EXPECT_EQ(shown.object, 4);
  EXPECT_EQ(shown.haptons, 3U);
}

TEST_F(Memory, WithoutRepliesShowsTheNewestSampleAsItIsAndNeverGoesBack) {
  memory.note_sample(1, sample_at(1, 0.1));
  memory.note_sample(2, sample_at(2, 0.2));
  memory.show(true, shown);
  EXPECT_EQ(shown.sample, 2U);
  EXPECT_FALSE(shown.contact);
  EXPECT_EQ(shown.visual_offset_m, Vec3(Vec3::Zero()));
  EXPECT_EQ(shown.object, -1);
  EXPECT_EQ(shown.haptons, std::nullopt) << "nobody has replied";
  memory.note_reply(reply_to(1, true));
  memory.show(false, shown);
  EXPECT_EQ(shown.sample, 2U);
}

// Objects that move by keyframes stay where they were when they were last felt.
TEST_F(Memory, ShowsTheSceneTimeOfTheLastReply) {
  memory.note_sample(1, sample_at(1, 0.1));
  ForceCommand command = reply_to(1, true);
  command.scene_time_ns = 70'000'000;
  memory.note_reply(command);
  memory.show(false, shown);
  EXPECT_EQ(shown.scene_time_ns, 70'000'000);
  memory.note_sample(2, sample_at(2, 0.2));
  memory.show(true, shown);
  EXPECT_EQ(shown.sample, 2U);
  EXPECT_EQ(shown.scene_time_ns, 70'000'000);
  EXPECT_EQ(shown.haptons, 0U) << "of a tool that may be held";
}

TEST_F(Memory, ShowsTheTurnOfAToolAndWhatItPressesAsLongAsThereAreReplies) {
  memory.note_sample(1, sample_at(1, 0.1));
  ForceCommand command = reply_to(1, true);
  command.visual_turn = Vec3(0, 0.1, 0);
  command.push = ObjectPush{Vec3(0, 0, -2), Vec3(0.01, 0, 0)};
  memory.note_reply(command);
  memory.show(false, shown);
  EXPECT_EQ(shown.visual_turn, command.visual_turn);
  EXPECT_EQ(shown.push, command.push);
  memory.note_sample(2, sample_at(2, 0.2));
  memory.show(true, shown);
  EXPECT_EQ(shown.visual_turn, Vec3(Vec3::Zero()));
  EXPECT_EQ(shown.push, ObjectPush()) << "of a tool that may be held";
  memory.note_reply(reply_to(2, true));
  memory.show(false, shown);
  EXPECT_EQ(shown.push, std::nullopt) << "none is held";
}

TEST_F(Memory, AReplyToAForgottenSampleHasNoPose) {
  for (std::uint64_t n = 1; n <= 1 + ProbeHistory::kSamples; ++n) memory.note_sample(n, sample_at(n, 0.1));
  memory.note_reply(reply_to(1, true));
  memory.show(false, shown);
  EXPECT_EQ(shown.sample, 1 + ProbeHistory::kSamples);
  EXPECT_FALSE(shown.contact);
}

TEST_F(Memory, ANewHapticsNodeKeepsTheProbeInPlaceUntilItReplies) {
  memory.note_sample(1, sample_at(1, 0.1));
  memory.note_reply(reply_to(1, true));
  EXPECT_FALSE(memory.find_resume_point(Vec3(0.1, 0, 0)));
  memory.note_new_haptics();
  EXPECT_EQ(memory.find_resume_point(Vec3(0.1, 0, 0)), Vec3(0.1, 0, 0.002));
  EXPECT_FALSE(memory.find_resume_point(Vec3(0.1 + 2 * kResumeReachM, 0, 0)));
  memory.forget_probe_position();
  EXPECT_FALSE(memory.find_resume_point(Vec3(0.1, 0, 0)));
  memory.note_reply(reply_to(1, false));
  memory.note_new_haptics();
  EXPECT_FALSE(memory.find_resume_point(Vec3(0.1, 0, 0)));  // no position is kept without contact
}

// The surface is 2 mm above the device. Beyond the surface contact is not resumed: it would hold the hand from the wrong side.
TEST_F(Memory, ContactIsNotResumedForADeviceThatHasLeftTheSurface) {
  memory.note_sample(1, sample_at(1, 0.1));
  memory.note_reply(reply_to(1, true));
  memory.note_new_haptics();
  EXPECT_TRUE(memory.find_resume_point(Vec3(0.105, 0.001, 0.0019)));
  EXPECT_FALSE(memory.find_resume_point(Vec3(0.1, 0, 0.0021)));
  EXPECT_FALSE(memory.find_resume_point(Vec3(0.105, 0.001, 0.01)));
  // The device may come back: then contact is resumed where it was.
  EXPECT_EQ(memory.find_resume_point(Vec3(0.1, 0, 0.001)), Vec3(0.1, 0, 0.002));
}

TEST_F(Memory, AReplyToASampleFromBeforeTheRequestDoesNotCount) {
  memory.note_sample(1, sample_at(1, 0.1));
  memory.note_reply(reply_to(1, true));
  memory.note_sample(2, sample_at(2, 0.1));
  memory.note_new_haptics();
  memory.note_reply(reply_to(2, true));  // replies to a sample from before the request
  EXPECT_TRUE(memory.is_haptics_new());
  memory.note_resumed(2);
  EXPECT_TRUE(memory.is_haptics_new());
  memory.note_sample(3, sample_at(3, 0.1));
  memory.note_resumed(3);
  EXPECT_FALSE(memory.is_haptics_new());
}

// A needle is drawn at its tip, but contact goes on from the point where the surface holds the needle.
TEST_F(Memory, ContactGoesOnFromTheProxyWhereverTheProbeIsDrawn) {
  memory.note_sample(1, sample_at(1, 0.1));
  ForceCommand command = reply_to(1, true);
  command.held_offset_m = Vec3(0, 0, 0.007);
  memory.note_reply(command);
  memory.show(false, shown);
  EXPECT_EQ(shown.visual_offset_m.z(), 0.002);
  EXPECT_EQ(*memory.find_probe(), Vec3(0.1, 0, 0.007));
  memory.note_new_haptics();
  EXPECT_EQ(*memory.find_resume_point(Vec3(0.1, 0, 0)), Vec3(0.1, 0, 0.007));
}

// Where the device side has computed the force until now, it also knows the probe of a hand without contact.
TEST_F(Memory, AFreeHandIsGivenToANodeThatIsToGoOn) {
  for (const bool was_local : {false, true}) {
    memory.note_sample(1, sample_at(1, 0.1));
    ForceCommand free = reply_to(1, false);
    free.visual_offset_m.setZero();
    memory.note_local(free);
    was_local ? memory.note_resume_request() : memory.note_new_haptics();
    memory.note_sample(2, sample_at(2, 0.101));
    const std::optional<Vec3> place = memory.find_resume_point(Vec3(0.101, 0, 0));
    ASSERT_EQ(place.has_value(), was_local) << "a node that has just joined begins at the device by itself";
    if (place) {
      EXPECT_NEAR(place->x(), 0.1 + MethodSettings().offset_m, 1e-15) << "the node begins farther off by its offset";
      EXPECT_NEAR(memory.find_resume_point(Vec3(0.10009, 0, 0))->x(), 0.1 + MethodSettings().offset_m, 1e-15);
      EXPECT_EQ(memory.find_resume_point(Vec3(0.100005, 0, 0)), Vec3(0.100005, 0, 0));
    }
    EXPECT_FALSE(memory.find_resume_point(Vec3(0.1 + 2 * kResumeReachM, 0, 0)));
    memory.note_reply(reply_to(2, false));
    EXPECT_FALSE(memory.find_resume_point(Vec3(0.101, 0, 0)));
  }
  memory.note_resume_request();
  memory.forget_probe_position();
  EXPECT_FALSE(memory.find_resume_point(Vec3(0.101, 0, 0))) << "the scene was turned";
}

}  // namespace
}  // namespace hapton
