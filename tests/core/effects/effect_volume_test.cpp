#include "core/effects/effect_volume.h"

#include <gtest/gtest.h>

#include <limits>

namespace hapton {
namespace {

TEST(EffectVolume, IsEverywhereABallOrABox) {
  EXPECT_TRUE(EffectVolume::everywhere().contains({1e9, -1e9, 0}));
  const auto ball = EffectVolume::ball({1, 2, 3}, 0.5);
  EXPECT_TRUE(ball.contains({1.5, 2, 3}));
  EXPECT_TRUE(ball.contains({1.25, 2.25, 3.25}));
  EXPECT_FALSE(ball.contains({1.51, 2, 3}));
  EXPECT_FALSE(ball.contains({1.3, 2.3, 3.3}));
  const auto box = EffectVolume::box({0, 0, 0}, {1, 2, 4});
  EXPECT_TRUE(box.contains({0, 2, 4}));
  EXPECT_TRUE(box.contains({0.5, 1, 2}));
  EXPECT_FALSE(box.contains({1.01, 1, 2}));
  EXPECT_FALSE(box.contains({0.5, 1, -0.01}));
}

TEST(EffectVolume, KnowsItsNearestPoint) {
  const auto ball = EffectVolume::ball({1, 2, 3}, 0.5);
  EXPECT_EQ(ball.nearest({1.1, 2.1, 3}), Vec3(1.1, 2.1, 3)) << "inside";
  EXPECT_LT((ball.nearest({1, 5, 7}) - Vec3(1, 2.3, 3.4)).norm(), 1e-15);
  EXPECT_EQ(ball.centre(), Vec3(1, 2, 3));
  const auto box = EffectVolume::box({0, 0, 0}, {1, 2, 4});
  EXPECT_EQ(box.nearest({0.5, 1, 2}), Vec3(0.5, 1, 2));
  EXPECT_EQ(box.nearest({3, -1, 2.5}), Vec3(1, 0, 2.5));
  EXPECT_EQ(EffectVolume::everywhere().nearest({7, 8, 9}), Vec3(7, 8, 9));
}

TEST(EffectVolume, ContainsNothingThatIsNotFinite) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(EffectVolume::ball(Vec3::Zero(), 1.0).contains({nan, 0, 0}));
  EXPECT_FALSE(EffectVolume::box(-Vec3::Ones(), Vec3::Ones()).contains({0, 0, nan}));
  EXPECT_FALSE(EffectVolume::ball(Vec3::Zero(), 1.0).contains({1e200, 0, 0}));
}

TEST(EffectVolume, NamesAllItsNumbers) {
  const auto numbers = [](const EffectVolume& volume) {
    std::vector<double> all;
    volume.for_each_number([&](double number) { all.push_back(number); });
    return all;
  };
  const auto ball = numbers(EffectVolume::ball({1, 2, 3}, 0.5));
  EXPECT_EQ(ball.size(), 7U);  // the shape, the centre and the sizes
  EXPECT_NE(ball, numbers(EffectVolume::ball({1, 2, 3}, 0.6)));
  EXPECT_NE(ball, numbers(EffectVolume::ball({1, 2, 4}, 0.5)));
  EXPECT_NE(ball, numbers(EffectVolume::box({0.5, 1.5, 2.5}, {1.5, 2.5, 3.5}))) << "of the same size";
  EXPECT_NE(ball, numbers(EffectVolume::everywhere()));
}

TEST(EffectVolume, IsMadeOfItsNumbers) {
  const auto numbers_of = [](const EffectVolume& volume) {
    std::array<double, 7> all = {};
    std::size_t n = 0;
    volume.for_each_number([&](double number) { all[n++] = number; });
    return all;
  };
  for (const EffectVolume& volume :
       {EffectVolume::everywhere(), EffectVolume::ball({1, 2, 3}, 0.5), EffectVolume::box({0.1, 0.2, 0.3}, {1.4, 2.5, 3.6})}) {
    const auto same = EffectVolume::from_numbers(numbers_of(volume));
    ASSERT_TRUE(same.has_value());
    EXPECT_EQ(numbers_of(*same), numbers_of(volume));
  }
  const auto changed = [&](std::size_t at, double number) {
    auto numbers = numbers_of(EffectVolume::ball({1, 2, 3}, 0.5));
    numbers[at] = number;
    return EffectVolume::from_numbers(numbers);
  };
  EXPECT_TRUE(changed(1, -7.0));
  for (const double shape : {-1.0, 0.5, 3.0}) EXPECT_FALSE(changed(0, shape)) << shape;
  EXPECT_FALSE(changed(2, std::numeric_limits<double>::quiet_NaN()));
  EXPECT_FALSE(changed(4, -0.1)) << "a size";
  EXPECT_FALSE(changed(5, std::numeric_limits<double>::infinity()));
}

}  // namespace
}  // namespace hapton
