// Replays of sessions in which programs deformed objects.
#include <gtest/gtest.h>

#include <cmath>
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
  // What came before the state of that number.
  std::vector<std::pair<std::size_t, Announced>> announced;
  ProgramShape program_shape{.reach_m = 0.02};
  std::uint32_t serial = 0;
  std::int64_t end_ns = 0;

  ShapesReplayTest() : SessionReplayTest(make_soft_touch()) {}

  // As the haptics node does it.
  void deform(double wider, double seconds) {
    StreamedMethod* method = live.touch().find_streamed(0);
    ASSERT_NE(method, nullptr);
    ASSERT_FALSE(method->has_waiting());
    const auto rest = method->stager().rest();
    Displacements shape;
    for (const Vec3& p : rest) {
      shape.push_back({static_cast<float>(wider * p.x()), static_cast<float>(0.5 * wider * p.y()), static_cast<float>(-wider * p.z())});
    }
    auto stage = method->stager().make(method->present().to, program_shape.vertices_of(rest, shape));
    ASSERT_TRUE(stage) << stage.error().what;
    ++serial;
    for (std::uint32_t first = 0; first < shape.size(); first += ShapePart::kMostHere) {
      announced.emplace_back(recorded.size(), ObjectShape{.source = 1, .serial = serial, .part = make_shape_part(shape, first)});
    }
    ShapeStart start{.source = 1, .serial = serial, .before = serial - 1, .total = static_cast<std::uint32_t>(shape.size())};
    start.start_ns = std::max(end_ns, live.scene_time_ns() + 1);
    start.end_ns = end_ns = start.start_ns + static_cast<std::int64_t>(1e9 * seconds);
    announced.emplace_back(recorded.size(), start);
    (void)live.deform(0, std::move(*stage), start.start_ns, start.end_ns);
  }
  // One shape after the other, the next one a moment before the one before ends.
  void slide_and_deform() {
    slide(60);
    for (int n = 0; n < 8; ++n) {
      deform(n % 2 == 0 ? 0.05 : -0.03 - 0.005 * n, 0.04);
      slide(n < 4 ? 35 : 60);
    }
  }
  void feed_with_shapes(SessionReplay& replay) {
    replay.use_program_shapes([this](const HapticsSetup&, std::int32_t) { return std::make_shared<const ProgramShape>(program_shape); });
    std::size_t next = 0;
    for (std::size_t n = 0; n < recorded.size(); ++n) {
      for (; next < announced.size() && announced[next].first <= n; ++next) {
        std::visit([&](const auto& message) { replay.on_shape(kSender, message); }, announced[next].second);
      }
      replay.on_state(recorded[n].first);
      ASSERT_TRUE(!recorded[n].second || replay.on_answer(kSender, *recorded[n].second));
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

// The test can fail: with a shape that differs, or starts later, the forces are others.
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
  EXPECT_EQ(replay.counts().lost_answers, lost);
  EXPECT_EQ(replay.counts().compared, recorded.size() - lost);
  EXPECT_EQ(replay.counts().different, 0U) << replay.counts().first_difference;
}

// Forces with a shape that the recording lacks, in part or wholly, are unknown, and so are those after it.
TEST_F(ShapesReplayTest, AMissingPartMakesForcesUnknownNotDifferent) {
  slide_and_deform();
  std::erase_if(announced, [](const auto& one) {
    const auto* part = std::get_if<ObjectShape>(&one.second);
    return part != nullptr && part->serial == 4 && part->part.first == 64;
  });
  SessionReplay replay = replay_with(make_soft_touch);
  feed_with_shapes(replay);
  EXPECT_EQ(replay.counts().different, 0U) << replay.counts().first_difference;
  EXPECT_EQ(replay.counts().compared, 60U + 3U * 35U);
  EXPECT_EQ(replay.counts().unknown_method, recorded.size() - replay.counts().compared);
}

TEST_F(ShapesReplayTest, ARecordingThatBeginsAfterAShapeIsUnknown) {
  slide_and_deform();
  recorded.erase(recorded.begin(), recorded.begin() + 150);
  SessionReplay replay = replay_with(make_soft_touch);
  feed_with_shapes(replay);
  EXPECT_EQ(replay.counts().compared, 0U);
  EXPECT_EQ(replay.counts().different, 0U);
}

}  // namespace
}  // namespace hapton
