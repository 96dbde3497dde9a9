#include "safety/passivity_observer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace hapton {
namespace {

TEST(PassivityObserver, CountsWhatWasTakenAndGivenBack) {
  PassivityObserver observer({.most_saved_j = 1.0});
  observer.observe(0.0);
  // 1 mm against 2 N: the device took 2 mJ.
  observer.held(2.0, 1e-3);
  observer.observe(-1e-3);
  EXPECT_DOUBLE_EQ(observer.energy_j(), 2e-3);
  EXPECT_DOUBLE_EQ(observer.velocity_m_per_s(), -1.0);
  // Back along 3 N: it gave 3 mJ.
  observer.held(3.0, 1e-3);
  observer.observe(0.0);
  EXPECT_NEAR(observer.energy_j(), -1e-3, 1e-15);
}

TEST(PassivityObserver, TakesTheMeanOfAForceThatChanged) {
  PassivityObserver observer({});
  observer.observe(0.0);
  observer.held(1.0, 0.25e-3);
  observer.held(5.0, 0.75e-3);
  observer.observe(1e-3);
  EXPECT_DOUBLE_EQ(observer.energy_j(), -4e-3);
}

TEST(PassivityObserver, CreditsTheDevicesOwnDamping) {
  PassivityObserver observer({.device_damping_ns_per_m = 2.0});
  observer.observe(0.0);
  observer.held(0.0, 1e-3);
  observer.observe(1e-3);
  EXPECT_DOUBLE_EQ(observer.energy_j(), 2e-3);
}

TEST(PassivityObserver, SavesUpNoMoreThanItMay) {
  PassivityObserver observer({.most_saved_j = 0.01});
  observer.observe(0.0);
  for (int i = 1; i < 100; ++i) {
    observer.held(10.0, 1e-3);
    observer.observe(-1e-3 * i);
  }
  EXPECT_EQ(observer.energy_j(), 0.01);
}

TEST(PassivityObserver, IgnoresAPositionThatIsNoNumber) {
  PassivityObserver observer({});
  observer.observe(0.0);
  observer.held(1.0, 1e-3);
  observer.observe(std::numeric_limits<double>::quiet_NaN());
  observer.held(1.0, 1e-3);
  observer.observe(1e-3);
  EXPECT_DOUBLE_EQ(observer.energy_j(), -1e-3);
}

}  // namespace
}  // namespace hapton
