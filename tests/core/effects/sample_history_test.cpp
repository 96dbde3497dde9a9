#include "core/effects/sample_history.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/effects/white_noise.h"

namespace hapton {
namespace {

TEST(SampleHistory, SumsThePastByItsCoefficients) {
  for (std::size_t count = 0; count <= kMaxLines; ++count) {
    std::vector<double> coefficients;
    for (std::size_t i = 0; i < count; ++i) coefficients.push_back(white_noise(1, i));
    SampleHistory history;
    std::vector<double> samples;
    for (std::size_t n = 0; n < 200; ++n) {
      double expected = 0.0;
      for (std::size_t i = 0; i < std::min(count, n); ++i) expected += coefficients[i] * samples[n - 1 - i];
      ASSERT_NEAR(history.sum(coefficients), expected, 1e-12) << count << " " << n;
      samples.push_back(white_noise(2, n));
      history.push(samples.back());
    }
    history.reset();
    EXPECT_EQ(history.sum(coefficients), 0.0);
  }
}

}  // namespace
}  // namespace hapton
