#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "core/geometry/mesh_shapes.h"
#include "haptic_step/haptics_step.h"
#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

constexpr double kCarvingOffset = 0.0005 * 0.0254;  // contact offset: half a thousandth of an inch

TouchScene carving_scene() {
  return {.objects = {{.mesh = std::make_shared<const TriangleMesh>(make_icosphere(0.03, 3)),
                       .material = {.stiffness_n_per_m = 500.0},
                       .sculpt = SculptSettings{.voxel_m = 0.001, .tool_radius_m = 0.004, .button = 1}}}};
}

std::unique_ptr<TouchStep> carving_touch(const char* method = "proxy") {
  const TouchScene scene = carving_scene();
  return std::make_unique<TouchStep>(std::shared_ptr<ForceMethod>(*make_method({.name = method}, scene)), scene);
}

// The device goes round the ball, in and out of its surface, with the button down after sample 200.
DeviceState carving_state(std::uint64_t sample) {
  const double angle = 3e-3 * static_cast<double>(sample);
  const Vec3 p = (0.0315 + 0.004 * std::cos(5.0 * angle)) * Vec3(std::cos(angle), std::sin(angle), 0.1);
  return {.sample = sample, .sample_time_ns = 1'000'000 * static_cast<std::int64_t>(sample), .p_WD = p, .buttons = sample > 200 ? 1U : 0U};
}

struct CarvedRun {
  std::vector<ForceCommand> forces;
  std::vector<MadeCarve> carves;
};

// The method is replaced at sample `change`; 0: never.
CarvedRun carve_around_ball(std::uint64_t count, std::uint64_t change) {
  HapticsStep step(carving_touch(), kCarvingOffset);
  CarvedRun run;
  for (std::uint64_t sample = 1; sample <= count; ++sample) {
    if (sample == change) {
      auto next = carving_touch("reference");
      step.replace(std::move(next));
      EXPECT_EQ(step.made_carve(), nullptr) << "a change is not a sample";
    }
    step.offer(carving_state(sample));
    run.forces.push_back(step.reply());
    if (const MadeCarve* made = step.made_carve()) run.carves.push_back(*made);
  }
  return run;
}

TEST(CarvingStep, RepeatsToTheLastBitAlsoAcrossAChangeOfMethod) {
  for (const std::uint64_t change : {std::uint64_t{0}, std::uint64_t{700}}) {
    const CarvedRun one = carve_around_ball(1500, change), other = carve_around_ball(1500, change);
    ASSERT_EQ(one.carves.size(), other.carves.size());
    EXPECT_GT(one.carves.size(), 50U);
    for (std::size_t i = 0; i < one.carves.size(); ++i) {
      EXPECT_EQ(one.carves[i].carve, other.carves[i].carve);
      EXPECT_EQ(one.carves[i].serial, i + 1) << "counted on across the change";
    }
    for (std::size_t i = 0; i < one.forces.size(); ++i) {
      ASSERT_EQ(one.forces[i].force_n, other.forces[i].force_n) << i;
      ASSERT_EQ(one.forces[i].visual_offset_m, other.forces[i].visual_offset_m) << i;
    }
  }
}

TEST(CarvingStep, ForceHasNoJumpAtAChangeOfMethod) {
  const CarvedRun run = carve_around_ball(1500, 700);
  // forces[699] replies to sample 700, the first with the new method.
  EXPECT_TRUE(run.forces[698].contact);
  EXPECT_TRUE(run.forces[699].contact);
  EXPECT_LT((run.forces[699].force_n - run.forces[698].force_n).norm(), 0.5);
}

// A settling step before the first sample of a session would make a carve that no recording contains.
TEST(CarvingStep, EachCarveOfASessionThatGoesOnInContactIsReported) {
  HapticsStep step(carving_touch(), kCarvingOffset);
  int in_contact = 0;
  for (std::uint64_t sample = 1; sample <= 1500; ++sample) {
    if (sample > 300 && sample % 50 == 0) {
      in_contact += step.has_contact() ? 1 : 0;
      step.resume();
    }
    const std::uint32_t before = step.touch().newest_carve_serial();
    step.offer(carving_state(sample));
    step.reply();
    const std::uint32_t made = step.touch().newest_carve_serial() - before;
    ASSERT_LE(made, 1U) << sample;
    ASSERT_EQ(step.made_carve() != nullptr, made == 1U) << sample;
  }
  EXPECT_GT(in_contact, 5);
}

TEST(CarvingStep, ChangesWithoutHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP();
  HapticsStep step(carving_touch(), kCarvingOffset);
  auto next = carving_touch();
  std::unique_ptr<TouchStep> old;
  const AllocationGuard guard;
  for (std::uint64_t sample = 1; sample <= 600; ++sample) {
    if (sample == 400) old = step.replace(std::move(next));
    step.offer(carving_state(sample));
    step.reply();
  }
  EXPECT_EQ(guard.count(), 0U);
}

// A hand rests on the bottom of its carves, and all but the first 19, or all, are undone: the force fades, and the undo gets a serial.
TEST(CarvingStep, AnUndoFadesTheForce) {
  constexpr std::uint64_t kRestSample = 1047, kUndoSample = 1200;  // the hand is deep in the ball, and stays there without the button
  for (const bool is_all : {true, false}) {
    HapticsStep step(carving_touch(), kCarvingOffset);
    Sculpture copy = *step.touch().method().sculpture();
    std::vector<ForceCommand> forces;
    for (std::uint64_t sample = 1; sample <= 1400; ++sample) {
      DeviceState state = carving_state(sample);
      if (sample > kRestSample) state = {.sample = sample, .p_WD = carving_state(kRestSample).p_WD};
      state.sample_time_ns = 1'000'000 * static_cast<std::int64_t>(sample);
      step.offer(state);
      forces.push_back(step.reply());
      const MadeCarve* made = step.made_carve();
      if (made != nullptr && (!is_all && made->serial < 20)) copy.field(0).carve(made->carve);
      if (sample != kUndoSample) continue;
      const std::uint32_t newest = step.touch().newest_carve_serial();
      ASSERT_TRUE(step.restore_carves(copy, newest + 1));
      EXPECT_EQ(step.touch().newest_carve_serial(), newest + 1);
    }
    ASSERT_GT(forces[kUndoSample - 1].force_n.norm(), 0.2);
    const double largest_step_n = 1.01 * forces[kUndoSample - 1].force_n.norm() / 10.0;  // ForceFade::kInAirS in samples of 1 ms
    for (std::size_t n = kUndoSample - 10; n + 1 < forces.size(); ++n) {
      ASSERT_LE((forces[n + 1].force_n - forces[n].force_n).norm(), largest_step_n) << n << " " << is_all;
    }
    EXPECT_LT(forces.back().force_n.norm(), 1e-9) << "the hand is inside";
    EXPECT_EQ(forces[kUndoSample].carve_serial, forces[kUndoSample - 1].carve_serial + 1);
  }
}

}  // namespace
}  // namespace hapton
