#include "core/effects/line_spectrum.h"

#include <array>

namespace hapton {
namespace {

// A product of factors 1 - 2 cos w z^-1 + z^-2. Its coefficients are the same from both ends, so only half of them are multiplied.
using Product = std::array<double, kMostLines + 3>;

// Of every second cosine from `first` on. Two zeros in front, for the coefficients below 0.
Product multiply(std::span<const double> cosines, std::size_t first) noexcept {
  Product product = {0.0, 0.0, 1.0};
  double* q = product.data() + 2;
  std::size_t factors = 0;
  for (std::size_t i = first; i < cosines.size(); i += 2) {
    const double twice = 2.0 * cosines[i];
    // The coefficient behind the middle is that in front of it.
    const double middle = 2.0 * q[static_cast<std::ptrdiff_t>(factors) - 1] - twice * q[factors];
    for (std::size_t j = factors; j >= 1; --j) q[j] += q[static_cast<std::ptrdiff_t>(j) - 2] - twice * q[j - 1];
    q[++factors] = middle;
  }
  for (std::size_t j = 1; j <= factors; ++j) q[factors + j] = q[factors - j];
  return product;
}

}  // namespace

void polynomial_of_lines(std::span<const double> cosines, std::span<double> coefficients) noexcept {
  const Product q_front = multiply(cosines, 0);
  const Product p_front = multiply(cosines, 1);
  const double* q = q_front.data() + 2;
  const double* p = p_front.data() + 2;
  const bool is_even = cosines.size() % 2 == 0;
  for (std::ptrdiff_t j = 1; j <= static_cast<std::ptrdiff_t>(cosines.size()); ++j) {
    const double rest = is_even ? q[j - 1] - p[j - 1] : -p[j - 2];
    coefficients[static_cast<std::size_t>(j) - 1] = 0.5 * (q[j] + p[j] + rest);
  }
}

}  // namespace hapton
