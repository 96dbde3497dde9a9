#include "io_node/vision_pace.h"

#include <gtest/gtest.h>

#include <iterator>

#include "tests/support/time_units.h"

namespace hapton {
namespace {

using Decision = VisionPace::Decision;

ProbeState state_at(std::uint64_t sample) {
  ProbeState state;
  state.sample = sample;
  state.p_WD.x() = 1e-6 * static_cast<double>(sample);
  return state;
}

TEST(VisionPaces, TheNextStateWaitsForTheLastToBeDrawn) {
  VisionPace pace(240.0);
  EXPECT_EQ(pace.decide(0, state_at(1), 0), Decision::send);
  for (std::int64_t ms = 1; ms < 40; ++ms) EXPECT_EQ(pace.decide(0, state_at(static_cast<std::uint64_t>(ms)), ms * kMs), Decision::wait);
  pace.on_frame_ack(0, FrameAck{1, 0, 60.0F}, 40 * kMs);
  EXPECT_EQ(pace.decide(0, state_at(41), 40 * kMs), Decision::send);
}

TEST(VisionPaces, ALostStateIsSentAgain) {
  VisionPace pace(240.0);
  EXPECT_EQ(pace.decide(0, state_at(1), 0), Decision::send);
  EXPECT_EQ(pace.decide(0, state_at(2), VisionPace::kRepeatNs - 1), Decision::wait);
  EXPECT_EQ(pace.decide(0, state_at(3), VisionPace::kRepeatNs), Decision::send);
}

// Only the number of the sample changes.
TEST(VisionPaces, ANodeThatPassesStatesOnGetsEverySample) {
  VisionPace pace(2000.0);
  for (const bool wants_every_sample : {true, false}) {
    EXPECT_EQ(pace.decide(0, ProbeState{.sample = 1}, 0), Decision::send);
    pace.on_frame_ack(0, FrameAck{.echo_sample = 1, .every_sample = wants_every_sample}, kMs / 4);
    int sent = 0;
    for (std::int64_t ms = 1; ms < 50; ++ms) {
      ProbeState same{.sample = static_cast<std::uint64_t>(ms) + 1};
      if (pace.decide(0, same, ms * kMs) != Decision::send) continue;
      ++sent;
      pace.on_frame_ack(0, FrameAck{.echo_sample = same.sample, .every_sample = wants_every_sample}, ms * kMs + kMs / 4);
    }
    EXPECT_EQ(sent, wants_every_sample ? 49 : 0);
    pace.on_joined(0);
  }
}

TEST(VisionPaces, EverySampleIsNoMoreThanTheRate) {
  VisionPace pace(100.0);
  EXPECT_EQ(pace.decide(0, ProbeState{.sample = 1}, 0), Decision::send);
  int sent = 0;
  for (std::int64_t ms = 1; ms <= 1000; ++ms) {
    pace.on_frame_ack(0, FrameAck{.echo_sample = static_cast<std::uint64_t>(ms), .every_sample = true}, ms * kMs);
    if (pace.decide(0, ProbeState{.sample = static_cast<std::uint64_t>(ms) + 1}, ms * kMs) == Decision::send) ++sent;
  }
  EXPECT_EQ(sent, 100);
}

TEST(VisionPaces, AFrameOfAnOlderStateRequestsNothing) {
  VisionPace pace(240.0);
  EXPECT_EQ(pace.decide(0, state_at(7), 0), Decision::send);
  pace.on_frame_ack(0, FrameAck{6, 0, 60.0F}, kMs);
  EXPECT_EQ(pace.decide(0, state_at(9), 10 * kMs), Decision::wait);
}

TEST(VisionPaces, TheNextStateComesFreshWhenVisionWouldDrawAgain) {
  VisionPace pace(240.0);
  EXPECT_EQ(pace.decide(0, state_at(1), 0), Decision::send);
  FrameAck drawn{1, 0, 60.0F};
  drawn.rest_ns = 12 * kMs;
  pace.on_frame_ack(0, drawn, 5 * kMs);
  EXPECT_EQ(pace.decide(0, state_at(2), 17 * kMs - 1), Decision::wait);
  EXPECT_EQ(pace.decide(0, state_at(3), 17 * kMs), Decision::send);
}

TEST(VisionPaces, APauseBeyondTheRepeatIsLimited) {
  VisionPace pace(240.0);
  EXPECT_EQ(pace.decide(0, state_at(1), 0), Decision::send);
  FrameAck drawn{1, 0, 60.0F};
  drawn.rest_ns = 4'000'000'000;
  pace.on_frame_ack(0, drawn, kMs);
  EXPECT_EQ(pace.decide(0, state_at(2), kMs + VisionPace::kRepeatNs), Decision::send);
}

TEST(VisionPaces, InvisibleMotionSendsOneStatePerFrame) {
  VisionPace pace(240.0);
  EXPECT_EQ(pace.decide(0, state_at(1), 0), Decision::send);
  FrameAck same{1, 0, 60.0F};
  same.unchanged = true;
  pace.on_frame_ack(0, same, kMs);
  EXPECT_EQ(pace.decide(0, state_at(2), kMs + VisionPace::kUnchangedPauseNs - 1), Decision::wait);
  EXPECT_EQ(pace.decide(0, state_at(3), kMs + VisionPace::kUnchangedPauseNs), Decision::send);
}

// While the hand rests, a node that draws all the time repeats its acknowledgement. That must not delay the state when the hand moves.
TEST(VisionPaces, ARepeatedAcknowledgementDelaysNothing) {
  VisionPace pace(240.0);
  EXPECT_EQ(pace.decide(0, state_at(1), 0), Decision::send);
  pace.on_frame_ack(0, FrameAck{1, 0, 60.0F}, 5 * kMs);
  ProbeState resting = state_at(1);
  resting.sample = 9;
  EXPECT_EQ(pace.decide(0, resting, 20 * kMs), Decision::skip);
  pace.on_frame_ack(0, FrameAck{.echo_sample = 1, .rest_ns = 12 * kMs, .unchanged = true}, 38 * kMs);
  EXPECT_EQ(pace.decide(0, state_at(40), 40 * kMs), Decision::send);
}

// The repeated acknowledgement counts if the first one was lost.
TEST(VisionPaces, ARepeatedAcknowledgementCountsWhereTheFirstWasLost) {
  VisionPace pace(240.0);
  EXPECT_EQ(pace.decide(0, state_at(1), 0), Decision::send);
  EXPECT_EQ(pace.decide(0, state_at(30), 37 * kMs), Decision::wait);
  pace.on_frame_ack(0, FrameAck{.echo_sample = 1, .unchanged = true}, 38 * kMs);
  EXPECT_EQ(pace.decide(0, state_at(54), 38 * kMs + VisionPace::kUnchangedPauseNs), Decision::send);
}

TEST(VisionPaces, AnUnchangedStateIsNotSent) {
  VisionPace pace(240.0);
  EXPECT_EQ(pace.decide(0, state_at(1), 0), Decision::send);
  pace.on_frame_ack(0, FrameAck{1, 0, 60.0F}, 5 * kMs);
  ProbeState later = state_at(1);
  later.sample = 11;
  EXPECT_EQ(pace.decide(0, later, 10 * kMs), Decision::skip);
  EXPECT_EQ(pace.decide(0, later, VisionPace::kRepeatNs), Decision::send);
}

TEST(VisionPaces, WhateverAPersonSeesIsSentWhenItChanges) {
  using Change = void (*)(ProbeState&);
  const Change changes[] = {[](ProbeState& state) { state.p_WD.y() = 0.001; },
                            [](ProbeState& state) { state.q_WT = Quat(0.0, 1.0, 0.0, 0.0); },
                            [](ProbeState& state) { state.visual_offset_m.z() = 0.001; },
                            [](ProbeState& state) { state.force_n.z() = 0.5; },
                            [](ProbeState& state) { state.contact = true; },
                            [](ProbeState& state) { state.buttons = 2; },
                            [](ProbeState& state) { state.servo_rate_hz = 999.0F; },
                            [](ProbeState& state) { state.round_trip_p50_us = 80.0F; },
                            [](ProbeState& state) { state.round_trip_p99_us = 90.0F; },
                            [](ProbeState& state) { state.view_revision = 3; },
                            [](ProbeState& state) { state.status = ProbeStatus::no_haptics; },
                            [](ProbeState& state) { state.energy_percent = 12; },
                            [](ProbeState& state) { state.object = 4; },
                            [](ProbeState& state) { state.torque_nm.x() = 0.01; },
                            [](ProbeState& state) { state.visual_turn.y() = 0.02; },
                            [](ProbeState& state) { state.haptons = 7U; }};
  for (std::size_t n = 0; n < std::size(changes); ++n) {
    VisionPace pace(240.0);
    EXPECT_EQ(pace.decide(0, state_at(1), 0), Decision::send);
    pace.on_frame_ack(0, FrameAck{1, 0, 60.0F}, 5 * kMs);
    ProbeState changed = state_at(1);
    changed.sample = 11;
    changes[n](changed);
    EXPECT_EQ(pace.decide(0, changed, 10 * kMs), Decision::send) << n;
  }
}

// The hand holds still, and the scene moves.
TEST(VisionPaces, ASceneThatMovesIsSent) {
  VisionPace pace(240.0);
  EXPECT_EQ(pace.decide(0, ProbeState{.sample = 1, .scene_time_ns = 1}, 0), Decision::send);
  pace.on_frame_ack(0, FrameAck{1, 0, 60.0F}, 10 * kMs);
  EXPECT_EQ(pace.decide(0, ProbeState{.sample = 2, .scene_time_ns = 2}, 20 * kMs), Decision::send);
  pace.on_frame_ack(0, FrameAck{2, 0, 60.0F}, 30 * kMs);
  EXPECT_NE(pace.decide(0, ProbeState{.sample = 3, .scene_time_ns = 2}, 40 * kMs), Decision::send);
}

TEST(VisionPaces, EachNodeHasItsOwnPaceAndANewOneIsServedAtOnce) {
  VisionPace pace(240.0);
  EXPECT_EQ(pace.decide(0, state_at(1), 0), Decision::send);
  EXPECT_EQ(pace.decide(1, state_at(1), 0), Decision::send);
  pace.on_frame_ack(1, FrameAck{1, 0, 60.0F}, 5 * kMs);
  EXPECT_EQ(pace.decide(0, state_at(2), 6 * kMs), Decision::wait);
  EXPECT_EQ(pace.decide(1, state_at(2), 6 * kMs), Decision::send);
  pace.on_joined(0);
  EXPECT_EQ(pace.decide(0, state_at(3), 7 * kMs), Decision::send);
}

// A vision node draws a stroke with a point from each state, however slowly it draws pictures.
TEST(VisionPaces, WhileAButtonIsDownStatesDoNotWaitForFrames) {
  VisionPace pace(200.0);
  const auto state_with_buttons = [](std::int64_t ms, std::uint32_t buttons) {
    ProbeState state = state_at(static_cast<std::uint64_t>(ms));
    state.buttons = buttons;
    return state;
  };
  EXPECT_EQ(pace.decide(0, state_with_buttons(1, 0), kMs), Decision::send);
  EXPECT_EQ(pace.decide(0, state_with_buttons(6, 0), 6 * kMs), Decision::wait);
  int sent = 0;
  for (std::int64_t ms = 10; ms < 110; ++ms) {
    sent += pace.decide(0, state_with_buttons(ms, 2), ms * kMs) == Decision::send ? 1 : 0;
    // This acknowledges a slow picture that looks the same as before: it does not delay the next state.
    if (ms == 50) pace.on_frame_ack(0, FrameAck{.echo_sample = 50, .rest_ns = 30 * kMs, .unchanged = true}, ms * kMs);
  }
  EXPECT_NEAR(sent, 20, 1) << "one every 5 ms";
  EXPECT_EQ(pace.decide(0, state_with_buttons(115, 0), 115 * kMs), Decision::wait) << "released: as before";
  pace.on_frame_ack(0, FrameAck{.echo_sample = 105}, 116 * kMs);
  EXPECT_EQ(pace.decide(0, state_with_buttons(117, 0), 117 * kMs), Decision::send);
}

TEST(VisionPaces, ADeadMansSwitchIsNoPress) {
  VisionPace pace(200.0, 4);
  ProbeState state = state_at(1);
  state.buttons = 4;
  EXPECT_EQ(pace.decide(0, state, kMs), Decision::send);
  state.sample = 2;
  EXPECT_EQ(pace.decide(0, state, 20 * kMs), Decision::wait);
  state.buttons = 5;
  EXPECT_EQ(pace.decide(0, state, 21 * kMs), Decision::send);
}

TEST(VisionPaces, Rate0SendsNothing) {
  VisionPace pace(0.0);
  EXPECT_EQ(pace.decide(0, state_at(1), 0), Decision::wait);
}

// In ns, the period of this rate does not fit into 64 bits.
TEST(VisionPaces, AtARateOfNearlyNothingOnlyTheFirstStateIsSent) {
  VisionPace pace(1e-308);
  EXPECT_EQ(pace.decide(0, state_at(1), kMs), Decision::send);
  pace.on_frame_ack(0, FrameAck{1, 0, 60.0F}, 2 * kMs);
  for (std::int64_t hour = 1; hour < 10'000; ++hour) {
    ASSERT_EQ(pace.decide(0, state_at(static_cast<std::uint64_t>(hour) + 1), hour * 3'600'000 * kMs), Decision::wait);
  }
}

}  // namespace
}  // namespace hapton
