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

TEST(DevicePath, KeepsItsLengthItsTimeAndItsNewestPlaceWhenFull) {
  constexpr std::size_t kPlaces = 10 * DevicePath::kMost + 7;
  DevicePath path = path_of(kPlaces);
  EXPECT_LE(path.size(), DevicePath::kMost);
  EXPECT_EQ(path[path.size() - 1].p_SD.x(), static_cast<double>(kPlaces - 1));
  double time_s = 0.0;
  double before = -1.0;
  for (std::size_t i = 0; i < path.size(); ++i) {
    EXPECT_GT(path[i].p_SD.x(), before);
    before = path[i].p_SD.x();
    time_s += path[i].dt_s;
  }
  EXPECT_NEAR(time_s, 1e-3 * kPlaces, 1e-9);
}

// The ring begins anywhere.
TEST(DevicePath, IsThinnedOutWhereverItBegins) {
  DevicePath path = path_of(DevicePath::kMost);
  for (int i = 0; i < 301; ++i) path.pop();
  for (std::size_t i = 0; path.size() < DevicePath::kMost; ++i)
    path.push({Vec3(static_cast<double>(DevicePath::kMost + i), 0.0, 0.0), 1e-3});
  path.push({Vec3(5000.0, 0.0, 0.0), 1e-3});
  ASSERT_EQ(path.size(), DevicePath::kMost / 2 + 1);
  for (std::size_t i = 0; i < DevicePath::kMost / 2; ++i) EXPECT_EQ(path[i].p_SD.x(), 302.0 + 2.0 * static_cast<double>(i));
  EXPECT_EQ(path[DevicePath::kMost / 2].p_SD.x(), 5000.0);
}

TEST(DevicePath, IsEmptyAfterAClear) {
  DevicePath path = path_of(5);
  path.clear();
  EXPECT_TRUE(path.empty());
  EXPECT_EQ(path.size(), 0U);
}

}  // namespace
}  // namespace hapton
