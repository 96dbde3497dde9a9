#include "scene/keyframe_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace hapton {
namespace {

using ::testing::HasSubstr;

Result<MotionSpec> read_motion_text(const std::string& text) {
  const toml::parse_result parsed = toml::parse(text);
  EXPECT_TRUE(parsed);
  return read_motion(parsed.table(), "[[object]] 1");
}

std::string motion_error(const std::string& text) {
  const auto motion = read_motion_text(text);
  return motion ? "it was read" : motion.error().what;
}

TEST(KeyframeReader, ReadsEveryKey) {
  const auto motion = read_motion_text(R"(
loop = true
pivot_m = [0.1, 0.2, 0.3]
[[keyframe]]
time_s = 0.5
[[keyframe]]
time_s = 2
position_m = [1, 2, 3]
rotation_deg = [0, 0, 90]
[[keyframe]]
time_s = 3
rotation = [0, 1, 0, 0]
)");
  ASSERT_TRUE(motion) << motion.error().what;
  EXPECT_TRUE(motion->loops);
  EXPECT_EQ(motion->p_MP, Vec3(0.1, 0.2, 0.3));
  ASSERT_EQ(motion->keyframes.size(), 3U);
  EXPECT_EQ(motion->keyframes[0].time_s, 0.5);
  EXPECT_FALSE(motion->keyframes[0].p_SM || motion->keyframes[0].q_SM) << "as at rest";
  EXPECT_EQ(motion->keyframes[0].line, 4U);
  EXPECT_EQ(motion->keyframes[1].p_SM, Vec3(1, 2, 3));
  EXPECT_LT((*motion->keyframes[1].q_SM * Vec3::UnitX() - Vec3::UnitY()).norm(), 1e-15);
  EXPECT_FALSE(motion->keyframes[2].p_SM);
  EXPECT_EQ(motion->keyframes[2].q_SM->x(), 1.0);
}

TEST(KeyframeReader, WithoutKeyframesThereIsNoMotion) {
  const auto motion = read_motion_text("name = 'a'");
  ASSERT_TRUE(motion);
  EXPECT_FALSE(motion->any());
}

TEST(KeyframeReader, ReadsAnAnimation) {
  const auto motion = read_motion_text("animation = 'walk'\nanimation_speed = 0.5\nloop = true");
  ASSERT_TRUE(motion) << motion.error().what;
  EXPECT_TRUE(motion->any() && motion->loops);
  EXPECT_EQ(motion->animation, "walk");
  EXPECT_EQ(motion->animation_speed, 0.5);
  EXPECT_EQ(motion->line(), 1U);
}

TEST(KeyframeReader, RejectsWhatIsNoMotionWithItsLine) {
  const std::string two = "[[keyframe]]\ntime_s = 0\n[[keyframe]]\n";
  EXPECT_THAT(motion_error("keyframe = 3"), HasSubstr("line 1: 'keyframe' in [[object]] 1 must be tables"));
  EXPECT_THAT(motion_error("[[keyframe]]\ntime_s = 0"), HasSubstr("needs two or more"));
  EXPECT_THAT(motion_error(two + "time_s = 0"), HasSubstr("line 3: keyframe 2 of [[object]] 1 is at 0 s, the one before at 0 s"));
  EXPECT_THAT(motion_error(two + "time_s = 1\n[[keyframe]]\ntime_s = 0.5"),
              HasSubstr("line 5: keyframe 3 of [[object]] 1 is at 0.5 s, the one before at 1 s"));
  EXPECT_THAT(motion_error(two + "position_m = [0, 0, 0]"), HasSubstr("keyframe 2 of [[object]] 1 has no 'time_s'"));
  EXPECT_THAT(motion_error(two + "time_s = -1"), HasSubstr("at least 0"));
  EXPECT_THAT(motion_error(two + "time_s = 1\nposition = [0, 0, 0]"), HasSubstr("line 5: unknown key 'position' in keyframe 2"));
  EXPECT_THAT(motion_error(two + "time_s = 1\nrotation = [2, 0, 0, 0]"), HasSubstr("line 5: "));
  EXPECT_THAT(motion_error("loop = true"), HasSubstr("line 1: 'loop' in [[object]] 1 goes with keyframes"));
  EXPECT_THAT(motion_error("pivot_m = [0, 0, 0]"), HasSubstr("'pivot_m' in [[object]] 1 goes with keyframes"));
  EXPECT_THAT(motion_error("loop = 1"), HasSubstr("true or false"));
  EXPECT_THAT(motion_error("animation = 'a'\n" + two + "time_s = 1"),
              HasSubstr("line 1: [[object]] 1 has an animation and keyframes: keep one"));
  EXPECT_THAT(motion_error("animation = ''"), HasSubstr("is empty"));
  EXPECT_THAT(motion_error("animation_speed = 2"), HasSubstr("goes with 'animation'"));
  EXPECT_THAT(motion_error("animation = 'a'\nanimation_speed = 0"), HasSubstr("at least 1e-06"));
}

}  // namespace
}  // namespace hapton
