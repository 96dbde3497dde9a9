#include "io_node/carve_collector.h"

#include <gtest/gtest.h>

#include "tests/io_node/network_loop_fixture.h"

namespace hapton {
namespace {

Carves carves_from(std::uint32_t source, std::uint32_t newest, std::uint32_t first, std::uint32_t count) {
  Carves carves{.source = source, .newest = newest, .first = first, .count = count};
  for (std::uint32_t n = 0; n < count; ++n) carves.carves[n].radius_m = 0.01F;
  return carves;
}

TEST_F(NetworkLoops, ARecordingRequestsTheCarvesThatWereMadeBeforeIt) {
  RecordingTap tap;
  make({}, nullptr, &tap);
  join(kHaptics, NodeRole::haptics);
  run(5);
  EXPECT_TRUE(carve_statuses.empty()) << "nothing is known to be missing";
  say(kHaptics, Carves{.source = 7, .newest = 40});
  run(5);
  ASSERT_EQ(carve_statuses.size(), 1U);
  EXPECT_EQ(carve_statuses[0].first, at(kHaptics));
  EXPECT_EQ(carve_statuses[0].second.source, 7U);
  EXPECT_EQ(carve_statuses[0].second.complete, 0U);
  say(kHaptics, carves_from(7, 40, 1, 32));
  run(250);
  EXPECT_EQ(carve_statuses.size(), 3U) << "ten times a second";
  EXPECT_EQ(carve_statuses.back().second.complete, 32U);
  say(kHaptics, carves_from(7, 40, 33, 8));
  run(300);
  EXPECT_EQ(carve_statuses.size(), 3U) << "it has all";
  say(kHaptics, carves_from(9, 3, 3, 1));
  run(5);
  ASSERT_EQ(carve_statuses.size(), 4U) << "another process";
  EXPECT_EQ(carve_statuses.back().second.source, 9U);
  EXPECT_EQ(carve_statuses.back().second.complete, 0U);
}

TEST_F(NetworkLoops, WithoutARecordingNoCarvesAreRequested) {
  RecordingTap tap;
  tap.marker_status = MarkerStatus::no_recording;
  make({}, nullptr, &tap);
  join(kHaptics, NodeRole::haptics);
  run(5);
  say(kHaptics, Carves{.source = 7, .newest = 40});
  run(300);
  EXPECT_TRUE(carve_statuses.empty());
}

}  // namespace
}  // namespace hapton
