#include "core/collision/fdh_directions.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

template <int K>
void expect_projections_match_axes() {
  const Vec3 p(0.25, -3.0, 7.5);
  const auto along = fdh_project<K>(p);
  for (int i = 0; i < K / 2; ++i) {
    const auto& axis = FdhDirections<K>::kAxis[i];
    EXPECT_EQ(along[i], axis[0] * p.x() + axis[1] * p.y() + axis[2] * p.z()) << "K " << K << " axis " << i;
    for (int j = 0; j < i; ++j) {
      const auto& other = FdhDirections<K>::kAxis[j];
      EXPECT_NE(axis, other);
      EXPECT_FALSE(axis[0] == -other[0] && axis[1] == -other[1] && axis[2] == -other[2]) << "K " << K << " axes " << i << " and " << j;
    }
  }
  for (int i = 0; i < 3; ++i) EXPECT_EQ(FdhDirections<K>::length_squared(i), 1) << "the box comes first";
}

TEST(FdhDirections, ProjectionsAreThoseOfTheAxes) {
  expect_projections_match_axes<6>();
  expect_projections_match_axes<14>();
  expect_projections_match_axes<18>();
  expect_projections_match_axes<26>();
}

template <int K>
bool overlap(const FdhHull<K>& a, const FdhHull<K>& b) {
  for (int i = 0; i < K / 2; ++i) {
    if (!(a.low[i] <= b.high[i] && b.low[i] <= a.high[i])) return false;
  }
  return true;
}

TEST(FdhHull, SeparatesWhatItsBoxCannot) {
  FdhHull<6> box;
  FdhHull<14> hull;
  for (const Vec3& p : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)}) {
    box.add(p);
    hull.add(p);
  }
  FdhHull<6> corner_box;
  FdhHull<14> corner_hull;
  corner_box.add({0.9, 0.9, 0.9});
  corner_hull.add({0.9, 0.9, 0.9});
  EXPECT_TRUE(overlap(box, corner_box));
  EXPECT_FALSE(overlap(hull, corner_hull));
  EXPECT_FALSE(overlap(hull, FdhHull<14>())) << "an empty hull overlaps nothing";
}

}  // namespace
}  // namespace hapton
