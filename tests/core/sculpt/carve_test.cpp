#include "core/sculpt/carve.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

TEST(Carve, RoundedHasNumbersThatAFloatCanHold) {
  const Carve carve{{0.1, -0.2, 1.0 / 3.0}, {1e-9, 0.7, 0.0}, 0.004};
  const Carve rounded_carve = rounded(carve);
  EXPECT_EQ(rounded_carve.from_m.x(), static_cast<double>(0.1F));
  EXPECT_EQ(rounded_carve.from_m.z(), static_cast<double>(static_cast<float>(1.0 / 3.0)));
  EXPECT_EQ(rounded_carve.to_m.y(), static_cast<double>(0.7F));
  EXPECT_EQ(rounded_carve.radius_m, static_cast<double>(0.004F));
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(rounded_carve.from_m[k], static_cast<double>(static_cast<float>(carve.from_m[k])));
    EXPECT_EQ(rounded_carve.to_m[k], static_cast<double>(static_cast<float>(carve.to_m[k])));
  }
  EXPECT_EQ(rounded(rounded_carve), rounded_carve);
  EXPECT_FALSE(rounded_carve == carve);
  EXPECT_FALSE(rounded_carve == (Carve{rounded_carve.from_m, rounded_carve.to_m, carve.radius_m})) << "differs in the radius alone";
}

}  // namespace
}  // namespace hapton
