#include "io_node/marker_log.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/io_node/network_loop_fixture.h"

namespace hapton {
namespace {

Marker marker_of(std::uint32_t request, std::string_view text) {
  Marker marker{.request = request};
  std::copy(text.begin(), text.end(), marker.text.begin());
  return marker;
}

TEST_F(NetworkLoops, AMarkerOfAnyNodeIsRecordedAtTheNewestSampleAndGetsAReply) {
  RecordingTap tap;
  make({}, nullptr, &tap);
  join(kHaptics, NodeRole::haptics);
  join(kTool, NodeRole::tool);
  join(kVision, NodeRole::vision);
  run(5);
  say(kTool, marker_of(7, "trial 1"));
  run(1);
  say(kVision, marker_of(7, "gezückt"));
  run(1);
  say(kHaptics, marker_of(9, "pulse"));
  run(2);
  ASSERT_EQ(tap.markers.size(), 3U);
  EXPECT_EQ(tap.markers[0].second, "trial 1");
  EXPECT_EQ(tap.markers[1].second, "gezückt");
  ASSERT_EQ(marker_replies.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(marker_replies[i].second.sample, tap.markers[i].first);
    EXPECT_EQ(marker_replies[i].second.status, MarkerStatus::recorded);
    EXPECT_TRUE(tap.markers[i].first == 5 + i || tap.markers[i].first == 6 + i) << tap.markers[i].first;
  }
  EXPECT_EQ(marker_replies[0].first, at(kTool));
  EXPECT_EQ(marker_replies[1].first, at(kVision));
  EXPECT_EQ(stats().markers, 3U);
}

TEST_F(NetworkLoops, AMarkerThatIsRepeatedIsRecordedOnceAndGetsAnotherReply) {
  RecordingTap tap;
  make({}, nullptr, &tap);
  join(kTool, NodeRole::tool);
  run(5);
  for (int n = 0; n < 3; ++n) {
    say(kTool, marker_of(7, "trial 1"));
    run(5);
  }
  EXPECT_EQ(tap.markers.size(), 1U);
  ASSERT_EQ(marker_replies.size(), 3U);
  EXPECT_EQ(marker_replies[2].second.sample, tap.markers[0].first);
}

TEST_F(NetworkLoops, AFloodOfMarkersIsCountedAndTheOthersAreRecorded) {
  RecordingTap tap;
  make({}, nullptr, &tap);
  join(kTool, NodeRole::tool);
  join(kVision, NodeRole::vision);
  run(5);
  for (std::uint32_t n = 1; n <= 5000; ++n) {
    say(kTool, marker_of(n, "flood"));
    if (n % 50 == 0) run(1);
  }
  say(kVision, marker_of(1, "mine"));
  run(2);
  EXPECT_LE(tap.markers.size(), static_cast<std::size_t>(MarkerLog::kBurst + MarkerLog::kPerSecond));
  EXPECT_GE(tap.markers.size(), static_cast<std::size_t>(MarkerLog::kBurst));
  EXPECT_EQ(tap.markers.back().second, "mine") << "each node has its own limit";
  EXPECT_EQ(stats().markers + stats().markers_rejected, 5001U);
  EXPECT_LT(marker_replies.size(), tap.markers.size() + 20U);
  clock.advance_ns(kNanosecondsPerSecond / 2);
  say(kTool, marker_of(5001, "half a second later"));
  run(2);
  EXPECT_EQ(tap.markers.back().second, "half a second later") << "the limit recovers";
}

TEST_F(NetworkLoops, ANodeLearnsThatNothingIsRecorded) {
  make();
  join(kTool, NodeRole::tool);
  run(5);
  say(kTool, marker_of(7, "trial 1"));
  run(2);
  ASSERT_EQ(marker_replies.size(), 1U);
  EXPECT_EQ(marker_replies[0].second.status, MarkerStatus::no_recording);
  EXPECT_EQ(stats().markers_rejected, 1U);
}

}  // namespace
}  // namespace hapton
