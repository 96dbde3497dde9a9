#include "io_node/vision_pace.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

using Verdict = VisionPace::Verdict;
constexpr std::int64_t kMs = kNanosecondsPerMillisecond;

ProbeState state_at(std::uint64_t sample) {
  ProbeState state;
  state.sample = sample;
  state.p_WD.x() = 1e-6 * static_cast<double>(sample);
  return state;
}

TEST(VisionPaces, the_next_state_waits_for_the_last_to_be_drawn) {
  VisionPace pace(240.0);
  EXPECT_EQ(pace.judge(0, state_at(1), 0), Verdict::send);
  for (std::int64_t ms = 1; ms < 40; ++ms) EXPECT_EQ(pace.judge(0, state_at(static_cast<std::uint64_t>(ms)), ms * kMs), Verdict::wait);
  pace.on_drawn(0, Drawn{1, 0, 60.0F}, 40 * kMs);
  EXPECT_EQ(pace.judge(0, state_at(41), 40 * kMs), Verdict::send);
}

TEST(VisionPaces, what_is_lost_is_told_again) {
  VisionPace pace(240.0);
  EXPECT_EQ(pace.judge(0, state_at(1), 0), Verdict::send);
  EXPECT_EQ(pace.judge(0, state_at(2), VisionPace::kRepeatNs - 1), Verdict::wait);
  EXPECT_EQ(pace.judge(0, state_at(3), VisionPace::kRepeatNs), Verdict::send);
}

TEST(VisionPaces, a_picture_of_an_older_state_asks_for_nothing) {
  VisionPace pace(240.0);
  EXPECT_EQ(pace.judge(0, state_at(7), 0), Verdict::send);
  pace.on_drawn(0, Drawn{6, 0, 60.0F}, kMs);
  EXPECT_EQ(pace.judge(0, state_at(9), 10 * kMs), Verdict::wait);
}

TEST(VisionPaces, the_next_state_comes_fresh_when_vision_would_draw_again) {
  VisionPace pace(240.0);
  EXPECT_EQ(pace.judge(0, state_at(1), 0), Verdict::send);
  Drawn drawn{1, 0, 60.0F};
  drawn.rest_ns = 12 * kMs;
  pace.on_drawn(0, drawn, 5 * kMs);
  EXPECT_EQ(pace.judge(0, state_at(2), 17 * kMs - 1), Verdict::wait);
  EXPECT_EQ(pace.judge(0, state_at(3), 17 * kMs), Verdict::send);
}

TEST(VisionPaces, a_rest_beyond_the_repeat_is_not_believed) {
  VisionPace pace(240.0);
  EXPECT_EQ(pace.judge(0, state_at(1), 0), Verdict::send);
  Drawn drawn{1, 0, 60.0F};
  drawn.rest_ns = 4'000'000'000;
  pace.on_drawn(0, drawn, kMs);
  EXPECT_EQ(pace.judge(0, state_at(2), kMs + VisionPace::kRepeatNs), Verdict::send);
}

TEST(VisionPaces, motion_too_small_to_see_costs_a_state_a_frame) {
  VisionPace pace(240.0);
  EXPECT_EQ(pace.judge(0, state_at(1), 0), Verdict::send);
  Drawn same{1, 0, 60.0F};
  same.unchanged = true;
  pace.on_drawn(0, same, kMs);
  EXPECT_EQ(pace.judge(0, state_at(2), kMs + VisionPace::kUnseenNs - 1), Verdict::wait);
  EXPECT_EQ(pace.judge(0, state_at(3), kMs + VisionPace::kUnseenNs), Verdict::send);
}

TEST(VisionPaces, what_has_not_changed_is_spared) {
  VisionPace pace(240.0);
  EXPECT_EQ(pace.judge(0, state_at(1), 0), Verdict::send);
  pace.on_drawn(0, Drawn{1, 0, 60.0F}, 5 * kMs);
  ProbeState later = state_at(1);
  later.sample = 11;
  EXPECT_EQ(pace.judge(0, later, 10 * kMs), Verdict::spare);
  EXPECT_EQ(pace.judge(0, later, VisionPace::kRepeatNs), Verdict::send);
}

TEST(VisionPaces, each_node_has_its_own_pace_and_a_new_one_is_told_at_once) {
  VisionPace pace(240.0);
  EXPECT_EQ(pace.judge(0, state_at(1), 0), Verdict::send);
  EXPECT_EQ(pace.judge(1, state_at(1), 0), Verdict::send);
  pace.on_drawn(1, Drawn{1, 0, 60.0F}, 5 * kMs);
  EXPECT_EQ(pace.judge(0, state_at(2), 6 * kMs), Verdict::wait);
  EXPECT_EQ(pace.judge(1, state_at(2), 6 * kMs), Verdict::send);
  pace.on_joined(0);
  EXPECT_EQ(pace.judge(0, state_at(3), 7 * kMs), Verdict::send);
}

TEST(VisionPaces, rate_0_tells_nothing) {
  VisionPace pace(0.0);
  EXPECT_EQ(pace.judge(0, state_at(1), 0), Verdict::wait);
}

}  // namespace
}  // namespace hapton
