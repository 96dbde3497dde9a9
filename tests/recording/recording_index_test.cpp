#include "recording/recording_index.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "tests/recording/made_recording.h"
#include "tests/support/one_line.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

RecordingIndex index_of(const std::filesystem::path& file) {
  auto reader = SessionReader::open(file);
  EXPECT_TRUE(reader) << reader.error().what;
  auto index = RecordingIndex::read(*reader);
  EXPECT_TRUE(index) << index.error().what;
  return std::move(*index);
}

TEST(RecordingIndex, HasContactForceAndMarksAtTheirTimes) {
  const ScratchFolder scratch;
  const RecordingIndex index = index_of(MadeRecording().write(scratch));
  EXPECT_DOUBLE_EQ(index.begin_s(), 1e-3);
  EXPECT_DOUBLE_EQ(index.end_s(), 4.0);
  std::uint64_t samples = 0;
  for (const RecordingSpan& span : index.spans()) {
    samples += span.samples;
    const double from_s = RecordingIndex::kSpanS * static_cast<double>(span.number);
    EXPECT_EQ(span.is_contact, from_s >= 2.0 - 1e-9 && from_s < 3.0 - 1e-9) << from_s;
    EXPECT_FLOAT_EQ(span.written_n, 0.5F);
  }
  EXPECT_EQ(samples, 4000U);
  ASSERT_EQ(index.marks().size(), 3U);
  EXPECT_EQ(index.marks()[0].text, "trial 7");
  EXPECT_DOUBLE_EQ(index.marks()[0].t_s, 1.0);
  EXPECT_FALSE(index.marks()[0].is_fault);
  EXPECT_EQ(index.marks()[1].text, "clamped");
  EXPECT_TRUE(index.marks()[1].is_fault);
  EXPECT_EQ(index.marks()[2].text, "trial 8");
}

TEST(RecordingIndex, AMessageHoldsUntilTheNextOne) {
  const ScratchFolder scratch;
  const RecordingIndex index = index_of(MadeRecording().write(scratch));
  EXPECT_EQ(index.find_view({}, 0.5).translation().x(), 0.0);
  EXPECT_FLOAT_EQ(static_cast<float>(index.find_view({}, 2.0).translation().x()), 0.25F);
  EXPECT_EQ(index.find_view(0U, 2.0).translation().x(), 0.0) << "a force that was computed with the pose before";
  ASSERT_NE(index.find_setup(-1.0), nullptr) << "the first one, also before it came";
  EXPECT_STREQ(index.find_setup(9.0)->scene.data(), "made.toml");
  EXPECT_EQ(index.find_scene_hash(3.0), 77U);
  EXPECT_EQ(index.find_notice(0.05), nullptr);
  ASSERT_NE(index.find_notice(3.0), nullptr);
  EXPECT_EQ(index.find_notice(3.0)->status, ProbeStatus::fault_latched);
  ASSERT_EQ(index.poses().size(), 2U) << "repeated ones, and requests of vision nodes, are none";
  EXPECT_TRUE(index.poses()[0].message.is_held);
  EXPECT_FALSE(index.poses()[1].message.is_held);
  ASSERT_EQ(index.moves().size(), 1U);
  ASSERT_EQ(index.carves().size(), 2U) << "a repeated message is left out";
  EXPECT_NEAR(index.carves()[0].t_s, 1.6, 0.002);
  ASSERT_EQ(index.carves()[0].message.carves.size(), 1U);
  EXPECT_FLOAT_EQ(index.carves()[0].message.carves[0].carve.radius_m, 0.006F);
  EXPECT_TRUE(index.carves()[1].message.starts_anew);
  EXPECT_TRUE(index.carves()[1].message.carves.empty());
  EXPECT_EQ(count_until(index.carves(), 1.59), 0U);
  EXPECT_EQ(count_until(index.carves(), 2.0), 1U);
}

// Earlier carves come when the hub has requested them, but are shown from the beginning of the recording.
TEST(RecordingIndex, WhatWasCarvedBeforeTheRecordingIsThereFromTheBeginning) {
  const ScratchFolder scratch;
  MadeRecording recording;
  recording.is_carved_before = true;
  const RecordingIndex index = index_of(recording.write(scratch));
  ASSERT_EQ(index.carves().size(), 2U);
  EXPECT_NEAR(index.carves()[0].t_s, 0.05, 0.002);
  EXPECT_TRUE(index.carves()[0].message.starts_anew);
  ASSERT_EQ(index.carves()[0].message.carves.size(), 1U);
  EXPECT_FLOAT_EQ(index.carves()[0].message.carves[0].carve.radius_m, 0.006F);
  EXPECT_TRUE(index.carves()[1].message.starts_anew);
}

// As when the hub began to record while the stylus carved: the first message already has a carve.
TEST(RecordingIndex, WhatWasCarvedBeforeTheFirstCarveThatCameIsThereFromTheBeginning) {
  const ScratchFolder scratch;
  MadeRecording recording;
  recording.is_carved_before = true;
  recording.announces_carve = false;
  recording.also = [&](std::uint64_t sample) {
    if (sample != 100 && sample != 200) return;
    Carves carves = MadeRecording::through_middle(8, sample == 100 ? 2 : 3);
    carves.newest = 3;
    recording.receive(MadeRecording::kHaptics, carves, sample);
  };
  const RecordingIndex index = index_of(recording.write(scratch));
  ASSERT_EQ(index.carves().size(), 3U) << "the recording's own first carve belongs to the beginning, the third one does not";
  EXPECT_NEAR(index.carves()[0].t_s, 0.1, 0.001);
  ASSERT_EQ(index.carves()[0].message.carves.size(), 2U);
  // The carves may be in any order, because each has its serial.
  EXPECT_EQ(index.carves()[0].message.carves[0].serial, 2U);
  EXPECT_EQ(index.carves()[0].message.carves[1].serial, 1U);
  EXPECT_NEAR(index.carves()[1].t_s, 0.2, 0.001);
  ASSERT_EQ(index.carves()[1].message.carves.size(), 1U);
  EXPECT_EQ(index.carves()[1].message.carves[0].serial, 3U);
  EXPECT_TRUE(index.carves()[2].message.starts_anew);
}

// Each haptics process numbers its changes from 1 again.
TEST(RecordingIndex, AMessageOfAnotherProcessIsNoRepetition) {
  const ScratchFolder scratch;
  MadeRecording recording;
  recording.is_carved_before = true;
  recording.also = [&](std::uint64_t sample) {
    if (sample == 2300) recording.receive(MadeRecording::kHaptics, ObjectMove{.source = 7, .serial = 1, .object = 2, .end_ns = 5}, sample);
    if (sample == 3500) recording.receive(MadeRecording::kHaptics, MadeRecording::through_middle(9, 1), sample);
  };
  const RecordingIndex index = index_of(recording.write(scratch));
  ASSERT_EQ(index.moves().size(), 2U);
  EXPECT_NEAR(index.moves()[1].t_s, 2.3, 0.001);
  ASSERT_EQ(index.carves().size(), 3U);
  EXPECT_EQ(index.carves()[0].message.carves.size(), 1U) << "made before the recording by the process before";
  EXPECT_NEAR(index.carves()[2].t_s, 3.5, 0.001);
  EXPECT_EQ(index.carves()[2].message.carves.size(), 1U);
}

TEST(RecordingIndex, APoseOfAnotherProcessIsNoRepetition) {
  const ScratchFolder scratch;
  constexpr std::uint64_t kOtherHaptics = 4;
  MadeRecording recording;
  recording.also = [&](std::uint64_t sample) {
    if (sample == 3000) recording.receive(kOtherHaptics, HapticsSetup{.method_serial = 1}, sample);
    if (sample != 3100 && sample != 3200) return;
    recording.receive(kOtherHaptics, ObjectPose{.serial = 2, .object = 1, .p_m = Vec3(0.0, 0.2, 0.0)}, sample);
  };
  const RecordingIndex index = index_of(recording.write(scratch));
  ASSERT_EQ(index.poses().size(), 3U) << "the pose before has the same serial, of the other process";
  EXPECT_NEAR(index.poses()[2].t_s, 3.1, 0.001);
  EXPECT_EQ(index.poses()[2].message.p_m.y(), 0.2);
}

TEST(RecordingIndex, APositionIsNotFarBeforeItsTime) {
  const ScratchFolder scratch;
  const auto file = MadeRecording().write(scratch);
  const RecordingIndex index = index_of(file);
  for (const double t_s : {-5.0, 0.0, 0.7, 2.3, 3.999, 99.0}) {
    auto reader = SessionReader::open(file);
    reader->seek(index.find_position(t_s));
    SessionEntry entry;
    ASSERT_TRUE(reader->next(entry)) << t_s;
    const double first_s = 1e-9 * static_cast<double>(entry.time_ns - kCyclesStartNs);
    EXPECT_LE(first_s, std::max(t_s, 0.01)) << t_s;
    EXPECT_GE(first_s, std::min(t_s, 4.0) - 0.3) << t_s;
  }
}

TEST(RecordingIndex, ASpanHasTheLargestForceAndTheLongestRoundTrip) {
  const ScratchFolder scratch;
  MadeRecording recording;
  recording.slower_ns = 150'000;
  recording.lost_from = 1000;
  recording.lost_to = 1100;
  const RecordingIndex index = index_of(recording.write(scratch));
  for (const RecordingSpan& span : index.spans()) {
    if (span.samples == 1) continue;
    EXPECT_FLOAT_EQ(span.round_trip_s, 4.5e-4F) << span.number;
  }
  EXPECT_EQ(index.spans().front().samples, 19U) << "the samples 1 to 19";
  EXPECT_EQ(index.spans().back().samples, 1U) << "that of the last millisecond";
  for (const RecordingSpan& span : index.spans()) EXPECT_FALSE(span.number >= 50 && span.number < 55) << "nothing was recorded there";
}

TEST(RecordingIndex, WithoutAReplyASpanHasNoRoundTrip) {
  const ScratchFolder scratch;
  MadeRecording recording;
  recording.samples = 1;
  const RecordingIndex index = index_of(recording.write(scratch));
  ASSERT_EQ(index.spans().size(), 1U);
  EXPECT_LT(index.spans()[0].round_trip_s, 0.0F);
}

TEST(RecordingIndex, SpansAreFoundByTheTimesTheyOverlap) {
  const ScratchFolder scratch;
  const RecordingIndex index = index_of(MadeRecording().write(scratch));
  const auto numbers = [&](double from_s, double to_s) {
    std::vector<std::int64_t> found;
    for (const RecordingSpan& span : index.spans_between(from_s, to_s)) found.push_back(span.number);
    return found;
  };
  EXPECT_EQ(numbers(1.01, 1.05), (std::vector<std::int64_t>{50, 51, 52}));
  EXPECT_EQ(numbers(1.03, 1.03), (std::vector<std::int64_t>{51}));
  EXPECT_EQ(numbers(-9.0, 0.03), (std::vector<std::int64_t>{0, 1}));
  EXPECT_EQ(numbers(3.99, 1e300), (std::vector<std::int64_t>{199, 200}));
  EXPECT_EQ(index.spans_between(-1e300, 1e300).size(), index.spans().size());
  EXPECT_TRUE(numbers(5.0, 6.0).empty());
  EXPECT_TRUE(numbers(2.0, 1.0).empty());
}

// A method, a scene, other meshes in the same file, another unit: each is another set-up.
TEST(RecordingIndex, EachChangeOfTheSetupIsKnownFromItsTimeOn) {
  const ScratchFolder scratch;
  MadeRecording recording;
  HapticsSetup setup{.method_serial = 1, .scene_hash = 5};
  std::strncpy(setup.scene.data(), "made.toml", setup.scene.size() - 1);
  std::strncpy(setup.method.data(), "name=proxy probe_radius_m=0.004", setup.method.size() - 1);
  recording.also = [&](std::uint64_t sample) {
    if (sample % 500 != 0) return;
    if (sample == 500) std::strncpy(setup.method.data(), "name=smooth", setup.method.size() - 1);
    if (sample == 1000) std::strncpy(setup.scene.data(), "other.toml", setup.scene.size() - 1);
    if (sample == 1500) setup.scene_hash = 6;
    if (sample == 2000) setup.scene_loading = 3;
    ++setup.method_serial;
    recording.receive(MadeRecording::kHaptics, setup, sample);
  };
  const RecordingIndex index = index_of(recording.write(scratch));
  EXPECT_STREQ(index.find_setup(0.49)->method.data(), "name=proxy probe_radius_m=0.004");
  EXPECT_STREQ(index.find_setup(0.51)->method.data(), "name=smooth");
  EXPECT_STREQ(index.find_setup(0.99)->scene.data(), "made.toml");
  EXPECT_STREQ(index.find_setup(1.01)->scene.data(), "other.toml");
  EXPECT_EQ(index.find_setup(1.49)->scene_hash, 5U);
  EXPECT_EQ(index.find_setup(1.51)->scene_hash, 6U);
  EXPECT_EQ(index.find_setup(1.99)->scene_loading, 0U);
  EXPECT_EQ(index.find_setup(2.01)->scene_loading, 3U);
  EXPECT_EQ(index.find_setup(3.9), index.find_setup(2.1)) << "a repeated message changes nothing";
}

TEST(RecordingIndex, RepetitionsOfOneObjectAreKnownAlsoBetweenThoseOfAnother) {
  const ScratchFolder scratch;
  MadeRecording recording;
  recording.also = [&](std::uint64_t sample) {
    if (sample < 3000 || sample % 100 != 0) return;
    for (const std::int32_t object : {3, 4}) {
      recording.receive(MadeRecording::kHaptics, ObjectPose{.serial = sample < 3500 ? 5U : 6U, .object = object}, sample);
      recording.receive(MadeRecording::kHaptics, ObjectMove{.source = 6, .serial = 5, .object = object, .start_ns = 1, .end_ns = 2},
                        sample);
    }
  };
  const RecordingIndex index = index_of(recording.write(scratch));
  ASSERT_EQ(index.poses().size(), 6U);
  for (std::size_t n = 2; n < 6; ++n) {
    EXPECT_EQ(index.poses()[n].message.object, n % 2 == 0 ? 3 : 4);
    EXPECT_NEAR(index.poses()[n].t_s, n < 4 ? 3.0 : 3.5, 0.001);
  }
  EXPECT_EQ(index.moves().size(), 3U);
}

// The pose of the scene for a revision and a time: the newest until then with this revision; if there is none, the newest until then.
TEST(RecordingIndex, AViewIsFoundByItsRevision) {
  const ScratchFolder scratch;
  MadeRecording recording;
  recording.also = [&](std::uint64_t sample) {
    const auto shifted = [&](std::uint32_t revision, float x) {
      recording.receive(MadeRecording::kVision, ViewTransform{revision, {1, 0, 0, x, 0, 1, 0, 0, 0, 0, 1, 0}}, sample);
    };
    if (sample == 2000) shifted(5, 0.5F);
    if (sample == 2500) shifted(4, 0.75F);  // from a vision node that was started again
    if (sample == 3000) shifted(6, 1.0F);
  };
  const RecordingIndex index = index_of(recording.write(scratch));
  const auto x_of = [&](std::optional<std::uint32_t> revision, double t_s) {
    return static_cast<float>(index.find_view(revision, t_s).translation().x());
  };
  EXPECT_EQ(x_of(4U, 2.4), 0.25F);
  EXPECT_EQ(x_of(5U, 2.4), 0.5F);
  EXPECT_EQ(x_of(4U, 3.5), 0.75F);
  EXPECT_EQ(x_of(5U, 3.5), 0.5F);
  EXPECT_EQ(x_of(6U, 3.5), 1.0F);
  EXPECT_EQ(x_of(6U, 2.9), 0.75F) << "not known yet";
  EXPECT_EQ(x_of(99U, 3.5), 1.0F);
  EXPECT_EQ(x_of({}, 2.6), 0.75F);
  EXPECT_EQ(x_of(0U, -1.0), 0.0F);
}

// As in a file whose times were changed.
TEST(RecordingIndex, AMessageThatIsLaterInTheFileIsNotEarlierInTime) {
  const ScratchFolder scratch;
  MadeRecording recording;
  recording.also = [&](std::uint64_t sample) {
    if (sample != 3000) return;
    recording.receive(MadeRecording::kHaptics, ObjectPose{.serial = 8, .object = 3}, sample);
    recording.receive(MadeRecording::kHaptics, ObjectPose{.serial = 9, .object = 3}, sample, -2'500'000'000);
  };
  const RecordingIndex index = index_of(recording.write(scratch));
  ASSERT_EQ(index.poses().size(), 4U);
  EXPECT_EQ(index.poses()[3].message.serial, 9U);
  EXPECT_EQ(index.poses()[3].t_s, index.poses()[2].t_s);
  EXPECT_EQ(count_until(index.poses(), 2.9), 2U);
}

TEST(RecordingIndex, NoticesOfTheDeviceAreThoseThatChanged) {
  const ScratchFolder scratch;
  MadeRecording recording;
  recording.also = [&](std::uint64_t sample) {
    if (sample == 200 || sample == 300) recording.notice({.energy_percent = 40, .force_limit_n = 8.0F}, sample);
    if (sample == 300) recording.receive(MadeRecording::kVision, ProbeState{.energy_percent = 99}, sample);  // not from the hub: ignored
  };
  const RecordingIndex index = index_of(recording.write(scratch));
  ASSERT_NE(index.find_notice(0.15), nullptr);
  EXPECT_EQ(index.find_notice(0.15)->energy_percent, 0U);
  ASSERT_NE(index.find_notice(0.25), nullptr);
  EXPECT_EQ(index.find_notice(0.25)->energy_percent, 40U);
  EXPECT_EQ(index.find_notice(0.25)->force_limit_n, 8.0F);
  EXPECT_EQ(index.find_notice(0.35), index.find_notice(0.25)) << "repeated";
  EXPECT_EQ(index.find_notice(2.5)->status, ProbeStatus::ok);
  EXPECT_EQ(index.find_notice(99.0)->status, ProbeStatus::fault_latched);
}

// About a megabyte in each 25 ms: after a jump to a time, reading begins no more than about a megabyte before it.
TEST(RecordingIndex, APositionIsNotFarBeforeItsTimeAlsoAmongManyMessages) {
  const ScratchFolder scratch;
  MadeRecording recording;
  recording.samples = 400;
  HapticsSetup setup{.method_serial = 1};
  for (HapticsSetup::Text* text : {&setup.scene, &setup.build, &setup.method}) std::fill(text->begin(), text->end() - 1, 'x');
  recording.also = [&](std::uint64_t sample) {
    for (int n = 0; n < 60; ++n) recording.receive(MadeRecording::kHaptics, setup, sample);
  };
  const auto file = recording.write(scratch);
  ASSERT_GT(std::filesystem::file_size(file), 16U << 20);
  const RecordingIndex index = index_of(file);
  for (const double t_s : {0.1, 0.2, 0.24, 0.39}) {
    auto reader = SessionReader::open(file);
    reader->seek(index.find_position(t_s));
    SessionEntry entry;
    ASSERT_TRUE(reader->next(entry)) << t_s;
    const double first_s = 1e-9 * static_cast<double>(entry.time_ns - kCyclesStartNs);
    EXPECT_LE(first_s, t_s);
    EXPECT_GT(first_s, t_s - 0.05) << "a megabyte before";
  }
}

TEST(RecordingIndex, ARecordingWithoutSamplesIsAnErrorInOneLine) {
  const ScratchFolder scratch;
  MadeRecording empty;
  empty.samples = 0;
  auto reader = SessionReader::open(empty.write(scratch));
  auto index = RecordingIndex::read(*reader);
  ASSERT_FALSE(index);
  EXPECT_NE(index.error().what.find("no sample"), std::string::npos);
  EXPECT_THAT(index.error().what, IsOneLine());
  MadeRecording old;
  old.has_device = false;
  reader = SessionReader::open(old.write(scratch));
  index = RecordingIndex::read(*reader);
  ASSERT_FALSE(index);
  EXPECT_NE(index.error().what.find("older recording"), std::string::npos);
  EXPECT_THAT(index.error().what, IsOneLine());
}

// In a hostile file any number may be in the place of a time.
TEST(RecordingIndex, TimesOfAHostileFileDoNoHarm) {
  const ScratchFolder scratch;
  SessionCodec codec;
  std::string bytes(kSessionMagic);
  codec.append(SessionHeader{.start_ns = kCyclesStartNs}, bytes);
  for (const std::int64_t time_ns :
       {std::numeric_limits<std::int64_t>::max(), std::int64_t{-1}, std::numeric_limits<std::int64_t>::min() + 1, std::int64_t{7}}) {
    SessionEntry entry = cycle_of(1);
    entry.time_ns = time_ns;
    entry.cycle.device->time_ns = -time_ns;
    codec.append(entry, bytes);
  }
  const RecordingIndex index = index_of(scratch.write("hostile.hapton", bytes));
  EXPECT_LE(index.spans().size(), 4U);
  EXPECT_LE(index.begin_s(), index.end_s());
}

}  // namespace
}  // namespace hapton
