// Replays of sessions in which programs deformed objects.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <variant>
#include <vector>

#include "core/force/streamed_method.h"
#include "tests/tools/session/session_replay_fixture.h"

namespace hapton {
namespace {

using Displacements = std::vector<ShapePart::Displacement>;

TouchScene soft_sphere() {
  TouchScene scene = one_sphere();
  scene.objects[0].stream_reach_m = 0.02;
  return scene;
}
std::unique_ptr<TouchStep> make_soft_touch() {
  return std::make_unique<TouchStep>(*make_method({.name = "proxy"}, soft_sphere()), soft_sphere());
}

struct ShapesReplayTest : SessionReplayTest {
  using Announced = std::variant<ObjectShape, ShapeStart>;
  // What the node announced before the state that has this index in `recorded`.
  std::vector<std::pair<std::size_t, Announced>> announced;
  ProgramShape program_shape{.reach_m = 0.02};
  std::uint32_t serial = 0;
  std::int64_t motion_end_ns = 0;

  ShapesReplayTest() : SessionReplayTest(make_soft_touch()) {}

  // Deforms the object as the haptics node does.
  void deform(double widening, double seconds) {
    StreamedMethod* method = live.touch().find_streamed(0);
    ASSERT_NE(method, nullptr);
    ASSERT_EQ(method->waiting(), 0U);
    const auto rest = method->stager().rest();
    Displacements shape;
    for (const Vec3& p : rest) {
      shape.push_back(
          {static_cast<float>(widening * p.x()), static_cast<float>(0.5 * widening * p.y()), static_cast<float>(-widening * p.z())});
    }
    auto stage = method->stager().make(method->current_stage().to, program_shape.vertices_of(rest, shape));
    ASSERT_TRUE(stage) << stage.error().what;
    ++serial;
    for (std::uint32_t first = 0; first < shape.size(); first += ShapePart::kVerticesPerPart) {
      announced.emplace_back(recorded.size(), ObjectShape{.source = 1, .serial = serial, .part = make_shape_part(shape, first)});
    }
    ShapeStart start{.source = 1, .serial = serial, .before = serial - 1, .total = static_cast<std::uint32_t>(shape.size())};
    start.start_ns = std::max(motion_end_ns, live.scene_time_ns() + 1);
    start.end_ns = motion_end_ns = start.start_ns + static_cast<std::int64_t>(1e9 * seconds);
    announced.emplace_back(recorded.size(), start);
    (void)live.deform(0, std::move(*stage), start.start_ns, start.end_ns);
  }
  // Eight shapes, each for 40 ms: the first four motions are replaced 5 ms before they end, the others end before the next one.
  void slide_and_deform() {
    slide(60);
    for (int n = 0; n < 8; ++n) {
      deform(n % 2 == 0 ? 0.05 : -0.03 - 0.005 * n, 0.04);
      slide(n < 4 ? 35 : 60);
    }
  }
  void feed_with_shapes(SessionReplay& replay, const FirstShapes& first = {}) {
    replay.use_program_shapes([this](const HapticsSetup&, std::int32_t) { return std::make_shared<const ProgramShape>(program_shape); },
                              first);
    std::size_t next = 0;
    for (std::size_t n = 0; n < recorded.size(); ++n) {
      for (; next < announced.size() && announced[next].first <= n; ++next) {
        std::visit([&](const auto& message) { replay.on_shape(kSender, message); }, announced[next].second);
      }
      replay.on_state(recorded[n].first);
      ASSERT_TRUE(!recorded[n].second || replay.on_reply(kSender, *recorded[n].second));
    }
    ASSERT_TRUE(replay.finish());
  }
};

TEST_F(ShapesReplayTest, ShapesGiveTheSameForcesToTheLastBit) {
  slide_and_deform();
  SessionReplay replay = replay_with(make_soft_touch);
  feed_with_shapes(replay);
  EXPECT_EQ(replay.counts().compared, recorded.size());
  EXPECT_GT(replay.counts().contact_steps, 200U);
  EXPECT_EQ(replay.counts().different, 0U) << replay.counts().first_difference;
}

// This test can fail: if one shape starts 1 ms later, the forces differ.
TEST_F(ShapesReplayTest, AnotherShapeIsAnotherForce) {
  slide_and_deform();
  for (auto& [at, message] : announced) {
    if (auto* start = std::get_if<ShapeStart>(&message); start != nullptr && start->serial == 3) start->start_ns += 1'000'000;
  }
  SessionReplay replay = replay_with(make_soft_touch);
  feed_with_shapes(replay);
  EXPECT_GT(replay.counts().different, 0U);
}

TEST_F(ShapesReplayTest, RepliesThatWereLostAreRepeatedWithTheirShapes) {
  slide_and_deform();
  std::size_t lost = 0;
  for (std::size_t n = 80; n < recorded.size(); n += 23) {
    recorded[n].second.reset();
    ++lost;
  }
  SessionReplay replay = replay_with(make_soft_touch);
  feed_with_shapes(replay);
  EXPECT_EQ(replay.counts().lost_replies, lost);
  EXPECT_EQ(replay.counts().compared, recorded.size() - lost);
  EXPECT_EQ(replay.counts().different, 0U) << replay.counts().first_difference;
}

// Forces with a shape that the recording lacks, in part or wholly, are unknown, and so are those of the motion after it. Then they are
// known again, once the hand is in free space.
TEST_F(ShapesReplayTest, AMissingPartMakesForcesUnknownNotDifferent) {
  slide_and_deform();
  std::erase_if(announced, [](const auto& one) {
    const auto* part = std::get_if<ObjectShape>(&one.second);
    return part != nullptr && part->serial == 4 && part->part.first == 64;
  });
  SessionReplay replay = replay_with(make_soft_touch);
  feed_with_shapes(replay);
  EXPECT_EQ(replay.counts().different, 0U) << replay.counts().first_difference;
  std::size_t free_at = 60 + 5 * 40 + 2;  // five motions of 40 ms have ended
  while (recorded[free_at].second->contact) ++free_at;
  EXPECT_GT(replay.counts().unknown_method, 40U);
  EXPECT_EQ(replay.counts().compared, 60U + 3U * 35U + recorded.size() - free_at);
  EXPECT_EQ(replay.counts().unknown_method + replay.counts().not_compared, recorded.size() - replay.counts().compared);
}

// When the surfaces are known again, they are made anew for the method that is in use then.
TEST_F(ShapesReplayTest, AfterAMissingPartTheMethodIsStillTheNewest) {
  slide(10);
  live.replace(make_soft_touch());
  send_setup("proxy");
  slide_and_deform();
  std::erase_if(announced, [](const auto& one) {
    const auto* part = std::get_if<ObjectShape>(&one.second);
    return part != nullptr && part->serial == 4 && part->part.first == 64;
  });
  std::vector<std::uint32_t> built_method_serials;
  SessionReplay replay(setups, [&](const HapticsSetup& setup) -> Result<std::unique_ptr<TouchStep>> {
    built_method_serials.push_back(setup.method_serial);
    return make_soft_touch();
  });
  feed_with_shapes(replay);
  EXPECT_EQ(replay.counts().different, 0U) << replay.counts().first_difference;
  ASSERT_GE(built_method_serials.size(), 3U) << "the first, the one that took over, and that once more";
  EXPECT_EQ(built_method_serials.front(), 0U);
  EXPECT_EQ(std::count(built_method_serials.begin(), built_method_serials.end(), 1U),
            static_cast<std::ptrdiff_t>(built_method_serials.size()) - 1);
}

TEST_F(ShapesReplayTest, ARecordingThatBeginsAfterAShapeIsUnknown) {
  slide_and_deform();
  recorded.erase(recorded.begin(), recorded.begin() + 150);
  SessionReplay replay = replay_with(make_soft_touch);
  feed_with_shapes(replay);
  EXPECT_EQ(replay.counts().compared, 0U);
  EXPECT_EQ(replay.counts().different, 0U);
}

// A recording that begins when the haptics node has already deformed the object.
struct LateShapesReplayTest : ShapesReplayTest {
  // What the haptics node sends again, on its own and on request: such messages may come at any time.
  FirstShapes first;

  void deform_three_times() {
    slide(60);
    for (int n = 0; n < 3; ++n) {
      deform(n % 2 == 0 ? 0.05 : -0.03, 0.04);
      slide(35);
    }
  }
  // The hub is started again, and the hand is in free space.
  void begin_recording(bool with_vertices) {
    for (const auto& [at, message] : announced) {
      if (const auto* start = std::get_if<ShapeStart>(&message); start != nullptr && start->serial == serial) first.add(kSender, *start);
      const auto* part = std::get_if<ObjectShape>(&message);
      if (part != nullptr && part->serial == serial && with_vertices) first.add(kSender, *part);
    }
    recorded.clear();
    announced.clear();
    live.restart();
  }
  void record_samples(int steps, bool is_free) {
    for (int n = 0; n < steps; ++n) {
      DeviceState state = next_state();
      if (is_free) state.p_WD *= 1.3;
      recorded.emplace_back(state, reply(state));
    }
  }
  ReplayCounts replay_all() {
    SessionReplay replay = replay_with(make_soft_touch);
    for (const auto& [state, command] : recorded) first.add(kSender, *command);
    feed_with_shapes(replay, first);
    return replay.counts();
  }
};

TEST_F(LateShapesReplayTest, TheForcesAreThoseOfTheShapeThatWasThere) {
  deform_three_times();
  slide(20);
  ASSERT_GT(live.scene_time_ns(), motion_end_ns);
  begin_recording(true);
  record_samples(10, true);
  record_samples(60, false);
  deform(0.02, 0.05);
  record_samples(80, false);
  const ReplayCounts counts = replay_all();
  EXPECT_EQ(counts.compared, 150U);
  EXPECT_EQ(counts.different, 0U) << counts.first_difference;
  EXPECT_GT(counts.contact_steps, 120U);
  first = {};
  EXPECT_EQ(replay_all().compared, 0U) << "without the shape nothing is known";
}

// The shape from which the object moves was sent before the recording began.
TEST_F(LateShapesReplayTest, DuringAMotionForcesAreUnknownUntilItEnds) {
  deform_three_times();
  const std::int64_t remaining_ns = motion_end_ns - live.scene_time_ns();
  ASSERT_GT(remaining_ns, 2'000'000);
  begin_recording(true);
  record_samples(20, true);
  record_samples(60, false);
  const ReplayCounts counts = replay_all();
  EXPECT_EQ(counts.different, 0U) << counts.first_difference;
  EXPECT_NEAR(static_cast<double>(counts.unknown_method), 1e-6 * static_cast<double>(remaining_ns), 1.5);
  EXPECT_EQ(counts.compared, 80U - counts.unknown_method);
  EXPECT_GT(counts.contact_steps, 50U);
}

// A program sends one shape after the other: forces are known from the second shape in the recording on.
TEST_F(LateShapesReplayTest, InAStreamOfShapesForcesAreKnownAfterTwo) {
  deform_three_times();
  begin_recording(false);
  record_samples(8, true);
  for (int n = 0; n < 4; ++n) {
    deform(n % 2 == 0 ? -0.02 : 0.03, 0.04);
    record_samples(40, n < 3);
  }
  record_samples(40, false);
  const ReplayCounts counts = replay_all();
  EXPECT_EQ(counts.different, 0U) << counts.first_difference;
  EXPECT_EQ(counts.compared + counts.unknown_method, recorded.size());
  EXPECT_GE(counts.compared, 150U);
  EXPECT_LE(counts.compared, 170U);
  EXPECT_GT(counts.contact_steps, 50U);
}

}  // namespace
}  // namespace hapton
