#include "core/math/exact_cross.h"

#include <gtest/gtest.h>

#include <random>

namespace hapton {
namespace {

TEST(AccurateCross, NoLossByCancellation) {
  // (1 + e)(1 - e) - 1 * 1 = -e^2, which plain double arithmetic loses entirely.
  const double e = 0x1p-30;
  EXPECT_DOUBLE_EQ(difference_of_products(1.0 + e, 1.0 - e, 1.0, 1.0), -e * e);
  EXPECT_EQ((1.0 + e) * (1.0 - e) - 1.0, 0.0);
}

TEST(AccurateCross, AgreesWithLongDoubleOnNeedles) {
  constexpr unsigned kSeed = 4211;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> coordinate(-1.0, 1.0);
  for (int i = 0; i < 20000; ++i) {
    const Vec3 u(coordinate(random), coordinate(random), coordinate(random));
    const Vec3 v = u + Vec3(coordinate(random), coordinate(random), coordinate(random)) * 1e-9;
    const Vec3 cross = accurate_cross(u, v);
    for (int k = 0; k < 3; ++k) {
      const int a = (k + 1) % 3;
      const int b = (k + 2) % 3;
      const long double exact = static_cast<long double>(u[a]) * v[b] - static_cast<long double>(u[b]) * v[a];
      // long double itself rounds a product, with an error of up to 2^-64 of it.
      const long double reference_error = 0x1p-63L * std::fabs(static_cast<long double>(u[a]) * v[b]);
      EXPECT_LE(std::fabs(static_cast<long double>(cross[k]) - exact), 0x1p-51L * std::fabs(exact) + reference_error);
    }
  }
}

}  // namespace
}  // namespace hapton
