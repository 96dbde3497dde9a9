#include "io_node/touch_chooser.h"

#include <gtest/gtest.h>

#include "tests/support/time_units.h"

namespace hapton {
namespace {

TEST(TouchChooser, ObeysAFixedChoice) {
  TouchChooser remote(TouchChoice::remote);
  TouchChooser patch(TouchChoice::patch);
  for (std::int64_t t = 0; t < 100; ++t) {
    EXPECT_FALSE(remote.choose_patch(1.0, t * kSecond));
    EXPECT_TRUE(patch.choose_patch(1e-4, t * kSecond));
  }
}

TEST(TouchChooser, AFastNetworkChangesNothing) {
  TouchChooser chooser(TouchChoice::automatic);
  for (std::int64_t t = 0; t < 100; ++t) EXPECT_FALSE(chooser.choose_patch(t % 2 == 0 ? 1e-4 : TouchChooser::kSlowS, t * kSecond));
  EXPECT_FALSE(chooser.choose_patch(-1.0, 101 * kSecond)) << "not known yet";
}

TEST(TouchChooser, GoesBackOnlyWhenItHasBeenFastForAWhile) {
  TouchChooser chooser(TouchChoice::automatic);
  EXPECT_TRUE(chooser.choose_patch(0.02, 100 * kSecond));
  EXPECT_TRUE(chooser.choose_patch(0.006, 101 * kSecond)) << "between the limits it stays";
  EXPECT_TRUE(chooser.choose_patch(0.001, 102 * kSecond));
  EXPECT_TRUE(chooser.choose_patch(0.006, 104 * kSecond));
  EXPECT_TRUE(chooser.choose_patch(0.001, 106 * kSecond));
  EXPECT_TRUE(chooser.choose_patch(-1.0, 120 * kSecond)) << "a new haptics node: not known again";
  EXPECT_TRUE(chooser.choose_patch(-1.0, 129 * kSecond));
  EXPECT_TRUE(chooser.choose_patch(0.001, 130 * kSecond)) << "the time in which it was not known does not count";
  EXPECT_FALSE(chooser.choose_patch(0.001, 133 * kSecond));
  EXPECT_TRUE(chooser.choose_patch(0.02, 134 * kSecond));
}

}  // namespace
}  // namespace hapton
