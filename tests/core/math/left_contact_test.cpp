#include "core/math/left_contact.h"

#include <gtest/gtest.h>

#include <limits>

namespace hapton {
namespace {

const Vec3 kProxy(0.01, 0.02, 0.05);
const Vec3 kOutward(0, 0, 0.002);

TEST(LeftContact, ADeviceBelowTheProxyIsStillIn) {
  EXPECT_FALSE(has_left_contact(kProxy, kOutward, kProxy - kOutward));
  EXPECT_FALSE(has_left_contact(kProxy, kOutward, kProxy + Vec3(0.01, 0, -1e-9)));
  EXPECT_FALSE(has_left_contact(kProxy, 1e-12 * kOutward, kProxy + Vec3(0, 0, -0.01)));
}

TEST(LeftContact, ADeviceOnThePlaneOrBeyondHasLeft) {
  EXPECT_TRUE(has_left_contact(kProxy, kOutward, kProxy));
  EXPECT_TRUE(has_left_contact(kProxy, kOutward, kProxy + Vec3(-0.01, 0.003, 1e-9)));
  EXPECT_TRUE(has_left_contact(kProxy, 1e-12 * kOutward, kProxy + Vec3(0, 0, 0.005)));
}

TEST(LeftContact, WithoutADirectionNothingIsKnown) { EXPECT_FALSE(has_left_contact(kProxy, Vec3::Zero(), kProxy + Vec3(0, 0, 0.005))); }

TEST(LeftContact, APlaceThatIsNoneHasLeft) {
  EXPECT_TRUE(has_left_contact(kProxy, kOutward, Vec3::Constant(std::numeric_limits<double>::quiet_NaN())));
}

}  // namespace
}  // namespace hapton
