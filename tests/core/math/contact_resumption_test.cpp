#include "core/math/contact_resumption.h"

#include <gtest/gtest.h>

#include <limits>

namespace hapton {
namespace {

const Vec3 kProxy(0.01, 0.02, 0.05);
const Vec3 kOutward(0, 0, 0.002);

TEST(LeftContact, ADeviceBelowTheProxyIsStillInContact) {
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

TEST(LeftContact, ADeviceAtAnInvalidPositionHasLeft) {
  EXPECT_TRUE(has_left_contact(kProxy, kOutward, Vec3::Constant(std::numeric_limits<double>::quiet_NaN())));
}

constexpr std::int64_t kCycleNs = 1'000'000;

TEST(PathIsKnown, WithinReachAfterAnyTime) {
  EXPECT_TRUE(is_path_known(kProxy, kProxy + Vec3(0, 0.019, 0), 3600 * 1000 * kCycleNs));
  EXPECT_TRUE(is_path_known(kProxy, kProxy + Vec3(0, 0.019, 0), 0));
}

TEST(PathIsKnown, FartherOnlyInTimeAndNoFasterThanAHand) {
  const Vec3 far = kProxy + Vec3(0.03, 0, 0);
  EXPECT_TRUE(is_path_known(kProxy, far, 4 * kCycleNs)) << "7.5 m/s";
  EXPECT_FALSE(is_path_known(kProxy, far, 2 * kCycleNs)) << "15 m/s: the device was away";
  EXPECT_TRUE(is_path_known(kProxy, far, 19 * kCycleNs));
  EXPECT_FALSE(is_path_known(kProxy, far, 20 * kCycleNs)) << "a gap";
  EXPECT_FALSE(is_path_known(kProxy, far, -kCycleNs));
}

TEST(PathIsKnown, NotToAPlaceThatIsNoNumber) {
  EXPECT_FALSE(is_path_known(kProxy, Vec3::Constant(std::numeric_limits<double>::quiet_NaN()), kCycleNs));
}

}  // namespace
}  // namespace hapton
