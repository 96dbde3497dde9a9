#include "patch/device_path.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

DevicePath path_of(std::size_t places) {
  DevicePath path;
  for (std::size_t i = 0; i < places; ++i) path.push({Vec3(static_cast<double>(i), 0.0, 0.0), 1e-3});
  return path;
}

TEST(DevicePath, GivesBackPlacesInTheirOrder) {
  DevicePath path = path_of(3);
  path.pop();
  path.push({Vec3(7.0, 0.0, 0.0), 2e-3});
  ASSERT_EQ(path.size(), 3U);
  for (const double x : {1.0, 2.0, 7.0}) {
    EXPECT_EQ(path.front().p_SD.x(), x);
    path.pop();
  }
  EXPECT_TRUE(path.empty());
}

TEST(DevicePath, KeepsTheNewestPlaces) {
  DevicePath path = path_of(100);
  path.keep_newest(1.0);
  EXPECT_EQ(path.size(), 100U);
  path.keep_newest(9.5e-3);
  ASSERT_EQ(path.size(), 10U) << "0 to 9 ms old";
  EXPECT_EQ(path.front().p_SD.x(), 90.0);
  path.keep_newest(0.0);
  EXPECT_TRUE(path.empty());
  path.keep_newest(1.0);
  EXPECT_TRUE(path.empty());
}

TEST(DevicePath, KeepsItsLengthItsTimeAndItsNewestPlaceWhenFull) {
  constexpr std::size_t kPlaces = 10 * DevicePath::kMax + 7;
  DevicePath path = path_of(kPlaces);
  EXPECT_LE(path.size(), DevicePath::kMax);
  EXPECT_EQ(path[path.size() - 1].p_SD.x(), static_cast<double>(kPlaces - 1));
  double time_s = path[0].dt_s;
  double widest_gap = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i) {
    const double gap = path[i].p_SD.x() - path[i - 1].p_SD.x();
    EXPECT_GT(gap, 0.0);
    EXPECT_NEAR(path[i].dt_s, 1e-3 * gap, 1e-9);
    widest_gap = std::max(widest_gap, gap);
    time_s += path[i].dt_s;
  }
  EXPECT_NEAR(time_s, 1e-3 * kPlaces, 1e-9);
  EXPECT_LE(widest_gap, 4.0 * kPlaces / DevicePath::kMax) << "no coarser at its old end than at its new one";
}

// A hand at rest adds no positions to the path, however long it rests, and its noise adds few.
TEST(DevicePath, ARestDisplacesNothingThatCameBefore) {
  DevicePath path = path_of(100);
  for (int i = 0; i < 5000; ++i) path.push({Vec3(99.0, 0.0, 0.0), 1e-3});
  EXPECT_LE(path.size(), 101U);
  EXPECT_EQ(path[path.size() - 1].p_SD.x(), 99.0);
  for (int i = 0; i < 5000; ++i) path.push({Vec3(99.0, i % 2 == 0 ? 1e-6 : -1e-6, 0.0), 1e-3});
  ASSERT_LE(path.size(), DevicePath::kMax);
  double widest_gap = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i) widest_gap = std::max(widest_gap, (path[i].p_SD - path[i - 1].p_SD).norm());
  EXPECT_LE(widest_gap, 4.0);
}

// The oldest position may be anywhere in the ring.
TEST(DevicePath, IsThinnedOutWhereverItBegins) {
  DevicePath path = path_of(DevicePath::kMax);
  for (int i = 0; i < 301; ++i) path.pop();
  for (std::size_t i = 0; path.size() < DevicePath::kMax; ++i) path.push({Vec3(static_cast<double>(DevicePath::kMax + i), 0.0, 0.0), 1e-3});
  path.push({Vec3(5000.0, 0.0, 0.0), 1e-3});
  ASSERT_EQ(path.size(), DevicePath::kMax / 2 + 1);
  // Of the positions from 301 on, every second one is left.
  for (std::size_t i = 0; i < DevicePath::kMax / 2; ++i) EXPECT_EQ(path[i].p_SD.x(), 302.0 + 2.0 * static_cast<double>(i));
  EXPECT_EQ(path[DevicePath::kMax / 2].p_SD.x(), 5000.0);
}

TEST(DevicePath, IsEmptyAfterAClear) {
  DevicePath path = path_of(5);
  path.clear();
  EXPECT_TRUE(path.empty());
  EXPECT_EQ(path.size(), 0U);
}

}  // namespace
}  // namespace hapton
