#include "link/marker_request.h"

#include <gtest/gtest.h>

#include <string>

namespace hapton {
namespace {

TEST(MarkerRequest, HoldsAValidTextAndANumber) {
  const auto marker = make_marker("trial 1");
  ASSERT_TRUE(marker);
  EXPECT_STREQ(marker->text.data(), "trial 1");
  EXPECT_NE(marker->request, 0U);
  EXPECT_NE(make_marker("trial 1")->request, marker->request);
  EXPECT_TRUE(make_marker(std::string(MarkerText::kMaxBytes, 'x')));
  for (const std::string& bad : {std::string(), std::string(MarkerText::kMaxBytes + 1, 'x'), std::string("a\nb"), std::string("\xFF")}) {
    const auto rejected = make_marker(bad);
    ASSERT_FALSE(rejected) << bad;
    EXPECT_EQ(rejected.error().what.find('\n'), std::string::npos);
  }
}

TEST(MarkerRequest, AReplyIsASampleOrAReason) {
  EXPECT_EQ(read_reply({1, 77, MarkerStatus::recorded}), 77U);
  for (const MarkerStatus status : {MarkerStatus::no_recording, MarkerStatus::too_many, MarkerStatus::no_room}) {
    EXPECT_FALSE(read_reply({1, 77, status}));
  }
}

}  // namespace
}  // namespace hapton
