#include "vision_node/marker_key.h"

#include <gtest/gtest.h>

#include "tests/support/time_units.h"

namespace hapton {
namespace {

TEST(MarkerKey, SendsEachPressUntilThereIsAReply) {
  MarkerKey key;
  EXPECT_FALSE(key.take_due(0));
  key.press(0);
  key.press(0);
  const auto first = key.take_due(0);
  const auto second = key.take_due(0);
  ASSERT_TRUE(first && second);
  EXPECT_STREQ(first->text.data(), "key 1");
  EXPECT_STREQ(second->text.data(), "key 2");
  EXPECT_FALSE(key.take_due(MarkerKey::kRepeatNs - 1));
  EXPECT_EQ(key.accept({first->request, 77, MarkerStatus::recorded}), "marked sample 77: key 1");
  EXPECT_FALSE(key.accept({first->request, 77, MarkerStatus::recorded})) << "a second reply";
  const auto again = key.take_due(MarkerKey::kRepeatNs);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->request, second->request);
  const auto rejected = key.accept({second->request, 77, MarkerStatus::no_recording});
  ASSERT_TRUE(rejected);
  EXPECT_NE(rejected->find("--record"), std::string::npos) << *rejected;
  EXPECT_FALSE(key.take_due(5 * MarkerKey::kRepeatNs));
}

TEST(MarkerKey, GivesUpAndBoundsWhatWaits) {
  MarkerKey key;
  for (std::size_t n = 0; n < 2 * MarkerKey::kMaxWaiting; ++n) key.press(0);
  std::size_t sent = 0;
  while (key.take_due(0)) ++sent;
  EXPECT_EQ(sent, MarkerKey::kMaxWaiting);
  EXPECT_FALSE(key.take_due(MarkerKey::kReplyTimeoutNs));
}

}  // namespace
}  // namespace hapton
