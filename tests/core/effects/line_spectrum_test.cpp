#include "core/effects/line_spectrum.h"

#include <gtest/gtest.h>

#include "tests/core/effects/made_textures.h"

namespace hapton {
namespace {

// Multiplied out by the book, for every order.
TEST(LineSpectrum, GivesTheCoefficients) {
  for (std::size_t order = 0; order <= kMostLines; ++order) {
    for (const double tilt : {0.0, 0.3, -0.3}) {
      const auto frequencies = made::frequencies(order, 0.3, 0.6, tilt);
      const auto expected = made::coefficients(frequencies);
      std::vector<double> cosines;
      for (const double frequency : frequencies) cosines.push_back(std::cos(frequency));
      std::vector<double> found(order);
      polynomial_of_lines(cosines, found);
      double largest = 1.0;
      for (const double c : expected) largest = std::max(largest, std::abs(c));
      for (std::size_t i = 0; i < order; ++i) EXPECT_NEAR(found[i], expected[i + 1], 1e-9 * largest) << order << " " << i;
    }
  }
}

// Two frequencies, by hand: Q = (1 + z^-1)(1 - 2 cos w_1 z^-1 + z^-2), P = (1 - z^-1)(1 - 2 cos w_2 z^-1 + z^-2).
TEST(LineSpectrum, OfTwoFrequencies) {
  std::array<double, 2> found = {};
  polynomial_of_lines(std::array{0.8, 0.2}, found);
  EXPECT_NEAR(found[0], -1.0, 1e-15);  // -cos w_1 - cos w_2
  EXPECT_NEAR(found[1], 0.4, 1e-15);   // 1 - cos w_1 + cos w_2
}

}  // namespace
}  // namespace hapton
