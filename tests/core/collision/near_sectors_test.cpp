#include "core/collision/near_sectors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>
#include <utility>

namespace hapton {
namespace {

using Pairs = std::set<std::pair<std::uint32_t, std::uint32_t>>;

Pairs pairs_of(const std::vector<NearSectors::Edges>& sectors, double angle) {
  Pairs pairs;
  NearSectors(sectors, angle).visit_pairs([&](std::uint32_t i, std::uint32_t j) {
    EXPECT_TRUE(pairs.insert(std::minmax(i, j)).second) << "twice: " << i << ", " << j;
  });
  return pairs;
}

// The least angle between samples of two sectors: an upper bound of the least angle between the sectors.
double sampled_angle(const NearSectors::Edges& a, const NearSectors::Edges& b) {
  constexpr int kSamples = 60;
  double least = 4.0;
  for (int i = 0; i <= kSamples; ++i) {
    const Vec3 p = a[0].normalized() + i / double{kSamples} * (a[1].normalized() - a[0].normalized());
    for (int j = 0; j <= kSamples; ++j) {
      const Vec3 q = b[0].normalized() + j / double{kSamples} * (b[1].normalized() - b[0].normalized());
      least = std::min(least, std::atan2(p.cross(q).norm(), p.dot(q)));
    }
  }
  return least;
}

TEST(NearSectors, NoPairThatIsNearIsLeftOut) {
  std::mt19937_64 random(2401);
  std::normal_distribution<double> normal;
  const auto draw = [&] { return Vec3(normal(random), normal(random), normal(random)); };
  int found = 0;
  int left_out = 0;
  for (int round = 0; round < 60; ++round) {
    std::vector<NearSectors::Edges> sectors;
    const double width = std::pow(10.0, -round % 4);
    for (int i = 0; i < 12; ++i) {
      const Vec3 first = draw();
      sectors.push_back({first, Vec3(1e3 * (first + width * draw()))});
    }
    if (round % 5 == 0) sectors[3][1] = sectors[4][0];
    if (round % 5 == 1) sectors[3][0] = -sectors[3][1];
    if (round % 5 == 2) sectors[3][0] = Vec3::Zero();
    const Pairs pairs = pairs_of(sectors, 1e-3);
    for (std::uint32_t i = 0; i < sectors.size(); ++i) {
      for (std::uint32_t j = i + 1; j < sectors.size(); ++j) {
        if (sectors[i][0].isZero(0.0) || pairs.contains({i, j})) continue;
        EXPECT_GT(sampled_angle(sectors[i], sectors[j]), 1e-3) << "round " << round << ", seed 2401";
        ++left_out;
      }
    }
    found += static_cast<int>(pairs.size());
  }
  EXPECT_GT(found, 100);
  EXPECT_GT(left_out, 1000);
}

// In a closed fan only neighbours are near, however long the arcs are.
TEST(NearSectors, FewPairsOfAFanAreFound) {
  for (const double lift : {0.0, 0.05, 0.5, 5.0}) {
    constexpr int kCount = 3000;
    std::vector<NearSectors::Edges> sectors;
    const auto corner = [&](int i) {
      const double angle = 2.0 * 3.14159265358979 * (i % kCount) / kCount;
      return Vec3(std::cos(angle), std::sin(angle), i % 2 == 0 ? lift : -lift);
    };
    for (int i = 0; i < kCount; ++i) sectors.push_back({corner(i), corner(i + 1)});
    EXPECT_LT(pairs_of(sectors, 1e-6).size(), 8U * kCount) << "lift " << lift;
  }
}

}  // namespace
}  // namespace hapton
