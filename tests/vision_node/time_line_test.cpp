#include "vision_node/time_line.h"

#include <gtest/gtest.h>

#include "tests/session/opened_recording.h"

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
    EXPECT_LT(place.bottom_px + place.height_px, place.reserve_px);
    EXPECT_LT(place.reserve_px, 0.25 * size.height_px);
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
  const SessionMark* mark = find_next_mark(recording.index, 0.0);
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
