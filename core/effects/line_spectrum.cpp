#include "core/effects/line_spectrum.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>

namespace hapton {
namespace {

// Q and P of both polynomials, side by side in one vector.
using Lanes = Eigen::Array4d;

// Products of factors 1 - 2 cos w z^-1 + z^-2. Their coefficients read the same from both ends, so only the first half is computed, from
// c_0 = 1 to the middle. Two zeros stand in front of it.
using Halves = std::array<Lanes, kMaxLines / 2 + 3>;
constexpr std::size_t kFront = 2;

// The number of factors in a lane.
std::size_t factors_of(const std::array<const LineSpectrum*, 2>& both, int lane) noexcept {
  const std::size_t p = both[lane / 2]->cosines.size();
  return lane % 2 == 0 ? (p + 1) / 2 : p / 2;
}

// With the factors that have no frequency, Q reads the same from both ends, and P with the opposite sign: half of each gives all of C.
void write(const Halves& halves, int lane, const LineSpectrum& spectrum) noexcept {
  const std::size_t p = spectrum.cosines.size();
  const bool is_even = p % 2 == 0;
  const Lanes* c = halves.data() + kFront;
  for (std::size_t j = 1; j <= p / 2; ++j) {
    const double q = c[j][lane] + (is_even ? c[j - 1][lane] : 0.0);
    const double with_sign = c[j][lane + 1] - (is_even ? c[j - 1] : *(c + j - 2))[lane + 1];
    spectrum.coefficients[j - 1] = 0.5 * (q + with_sign);
    spectrum.coefficients[p - j] = 0.5 * (q - with_sign);
  }
  if (!is_even) spectrum.coefficients[p / 2] = 0.5 * c[p / 2 + 1][lane];
}

}  // namespace

void multiply_out(const LineSpectrum& first, const LineSpectrum& second) noexcept {
  const std::array<const LineSpectrum*, 2> both = {&first, &second};
  const std::size_t most = std::max(factors_of(both, 0), factors_of(both, 2));
  // A lane without a factor i stays as it is. All factors are laid out first: a vector loads slowly just after its lanes were written.
  std::array<Lanes, kMaxLines / 2> doubled_cosine, has_factor;
  for (int lane = 0; lane < 4; ++lane) {
    const std::size_t factors = factors_of(both, lane);
    for (std::size_t i = 0; i < most; ++i) {
      doubled_cosine[i][lane] = i < factors ? 2.0 * both[lane / 2]->cosines[2 * i + static_cast<std::size_t>(lane % 2)] : 0.0;
      has_factor[i][lane] = i < factors ? 1.0 : 0.0;
    }
  }
  Halves c;
  for (std::size_t j = 0; j < most + kFront + 1; ++j) c[j] = Lanes::Zero();
  c[kFront] = Lanes::Ones();
  for (std::size_t i = 0; i < most; ++i) {
    for (std::size_t j = std::min(most, 2 * i + 2) + kFront; j > kFront; --j)
      c[j] += has_factor[i] * c[j - 2] - doubled_cosine[i] * c[j - 1];
  }
  write(c, 0, first);
  write(c, 2, second);
}

}  // namespace hapton
