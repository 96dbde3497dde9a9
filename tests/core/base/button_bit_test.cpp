#include "core/base/button_bit.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

TEST(ButtonBit, ButtonsCountFromOne) {
  EXPECT_EQ(button_bit(1), 1U);
  EXPECT_EQ(button_bit(3), 4U);
  EXPECT_EQ(button_bit(32), 0x80000000U);
  for (const int none : {0, -1, 33}) EXPECT_EQ(button_bit(none), 0U) << none;
}

}  // namespace
}  // namespace hapton
