#include "session/session_index.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "tests/session/made_recording.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

SessionIndex index_of(const std::filesystem::path& file) {
  auto reader = SessionReader::open(file);
  EXPECT_TRUE(reader) << reader.error().what;
  auto index = SessionIndex::read(*reader);
  EXPECT_TRUE(index) << index.error().what;
  return std::move(*index);
}

TEST(SessionIndex, HasContactForceAndMarksAtTheirTimes) {
  const ScratchFolder scratch;
  const SessionIndex index = index_of(MadeRecording().write(scratch));
  EXPECT_DOUBLE_EQ(index.begin_s(), 1e-3);
  EXPECT_DOUBLE_EQ(index.end_s(), 4.0);
  std::uint64_t samples = 0;
  for (const SessionSpan& span : index.spans()) {
    samples += span.samples;
    const double from_s = SessionIndex::kSpanS * static_cast<double>(span.number);
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

TEST(SessionIndex, WhatWasSaidHoldsUntilSomethingElseIs) {
  const ScratchFolder scratch;
  const SessionIndex index = index_of(MadeRecording().write(scratch));
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
  EXPECT_FLOAT_EQ(index.carves()[0].message.carves[0].radius_m, 0.006F);
  EXPECT_TRUE(index.carves()[1].message.starts_anew);
  EXPECT_TRUE(index.carves()[1].message.carves.empty());
  EXPECT_EQ(count_until(index.carves(), 1.59), 0U);
  EXPECT_EQ(count_until(index.carves(), 2.0), 1U);
}

// They come when the hub has requested them, and show from the beginning.
TEST(SessionIndex, WhatWasCarvedBeforeTheRecordingIsThereFromTheBeginning) {
  const ScratchFolder scratch;
  MadeRecording recording;
  recording.is_carved_before = true;
  const SessionIndex index = index_of(recording.write(scratch));
  ASSERT_EQ(index.carves().size(), 2U);
  EXPECT_NEAR(index.carves()[0].t_s, 0.05, 0.002);
  EXPECT_TRUE(index.carves()[0].message.starts_anew);
  ASSERT_EQ(index.carves()[0].message.carves.size(), 1U);
  EXPECT_FLOAT_EQ(index.carves()[0].message.carves[0].radius_m, 0.006F);
  EXPECT_TRUE(index.carves()[1].message.starts_anew);
}

TEST(SessionIndex, APositionIsNotFarBeforeItsTime) {
  const ScratchFolder scratch;
  const auto file = MadeRecording().write(scratch);
  const SessionIndex index = index_of(file);
  for (const double t_s : {-5.0, 0.0, 0.7, 2.3, 3.999, 99.0}) {
    auto reader = SessionReader::open(file);
    reader->seek(index.find_position(t_s));
    SessionEntry entry;
    ASSERT_TRUE(reader->next(entry)) << t_s;
    const double first_s = 1e-9 * static_cast<double>(entry.time_ns - kJoinedStartNs);
    EXPECT_LE(first_s, std::max(t_s, 0.01)) << t_s;
    EXPECT_GE(first_s, std::min(t_s, 4.0) - 0.3) << t_s;
  }
}

TEST(SessionIndex, ARecordingWithoutSamplesIsAnErrorInOneLine) {
  const ScratchFolder scratch;
  MadeRecording empty;
  empty.samples = 0;
  auto reader = SessionReader::open(empty.write(scratch));
  auto index = SessionIndex::read(*reader);
  ASSERT_FALSE(index);
  EXPECT_NE(index.error().what.find("no sample"), std::string::npos);
  MadeRecording old;
  old.has_device = false;
  reader = SessionReader::open(old.write(scratch));
  index = SessionIndex::read(*reader);
  ASSERT_FALSE(index);
  EXPECT_NE(index.error().what.find("older recording"), std::string::npos);
}

// Any number may stand where a time is.
TEST(SessionIndex, TimesOfAHostileFileDoNoHarm) {
  const ScratchFolder scratch;
  SessionCodec codec;
  std::string bytes(kSessionMagic);
  codec.append(SessionHeader{.start_ns = kJoinedStartNs}, bytes);
  for (const std::int64_t time_ns :
       {std::numeric_limits<std::int64_t>::max(), std::int64_t{-1}, std::numeric_limits<std::int64_t>::min() + 1, std::int64_t{7}}) {
    SessionEntry entry = cycle_of(1);
    entry.time_ns = time_ns;
    entry.cycle.device->time_ns = -time_ns;
    codec.append(entry, bytes);
  }
  const SessionIndex index = index_of(scratch.write("hostile.hapton", bytes));
  EXPECT_LE(index.spans().size(), 4U);
  EXPECT_LE(index.begin_s(), index.end_s());
}

}  // namespace
}  // namespace hapton
