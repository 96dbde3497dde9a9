#include "tools/bench/remote_recording.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "core/force/touch_step.h"
#include "link/codec.h"
#include "link/session_codec.h"
#include "tests/support/made_meshes.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

constexpr std::size_t kSamples = 2000;
constexpr double kRecordedPeriodS = 1e-3;

TouchScene recorded_ball() { return {.objects = {{made::shared(made::sphere(0.05, 24)), {}}}}; }
std::shared_ptr<ForceMethod> recorded_method() { return *make_method({}, recorded_ball()); }

// The device goes down to the ball, along its surface and off again.
Vec3 device_position(std::size_t i) {
  const double angle = 4e-4 * static_cast<double>(i);
  const double radius = i < 300 || i > 1700 ? 0.052 : 0.049;
  return radius * Vec3(std::cos(angle), std::sin(angle), 0.1);
}

std::vector<Vec3> forces_without_delay() {
  TouchStep touch(recorded_method());
  touch.reset({.p_WD = device_position(0)});
  std::vector<Vec3> forces;
  for (std::size_t i = 0; i < kSamples; ++i) forces.push_back(touch.step({.p_WD = device_position(i), .dt_s = kRecordedPeriodS}).force_n);
  return forces;
}

// A hub's recording of these forces. The hub sends every tenth sample and receives a force command for every twentieth one.
std::string recording_of(const std::vector<Vec3>& written, bool is_local, bool has_device = true, const std::vector<Vec3>& local = {}) {
  SessionCodec session;
  Codec codec;
  std::string bytes(kSessionMagic);
  session.append(SessionHeader{.build = "b"}, bytes);
  std::array<std::byte, kMaxDatagramBytes> wire;
  const auto add_datagram = [&](SessionEntry::Kind kind, const Message& message, std::int64_t time_ns) {
    const std::size_t size = codec.encode({{.session = 1, .sender = 2, .sequence = 3}, message}, wire);
    SessionEntry entry;
    entry.kind = kind;
    entry.time_ns = time_ns;
    entry.datagram = std::span(wire).first(size);
    session.append(entry, bytes);
  };
  for (std::size_t i = 0; i < kSamples; ++i) {
    const std::int64_t time_ns = 5'000'000'000 + static_cast<std::int64_t>(i) * 1'000'000;
    SessionEntry entry;
    entry.kind = SessionEntry::Kind::cycle;
    entry.time_ns = time_ns;
    entry.cycle = {.sample = i + 1, .written_n = written[i], .missed = i == 7 ? 2U : 0U};
    if (has_device) entry.cycle.device = CycleSample{.time_ns = time_ns, .p_WD = device_position(i)};
    if (is_local) entry.cycle.local = CycleLocal{.force_n = local.empty() ? written[i] : local[i]};
    session.append(entry, bytes);
    if (i % 10 == 0) add_datagram(SessionEntry::Kind::sent, DeviceState{.sample = i + 1, .sample_time_ns = time_ns}, time_ns);
    if (i % 20 == 0) add_datagram(SessionEntry::Kind::received, ForceCommand{.echo_sample = i + 1}, time_ns);
  }
  return bytes;
}

RecordedTouch evaluate_touch(const std::string& bytes) {
  const ScratchFolder scratch;
  const auto touch = evaluate_recording(scratch.write("session.hapton", bytes), recorded_method(), {.from_s = 0.5, .to_s = 1.5});
  EXPECT_TRUE(touch) << touch.error().what;
  return touch.value_or(RecordedTouch{});
}

TEST(RemoteRecording, TheForceWithoutDelayHasNoError) {
  const RecordedTouch touch = evaluate_touch(recording_of(forces_without_delay(), true));
  EXPECT_LT(touch.force.error_rms, 1e-12);
  EXPECT_EQ(touch.force.falls, 0U);
  EXPECT_EQ(touch.local_share, 1.0);
  EXPECT_EQ(touch.cycles, kSamples);
  EXPECT_EQ(touch.missed, 2U);
  EXPECT_NEAR(touch.rates.packets_up, 100.0, 1.0);
  EXPECT_NEAR(touch.rates.packets_down, 50.0, 1.0);
  EXPECT_GT(touch.rates.bytes_up, 100.0 * 60.0);
}

// What the governor takes away is no error of the local force, and a force is compared with what the device can give.
TEST(RemoteRecording, WhatTheGovernorTakesIsNoErrorOfTheLocalForce) {
  const ScratchFolder scratch;
  const std::vector<Vec3> exact = forces_without_delay();
  std::vector<Vec3> halved = exact;
  for (Vec3& force : halved) force *= 0.5;
  const auto evaluate = [&](const std::vector<Vec3>& written, double max_force_n) {
    const auto file = scratch.write("session.hapton", recording_of(written, true, true, exact));
    return *evaluate_recording(file, recorded_method(), {.from_s = 0.5, .to_s = 1.5, .max_force_n = max_force_n});
  };
  const RecordedTouch touch = evaluate(halved, 100.0);
  EXPECT_NEAR(touch.force.error_rms, 0.5, 1e-9);
  EXPECT_LT(touch.local_error_rms, 1e-12);
  EXPECT_LT(touch.local_error_max_n, 1e-9);
  std::vector<Vec3> limited = exact;
  for (Vec3& force : limited) force *= std::min(1.0, 0.3 / std::max(force.norm(), 1e-9));
  EXPECT_LT(evaluate(limited, 0.3).force.error_rms, 1e-9);
}

TEST(RemoteRecording, ALateForceIsLateByAsMuch) {
  const std::vector<Vec3> exact = forces_without_delay();
  std::vector<Vec3> late(kSamples, Vec3::Zero());
  for (std::size_t i = 20; i < kSamples; ++i) late[i] = exact[i - 20];
  const RecordedTouch touch = evaluate_touch(recording_of(late, false));
  EXPECT_GT(touch.force.error_rms, 0.05);
  EXPECT_NEAR(touch.force.time_offset_s, 0.02, 0.003);
  EXPECT_EQ(touch.local_share, 0.0);
}

TEST(RemoteRecording, NoForceIsAFallThrough) {
  const RecordedTouch touch = evaluate_touch(recording_of(std::vector<Vec3>(kSamples, Vec3::Zero()), false));
  EXPECT_EQ(touch.force.falls, 1U);
  EXPECT_DOUBLE_EQ(touch.force.error_rms, 1.0);
}

TEST(RemoteRecording, ARecordingThatCannotBeEvaluatedIsAnError) {
  const ScratchFolder scratch;
  const RecordedRun run{.from_s = 0.5, .to_s = 1.5};
  const auto old = scratch.write("old.hapton", recording_of(forces_without_delay(), false, false));
  const auto touch = evaluate_recording(old, recorded_method(), run);
  ASSERT_FALSE(touch);
  EXPECT_NE(touch.error().what.find("no samples of the device"), std::string::npos) << touch.error().what;
  const std::string whole = recording_of(forces_without_delay(), false);
  const auto cut = scratch.write("cut.hapton", std::string_view(whole).substr(0, whole.size() - 9));
  EXPECT_FALSE(evaluate_recording(cut, recorded_method(), run));
  EXPECT_FALSE(evaluate_recording(scratch.path() / "none.hapton", recorded_method(), run));
}

}  // namespace
}  // namespace hapton
