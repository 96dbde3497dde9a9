#include "vision_node/time_line.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "tests/recording/opened_recording.h"

namespace hapton {
namespace {

TEST(TimeLine, HasContactAsABandAndMarksAsTicks) {
  const OpenedRecording recording;
  const TimeLineShown line = make_time_line(recording.index);
  ASSERT_EQ(line.contact.size(), 1U);
  EXPECT_NEAR(line.contact[0].from, 0.5, 2e-3);
  EXPECT_NEAR(line.contact[0].to, 0.75, 6e-3) << "a span of 20 ms is half a per cent";
  ASSERT_EQ(line.ticks.size(), 3U);
  EXPECT_NEAR(line.ticks[0].at, 0.25, 1e-3);
  EXPECT_FALSE(line.ticks[0].is_fault);
  EXPECT_TRUE(line.ticks[1].is_fault);
  EXPECT_EQ(line.begin, "0:00.0");
  EXPECT_EQ(line.end, "0:04.0");
}

// Contact from 1 s to 1.1 s, from 1.12 s to 1.2 s, and from 3 s to 3.02 s. A span is 20 ms of the recording, a column of the line 2 ms.
TEST(TimeLine, EachContactIsABandOfItsOwn) {
  MadeRecording made;
  made.has_replies = false;
  made.also = [&](std::uint64_t sample) {
    ForceCommand force = force_of(sample);
    force.contact = (sample >= 1000 && sample < 1100) || (sample >= 1120 && sample < 1200) || (sample >= 3000 && sample < 3020);
    made.receive(MadeRecording::kHaptics, force, sample);
  };
  const ScratchFolder scratch;
  auto reader = SessionReader::open(made.write(scratch));
  const auto index = RecordingIndex::read(*reader);
  ASSERT_TRUE(index);
  const std::vector<TimeLineShown::Band> bands = make_time_line(*index).contact;
  ASSERT_EQ(bands.size(), 3U);
  const double from[] = {1.0, 1.12, 3.0};
  const double to[] = {1.1, 1.2, 3.02};
  for (std::size_t i = 0; i < 3; ++i) {
    // Bands begin and end at whole columns, which divide the 3.999 s from the first sample, at 0.001 s, to the last.
    EXPECT_NEAR(bands[i].from, (from[i] - 0.001) / 3.999, 1.0 / kTimeLineColumns) << i;
    EXPECT_NEAR(bands[i].to, (to[i] - 0.001) / 3.999, 1.0 / kTimeLineColumns) << i;
    EXPECT_LE(bands[i].from, (from[i] - 0.001) / 3.999) << i;
    EXPECT_GE(bands[i].to, (to[i] - 0.001) / 3.999) << i;
  }
}

// Near 1 s all markers are in one column of 2 ms; at 2.5 s a marker and a fault are.
TEST(TimeLine, TicksOfOneKindAreNoNearerThanAColumn) {
  MadeRecording made;
  made.marks_at = {999, 1000, 2500, 3000};
  const OpenedRecording recording(std::move(made));
  const std::vector<TimeLineShown::Tick> ticks = make_time_line(recording.index).ticks;
  ASSERT_EQ(ticks.size(), 5U) << "one at 1 s, both at 2.5 s, one each at 3 s and 3.5 s";
  const bool is_fault[] = {false, true, false, false, false};
  const double at[] = {0.999, 2.5, 2.5, 3.0, 3.5};
  for (std::size_t i = 0; i < 5; ++i) {
    // The first sample is at 0.001 s, and the last one 3.999 s later.
    EXPECT_NEAR(ticks[i].at, (at[i] - 0.001) / 3.999, 1e-9) << i;
    EXPECT_EQ(ticks[i].is_fault, is_fault[i]) << i;
  }
}

TEST(TimeLine, ItsPlaceIsAShareOfThePicture) {
  struct Row {
    PictureSize size;
    double strip_height_px;
  };
  for (const Row& row : {Row{{1000, 300}, 22.0}, Row{{1000, 800}, 44.0}, Row{{2000, 4000}, 80.0}}) {
    const TimeLinePlace place = place_time_line(row.size);
    EXPECT_NEAR(place.strip_height_px, row.strip_height_px, 1e-9);
    EXPECT_NEAR(place.left_px, 0.07 * row.size.width_px, 1e-9);
    EXPECT_NEAR(place.width_px, 0.86 * row.size.width_px, 1e-9);
    EXPECT_NEAR(place.height_px, 0.34 * row.strip_height_px, 1e-9);
    EXPECT_NEAR(place.bottom_px, 0.33 * row.strip_height_px, 1e-9);
    EXPECT_NEAR(place.share_at(0.07 * row.size.width_px + 0.43 * row.size.width_px), 0.5, 1e-9);
  }
  EXPECT_EQ(TimeLinePlace{}.share_at(3.0), 0.0) << "a line without length";
}

TEST(TimeLine, SharesAndMomentsAreInverse) {
  const OpenedRecording recording;
  for (const double share : {0.0, 0.3, 1.0}) {
    EXPECT_NEAR(find_time_line_share(recording.index, find_time_line_moment(recording.index, share)), share, 1e-12);
  }
  EXPECT_EQ(find_time_line_share(recording.index, -5.0), 0.0);
  EXPECT_EQ(find_time_line_moment(recording.index, 7.0), recording.index.end_s());
}

TEST(TimeLine, LiesAtTheLowerEdgeOfAnyPicture) {
  for (const PictureSize size : {PictureSize{320, 180}, PictureSize{1280, 720}, PictureSize{640, 2160}}) {
    const TimeLinePlace place = place_time_line(size);
    EXPECT_GT(place.bottom_px, 0.0);
    EXPECT_LT(place.bottom_px + place.height_px, place.strip_height_px);
    EXPECT_LT(place.strip_height_px, 0.25 * size.height_px);
    EXPECT_EQ(place.share_at(-100.0), 0.0);
    EXPECT_NEAR(place.share_at(0.5 * size.width_px), 0.5, 1e-9);
    EXPECT_EQ(place.share_at(size.width_px), 1.0);
  }
}

TEST(TimeLine, TimesAreReadable) {
  EXPECT_EQ(describe_time(0.0), "0:00.0");
  EXPECT_EQ(describe_time(59.96), "1:00.0") << "not 0:60.0";
  EXPECT_EQ(describe_time(123.4567, 3), "2:03.457");
  EXPECT_EQ(describe_time(3723.4), "1:02:03.4");
  EXPECT_EQ(describe_time(-1.5), "-0:01.5");
}

TEST(TimeLine, MarksAreFoundFromOneToTheNext) {
  const OpenedRecording recording;
  const RecordingMark* mark = find_next_mark(recording.index, 0.0);
  ASSERT_NE(mark, nullptr);
  EXPECT_EQ(mark->text, "trial 7");
  mark = find_next_mark(recording.index, mark->t_s);
  ASSERT_NE(mark, nullptr);
  EXPECT_TRUE(mark->is_fault);
  EXPECT_EQ(find_next_mark(recording.index, 3.9), nullptr);
  EXPECT_EQ(find_previous_mark(recording.index, 1.0), nullptr) << "it is the first itself";
  ASSERT_NE(find_previous_mark(recording.index, 9.0), nullptr);
  EXPECT_EQ(find_previous_mark(recording.index, 9.0)->text, "trial 8");
}

}  // namespace
}  // namespace hapton
