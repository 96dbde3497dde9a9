#include "core/effects/line_spectrum.h"

#include <gtest/gtest.h>

#include "tests/core/effects/made_textures.h"

namespace hapton {
namespace {

std::vector<double> cosines_of(const std::vector<double>& frequencies) {
  std::vector<double> cosines;
  for (const double frequency : frequencies) cosines.push_back(std::cos(frequency));
  return cosines;
}

// `expected` begins with the first coefficient, which is 1; `found` begins with the second one.
void expect_near(const std::vector<double>& found, const std::vector<double>& expected) {
  ASSERT_EQ(found.size() + 1, expected.size());
  double largest = 1.0;
  for (const double c : expected) largest = std::max(largest, std::abs(c));
  for (std::size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i], expected[i + 1], 1e-9 * largest) << found.size() << " " << i;
}

// For every order, compared with the polynomials that made::coefficients multiplies out by the definition.
TEST(LineSpectrum, GivesTheCoefficients) {
  for (std::size_t order = 0; order <= kMaxLines; ++order) {
    for (const double tilt : {0.0, 0.3, -0.3}) {
      const auto frequencies = made::frequencies(order, 0.3, 0.6, tilt);
      // multiply_out takes two polynomials: each order is paired with another one.
      const auto others = made::frequencies((order * 7 + 3) % (kMaxLines + 1), 0.6, 0.4);
      std::vector<double> found(order), other(others.size());
      multiply_out({cosines_of(frequencies), found}, {cosines_of(others), other});
      expect_near(found, made::coefficients(frequencies));
      expect_near(other, made::coefficients(others));
    }
  }
}

// Two frequencies, by hand: Q = (1 + z^-1)(1 - 2 cos w_1 z^-1 + z^-2), P = (1 - z^-1)(1 - 2 cos w_2 z^-1 + z^-2).
TEST(LineSpectrum, OfTwoFrequencies) {
  std::array<double, 2> found = {};
  const std::array cosines = {0.8, 0.2};
  multiply_out({cosines, found}, {});
  EXPECT_NEAR(found[0], -1.0, 1e-15);  // -cos w_1 - cos w_2
  EXPECT_NEAR(found[1], 0.4, 1e-15);   // 1 - cos w_1 + cos w_2
}

}  // namespace
}  // namespace hapton
