#include "vision_node/shown_notice.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

TEST(ShownNotice, IsThereForAWhileOrUntilTheNext) {
  ShownNotice notice;
  EXPECT_FALSE(notice.update("", 1));
  EXPECT_TRUE(notice.update("saved", 1000));
  EXPECT_EQ(notice.line(), "saved");
  EXPECT_FALSE(notice.update("", 1000 + ShownNotice::kShownNs - 1));
  EXPECT_TRUE(notice.update("exported", 2000));
  EXPECT_EQ(notice.line(), "exported");
  EXPECT_FALSE(notice.update("", 1000 + ShownNotice::kShownNs));
  EXPECT_TRUE(notice.update("", 2000 + ShownNotice::kShownNs));
  EXPECT_EQ(notice.line(), "");
  EXPECT_FALSE(notice.update("", 3000 + ShownNotice::kShownNs));
}

}  // namespace
}  // namespace hapton
