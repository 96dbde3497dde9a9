#include "core/math/exact_cross.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <random>

namespace hapton {
namespace {

TEST(AccurateCross, NoLossByCancellation) {
  // (1 + e)(1 - e) - 1 * 1 = -e^2, which plain double arithmetic loses entirely.
  const double e = 0x1p-30;
  EXPECT_DOUBLE_EQ(difference_of_products(1.0 + e, 1.0 - e, 1.0, 1.0), -e * e);
  EXPECT_EQ((1.0 + e) * (1.0 - e) - 1.0, 0.0);
}

// Nearly parallel vectors of integers below 2^31: each product is below 2^62, so 64-bit integers give the exact cross product.
TEST(AccurateCross, OfNearlyParallelVectorsIsWithinTwoUnitsInTheLastPlace) {
  constexpr unsigned kSeed = 4211;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  std::uniform_int_distribution<std::int64_t> coordinate(-(std::int64_t{1} << 30), std::int64_t{1} << 30);
  std::uniform_int_distribution<int> exponent(1, 30);
  int plain_errors = 0;
  for (int i = 0; i < 20000; ++i) {
    const std::int64_t most = std::int64_t{1} << exponent(random);  // of the difference between the vectors
    std::uniform_int_distribution<std::int64_t> difference(-most, most);
    std::array<std::int64_t, 3> u, v;
    for (std::size_t k = 0; k < 3; ++k) {
      u[k] = coordinate(random);
      v[k] = u[k] + difference(random);
    }
    const Vec3 du(static_cast<double>(u[0]), static_cast<double>(u[1]), static_cast<double>(u[2]));
    const Vec3 dv(static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2]));
    const Vec3 cross = accurate_cross(du, dv);
    const Vec3 plain = du.cross(dv);
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t a = (k + 1) % 3;
      const std::size_t b = (k + 2) % 3;
      const auto exact = static_cast<long double>(u[a] * v[b] - u[b] * v[a]);
      const long double last_place = exact == 0.0L ? 0.0L : std::ldexp(1.0L, std::ilogb(exact) - 52);
      const auto error_of = [&](const Vec3& found) { return std::fabs(found[static_cast<Eigen::Index>(k)] - exact); };
      EXPECT_LE(error_of(cross), 2.0L * last_place) << i;
      plain_errors += error_of(plain) > 2.0L * last_place ? 1 : 0;
    }
  }
  EXPECT_GT(plain_errors, 20000);
}

}  // namespace
}  // namespace hapton
