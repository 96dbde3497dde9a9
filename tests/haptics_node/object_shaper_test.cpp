// Objects that programs deform, in the step of the haptics node, without its loop and a hub.
#include "haptics_node/object_shaper.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "link/known_shapes.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

using ShaperDisplacements = std::vector<ShapePart::Displacement>;

const Vec3 kHandOverSheet(0.0061, 0.0043, 0.002);
constexpr std::int64_t kSampleNs = 1'000'000;

Scene sheet_scene() {
  Scene scene;
  SceneObject sheet;
  sheet.name = "sheet";
  sheet.mesh = made::shared(made::sheet(0.03, 0.0, 12));  // 169 vertices: three parts
  sheet.program_shape = std::make_shared<const ProgramShape>(ProgramShape{.reach_m = 0.02});
  scene.objects.push_back(sheet);
  SceneObject other = sheet;
  other.name = "other";
  other.mesh = made::shared(made::sheet(0.03, -0.1, 4));
  scene.objects.push_back(other);
  return scene;
}

class ObjectShaperTest : public testing::Test {
 protected:
  ForceCommand cycle(const Vec3& hand = kHandOverSheet) {
    now_ns_ += kSampleNs;
    step_.offer({.sample = ++sample_, .sample_time_ns = now_ns_, .p_WD = hand});
    force_ = step_.reply();
    for (int n = 0; n < 4; ++n) {
      const auto message = shaper_.take_due(step_, now_ns_);
      if (!message) break;
      parts_ += std::holds_alternative<ObjectShape>(*message) ? 1 : 0;
      if (const auto* reply = std::get_if<ShapeReply>(&*message)) replies_.push_back(*reply);
      if (const auto* part = std::get_if<ObjectShape>(&*message)) known_.take(*part, Arrival::newest);
      if (const auto* start = std::get_if<ShapeStart>(&*message)) {
        starts_.push_back(*start);
        known_.take(*start, Arrival::newest);
      }
    }
    while (shaper_.work()) {
    }
    return force_;
  }
  static ShaperDisplacements raised(std::size_t count, double height_m) { return {count, {0.0F, 0.0F, static_cast<float>(height_m)}}; }
  // The parts of a shape, as they come from a program.
  void send_shape(std::int32_t object, std::uint32_t shape, const ShaperDisplacements& displacements, double over_s = 0.0) {
    ShapeRequest request{.stream = 7, .shape = shape, .number = object, .over_s = over_s};
    for (std::uint32_t first = 0; first < displacements.size(); first += ShapePart::kVerticesPerPart) {
      request.part = make_shape_part(displacements, first);
      shaper_.accept(request, now_ns_);
    }
  }
  double announced_height() const {
    const auto place = known_.find(0, force_.scene_time_ns);
    return place ? static_cast<double>(known_.displacements_m(0, *place)[0][2]) : -1.0;
  }

  Scene scene_ = sheet_scene();
  HapticsStep step_{std::make_unique<TouchStep>(*make_method({}, scene_.touch_scene()), scene_.touch_scene()), 1e-5};
  ObjectShaper shaper_{scene_, step_.touch(), 42};
  KnownShapes known_{{169, 25}};
  std::vector<ShapeReply> replies_;
  std::vector<ShapeStart> starts_;
  int parts_ = 0;
  ForceCommand force_;
  std::int64_t now_ns_ = 0;
  std::uint64_t sample_ = 0;
};

TEST_F(ObjectShaperTest, ForcesAndTheAnnouncedShapesAgree) {
  ASSERT_EQ(shaper_.count(), 2U);
  double previous_force_n = 0.0;
  double largest_force_n = 0.0;
  std::uint32_t shape = 0;
  for (int n = 0; n < 2000; ++n) {
    if (n % 33 == 0) {
      ++shape;
      send_shape(0, shape, raised(169, shape % 3 == 0 ? -0.003 : 0.002 * (shape % 4)), 0.033);
    }
    cycle();
    ASSERT_NEAR(force_.force_n.z(), 1000.0 * std::max(0.0, announced_height() - kHandOverSheet.z()), 2e-3) << n;
    ASSERT_LE(std::abs(force_.force_n.z() - previous_force_n), 1000.0 * 0.25 * 1.01e-3) << n;
    previous_force_n = force_.force_n.z();
    largest_force_n = std::max(largest_force_n, previous_force_n);
  }
  EXPECT_GT(largest_force_n, 3.0);
  EXPECT_GT(force_.shape_serial, 40U);
  EXPECT_EQ(shaper_.counts().rejected, 0U);
}

// A program that sends as fast as it can: some shapes are left out, and the surface moves from one to the next without a stop.
TEST_F(ObjectShaperTest, AFastProgramDoesNotMakeTheSurfaceStop) {
  std::uint32_t shape = 0;
  for (int n = 0; n < 1000; ++n) {
    ++shape;
    send_shape(0, shape, raised(169, 0.01 * std::sin(0.01 * n)), 0.03);
    cycle();
  }
  EXPECT_GE(starts_.size(), 25U);
  for (std::size_t s = 1; s < starts_.size(); ++s) EXPECT_EQ(starts_[s].start_ns, starts_[s - 1].end_ns) << s;
}

// While the hub computes the force, it knows of each motion a round trip ahead, and the surface does not stop. The haptics node has the
// same surface at each sample.
TEST_F(ObjectShaperTest, ShapesAreAnnouncedAheadWhileTheHubComputesTheForce) {
  constexpr std::int64_t kLeadNs = 250'000'000;
  shaper_.set_pace({.lead_ns = kLeadNs, .part_ns = 10'000'000});
  std::uint32_t shape = 0;
  std::size_t next_start = 0;
  double largest_force_n = 0.0;
  for (int n = 0; n < 3000; ++n) {
    if (n % 33 == 0) {
      ++shape;
      send_shape(0, shape, raised(169, 0.002 + 0.001 * (shape % 3)), 0.033);
    }
    cycle();
    for (; next_start < starts_.size(); ++next_start) EXPECT_GT(starts_[next_start].start_ns, force_.scene_time_ns + kLeadNs) << next_start;
    ASSERT_NEAR(force_.force_n.z(), 1000.0 * std::max(0.0, announced_height() - kHandOverSheet.z()), 2e-3) << n;
    largest_force_n = std::max(largest_force_n, force_.force_n.z());
  }
  EXPECT_GT(largest_force_n, 1.5);
  EXPECT_GT(starts_.size(), 50U);
  EXPECT_LE(parts_, 305) << "one in 10 ms, and four at once";
  for (std::size_t s = 2; s < starts_.size(); ++s) {
    EXPECT_EQ(starts_[s].start_ns, starts_[s - 1].end_ns) << "the surface does not stop: " << s;
    EXPECT_GE(starts_[s].end_ns - starts_[s].start_ns, 36'000'000) << "so that no more than eight wait";
  }
  // When the hub no longer computes the force, at most one motion waits, as usual.
  shaper_.set_pace({});
  for (int n = 0; n < 600; ++n) cycle();
  const std::size_t before = starts_.size();
  send_shape(0, ++shape, raised(169, 0.003), 0.033);
  for (int n = 0; n < 5; ++n) cycle();
  ASSERT_EQ(starts_.size(), before + 1);
  EXPECT_LT(starts_.back().start_ns, force_.scene_time_ns + 30'000'000);
}

// Shapes are announced as early as the hub says it needs to prepare them: 30 us per vertex or more, up to a limit.
TEST_F(ObjectShaperTest, ABusyHubKnowsOfShapesEarlier) {
  constexpr std::int64_t kLeadNs = 100'000'000;
  constexpr std::array<std::pair<std::int64_t, std::int64_t>, 5> kHubTimes = {
      // ns per vertex: as the hub reports it, and as it is granted
      {{0, 30'000}, {5'000, 30'000}, {100'000, 200'000}, {1'000'000, 240'000}, {0, 30'000}}};
  std::uint32_t shape = 0;
  for (const auto& [reported_ns, lead_ns_per_vertex] : kHubTimes) {
    shaper_.set_pace({.lead_ns = kLeadNs, .part_ns = 1'000'000, .stage_ns_per_vertex = reported_ns});
    for (int n = 0; n < 1000; ++n) cycle();
    const std::size_t before = starts_.size();
    ++shape;
    send_shape(0, shape, raised(169, 0.002 + 0.001 * (shape % 2)), 0.01);
    std::int64_t announced_at_ns = 0;
    for (int n = 0; n < 100 && starts_.size() == before; ++n) {
      cycle();
      announced_at_ns = force_.scene_time_ns;
    }
    ASSERT_EQ(starts_.size(), before + 1) << reported_ns;
    EXPECT_EQ(starts_.back().start_ns - announced_at_ns, kLeadNs + 169 * lead_ns_per_vertex + 1) << reported_ns;
    EXPECT_GE(starts_.back().end_ns - starts_.back().start_ns, 169 * lead_ns_per_vertex) << "the next one has its time, too";
  }
}

// A fifth of the parts is lost, and the hub requests what is missing: nearly all shapes are whole before they begin.
TEST_F(ObjectShaperTest, LostPartsAreSentAgainBeforeTheirShapeBegins) {
  constexpr std::int64_t kTripNs = 40'000'000;  // one way
  shaper_.set_pace({.lead_ns = 200'000'000, .part_ns = 5'000'000, .resend_ns = 120'000'000});
  KnownShapes hub({169, 25});
  std::mt19937_64 random(252);
  std::vector<std::pair<std::int64_t, Message>> in_flight;
  std::vector<ShapeStatus> requests;
  std::uint32_t shape = 0;
  int begun_shapes = 0;
  int whole_shapes = 0;
  std::size_t next_start = 0;
  for (int n = 0; n < 6000; ++n) {
    if (n % 33 == 0) {
      ++shape;
      send_shape(0, shape, raised(169, 0.002 + 0.001 * (shape % 3)), 0.033);
    }
    now_ns_ += kSampleNs;
    step_.offer({.sample = ++sample_, .sample_time_ns = now_ns_, .p_WD = kHandOverSheet});
    force_ = step_.reply();
    while (auto message = shaper_.take_due(step_, now_ns_)) {
      if (const auto* start = std::get_if<ShapeStart>(&*message)) starts_.push_back(*start);
      if (std::holds_alternative<ObjectShape>(*message) && random() % 5 == 0) continue;
      in_flight.emplace_back(now_ns_ + kTripNs, *message);
    }
    while (shaper_.work()) {
    }
    requests.clear();
    hub.take_requests_ahead(now_ns_, requests);
    for (const ShapeStatus& request : requests) in_flight.emplace_back(now_ns_ + kTripNs, request);
    std::erase_if(in_flight, [&](const auto& one) {
      if (one.first > now_ns_) return false;
      if (const auto* part = std::get_if<ObjectShape>(&one.second)) hub.take(*part, Arrival::newest);
      if (const auto* start = std::get_if<ShapeStart>(&one.second)) hub.take(*start, Arrival::newest);
      if (const auto* status = std::get_if<ShapeStatus>(&one.second)) shaper_.accept(*status, now_ns_);
      return true;
    });
    for (; next_start < starts_.size() && starts_[next_start].start_ns <= force_.scene_time_ns; ++next_start) {
      if (next_start < 20) continue;  // until the sender knows that parts get lost
      ++begun_shapes;
      const ShapeStart* const next = hub.find_next(0, starts_[next_start].serial - 1, 0);
      whole_shapes += next != nullptr && next->serial == starts_[next_start].serial ? 1 : 0;
    }
  }
  EXPECT_GT(begun_shapes, 80);
  EXPECT_GT(whole_shapes, begun_shapes * 8 / 10) << "each has three parts: if none were sent again, only half would be whole";
}

// No part is lost. The first part of the next shape comes before the last part of this one, as with jitter when a program sends without
// pause.
TEST_F(ObjectShaperTest, PartsThatOvertakeOneAnotherLeaveNoShapeOut) {
  constexpr std::uint32_t kSentShapes = 20;
  const auto send = [&](std::uint32_t shape, std::uint32_t part) {
    ShapeRequest request{.stream = 7, .shape = shape, .over_s = 0.01};
    request.part = make_shape_part(raised(169, 1e-4 * shape), part * ShapePart::kVerticesPerPart);
    shaper_.accept(request, now_ns_);
  };
  send(1, 0);
  for (std::uint32_t shape = 1; shape <= kSentShapes; ++shape) {
    send(shape, 1);
    send(shape + 1, 0);
    send(shape, 2);
    for (int n = 0; n < 40; ++n) cycle();
  }
  EXPECT_EQ(starts_.size(), kSentShapes);
  EXPECT_NEAR(announced_height(), 1e-4 * kSentShapes, 1e-9);
  EXPECT_EQ(shaper_.counts().incomplete, 0U);
  // A part that comes again, or once a newer shape is whole, changes nothing.
  send_shape(0, kSentShapes + 2, raised(169, 0.01));
  send(kSentShapes + 1, 1);
  send(kSentShapes + 1, 2);
  send(kSentShapes, 2);
  for (int n = 0; n < 100; ++n) cycle();
  EXPECT_EQ(starts_.size(), kSentShapes + 1);
  EXPECT_NEAR(announced_height(), 0.01, 1e-6);
  EXPECT_EQ(shaper_.counts().incomplete, 1U);
}

TEST_F(ObjectShaperTest, TwoObjectsMoveBesideEachOther) {
  send_shape(0, 1, raised(169, 0.005), 5.0);
  for (int n = 0; n < 20; ++n) cycle();
  send_shape(0, 2, raised(169, 0.0), 5.0);
  for (std::uint32_t shape = 3; shape < 23; ++shape) {
    send_shape(1, shape, raised(25, shape % 2 == 0 ? 0.001 : -0.001), 0.01);
    for (int n = 0; n < 20; ++n) cycle();
  }
  EXPECT_EQ(std::count_if(starts_.begin(), starts_.end(), [](const ShapeStart& one) { return one.object == 0; }), 1);
  EXPECT_EQ(std::count_if(starts_.begin(), starts_.end(), [](const ShapeStart& one) { return one.object == 1; }), 20);
  for (std::size_t s = 0; s < starts_.size(); ++s) EXPECT_EQ(starts_[s].serial, s + 1);
  EXPECT_EQ(force_.shape_serial, starts_.size());
}

TEST_F(ObjectShaperTest, ANameOfTwoObjectsIsRejected) {
  Scene alike = sheet_scene();
  alike.objects[1].name = "sheet";
  HapticsStep step(std::make_unique<TouchStep>(*make_method({}, alike.touch_scene()), alike.touch_scene()), 1e-5);
  ObjectShaper shaper(alike, step.touch(), 42);
  ShapeRequest request{.stream = 7, .shape = 1, .number = 1};
  request.object = {"sheet"};
  request.part = make_shape_part(raised(25, 0.001), 0);
  shaper.accept(request, kSampleNs);
  const auto message = shaper.take_due(step, kSampleNs);
  ASSERT_TRUE(message && std::holds_alternative<ShapeReply>(*message));
  EXPECT_STREQ(std::get<ShapeReply>(*message).rejection.data(), "several objects have that name; give the number of one");
  EXPECT_EQ(shaper.counts().rejected, 1U);
  request.object = {};
  shaper.accept(request, kSampleNs);
  EXPECT_TRUE(shaper.work()) << "its shape is whole";
  EXPECT_EQ(shaper.counts().rejected, 1U);
}

// Without a device scene time stops, and so does the surface: at most one motion waits.
TEST_F(ObjectShaperTest, WithoutSamplesNoMoreThanOneMotionWaits) {
  for (int n = 0; n < 10; ++n) cycle();
  for (std::uint32_t shape = 1; shape < 50; ++shape) {
    send_shape(0, shape, raised(169, 1e-4 * shape), 0.01);
    while (shaper_.work()) {
    }
    for (int n = 0; n < 8; ++n) {
      const auto message = shaper_.take_due(step_);
      if (message && std::holds_alternative<ShapeStart>(*message)) starts_.push_back(std::get<ShapeStart>(*message));
    }
  }
  EXPECT_EQ(starts_.size(), 1U);
  for (int n = 0; n < 100; ++n) cycle();
  EXPECT_EQ(starts_.size(), 3U) << "the one that was being sent, and the newest";
  EXPECT_EQ(replies_.back().shape, 49U);
}

TEST_F(ObjectShaperTest, TheLoopUsesNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP();
  std::uint64_t allocations = 0;
  std::uint32_t shape = 0;
  for (int n = 0; n < 300; ++n) {
    const ShaperDisplacements next = raised(169, 0.004 * std::sin(0.1 * n));
    now_ns_ += kSampleNs;
    step_.offer({.sample = ++sample_, .sample_time_ns = now_ns_, .p_WD = kHandOverSheet});
    {
      const AllocationGuard guard;
      step_.reply();
      for (int m = 0; m < 4; ++m) (void)shaper_.take_due(step_);
      if (n % 10 == 0) ++shape;
      ShapeRequest request{.stream = 7, .shape = shape, .over_s = 0.01};
      for (std::uint32_t first = 0; first < next.size(); first += ShapePart::kVerticesPerPart) {
        request.part = make_shape_part(next, first);
        shaper_.accept(request, now_ns_);
      }
      request.object = {"nothing"};
      shaper_.accept(request, now_ns_);
      shaper_.accept(ShapeStatus{.source = 42, .serial = force_.shape_serial}, now_ns_);
      shaper_.accept(ShapeStatus{.source = 42, .serial = force_.shape_serial, .count = 64}, now_ns_);
      allocations += guard.count();
    }
    while (shaper_.work()) {
    }
  }
  EXPECT_EQ(allocations, 0U);
  EXPECT_GT(step_.counts().shapes_applied, 20U);
}

}  // namespace
}  // namespace hapton
