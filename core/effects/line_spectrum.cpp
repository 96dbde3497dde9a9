#include "core/effects/line_spectrum.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>

namespace hapton {
namespace {

// Q and P of both polynomials, side by side in one vector.
using Lanes = Eigen::Array4d;

// Products of factors 1 - 2 cos w z^-1 + z^-2. Coefficients are the same from both ends, so only the first half is multiplied, from c_0 = 1
// to the middle. In front of it two zeros.
using Halves = std::array<Lanes, kMostLines / 2 + 3>;
constexpr std::size_t kFront = 2;

// The number of factors of the lane.
std::size_t factors_of(const std::array<const LineSpectrum*, 2>& both, int lane) noexcept {
  const std::size_t p = both[lane / 2]->cosines.size();
  return lane % 2 == 0 ? (p + 1) / 2 : p / 2;
}

void write(const Halves& halves, int lane, const LineSpectrum& spectrum) noexcept {
  const auto p = static_cast<std::ptrdiff_t>(spectrum.cosines.size());
  // c_j of a product of n factors; zero below its first and above its last.
  const auto at = [&](int side, std::ptrdiff_t n, std::ptrdiff_t j) {
    const std::ptrdiff_t near = std::min(j, 2 * n - j);
    return near < 0 ? 0.0 : halves[static_cast<std::size_t>(near) + kFront][lane + side];
  };
  const auto q = [&](std::ptrdiff_t j) { return at(0, (p + 1) / 2, j); };
  const auto m = [&](std::ptrdiff_t j) { return at(1, p / 2, j); };
  for (std::ptrdiff_t j = 1; j <= p; ++j) {
    const double rest = p % 2 == 0 ? q(j - 1) - m(j - 1) : -m(j - 2);
    spectrum.coefficients[static_cast<std::size_t>(j) - 1] = 0.5 * (q(j) + m(j) + rest);
  }
}

}  // namespace

void multiply_out(const LineSpectrum& first, const LineSpectrum& second) noexcept {
  const std::array<const LineSpectrum*, 2> both = {&first, &second};
  const std::size_t most = std::max(factors_of(both, 0), factors_of(both, 2));
  Halves c;
  for (std::size_t j = 0; j < most + kFront + 1; ++j) c[j] = Lanes::Zero();
  c[kFront] = Lanes::Ones();
  for (std::size_t i = 0; i < most; ++i) {
    // A lane that has no such factor stays as it is.
    Lanes twice = Lanes::Zero();
    Lanes has = Lanes::Zero();
    for (int lane = 0; lane < 4; ++lane) {
      if (i >= factors_of(both, lane)) continue;
      twice[lane] = 2.0 * both[lane / 2]->cosines[2 * i + static_cast<std::size_t>(lane % 2)];
      has[lane] = 1.0;
    }
    for (std::size_t j = most + kFront; j > kFront; --j) c[j] += has * c[j - 2] - twice * c[j - 1];
  }
  write(c, 0, first);
  write(c, 2, second);
}

}  // namespace hapton
