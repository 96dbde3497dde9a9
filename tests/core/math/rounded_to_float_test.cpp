#include "core/math/rounded_to_float.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "core/math/types.h"

namespace hapton {
namespace {

TEST(RoundedToFloat, IsTheNearestNumberOfSinglePrecision) {
  EXPECT_EQ(rounded_to_float(0.5), 0.5);
  EXPECT_EQ(rounded_to_float(-1.0 - 0x1p-23), -1.0 - 0x1p-23);
  EXPECT_EQ(rounded_to_float(1.0 + 0x1p-25), 1.0);
  EXPECT_EQ(rounded_to_float(1.0 + 0x1.8p-24), 1.0 + 0x1p-23);
}

// In a loop that stores three numbers, which are then read back, the compiler vectorises the conversions.
[[gnu::noinline]] double store_and_find_error(std::array<float, 3>& stored, const Vec3& p) {
  for (int i = 0; i < 3; ++i) stored[static_cast<std::size_t>(i)] = static_cast<float>(rounded_to_float(p[i]));
  return (Vec3(stored[0], stored[1], stored[2]) - p).norm();
}

TEST(RoundedToFloat, WhatIsStoredIsWhatIsComputedWith) {
  std::array<float, 3> stored = {};
  // The errors are 2^-25, 2^-26 and 2^-26 + 2^-27.
  const double error = store_and_find_error(stored, {1.0 + 0x1p-25, 0.5 - 0x1p-26, 1.0 - 0x1p-26 - 0x1p-27});
  const Vec3 expected_error(1.0 + 0x1p-25 - stored[0], 0.5 - 0x1p-26 - stored[1], 1.0 - 0x1p-26 - 0x1p-27 - stored[2]);
  EXPECT_EQ(error, expected_error.norm());
  EXPECT_GT(error, 0x1p-26);
}

}  // namespace
}  // namespace hapton
