#include "core/math/find_zero.h"

#include <gtest/gtest.h>

#include <limits>

namespace hapton {
namespace {

TEST(FindZero, FindsTheZeroOfFallingFunctions) {
  const auto cosine = [](double t) { return std::cos(t); };
  EXPECT_NEAR(find_zero(0.0, 1.0, 3.0, std::cos(3.0), 0x1p-51, cosine), std::acos(0.0), 1e-14);
  const auto steep = [](double t) { return 1e-3 - t * t * t * t * t; };
  EXPECT_NEAR(find_zero(0.0, 1e-3, 1.0, steep(1.0), 0x1p-51, steep), std::pow(1e-3, 0.2), 1e-12);
}

TEST(FindZero, ALineTakesOneEvaluation) {
  int calls = 0;
  const double zero = find_zero(0.0, 1.0, 4.0, -3.0, 0x1p-51, [&](double t) {
    ++calls;
    return 1.0 - t;
  });
  EXPECT_EQ(zero, 1.0);
  EXPECT_EQ(calls, 1);
}

TEST(FindZero, AFunctionThatStartsAtOrBelowZeroHasItsZeroThere) {
  const auto must_not_be_called = [](double) -> double {
    ADD_FAILURE() << "the function is evaluated";
    return 0.0;
  };
  EXPECT_EQ(find_zero(0.25, 0.0, 1.0, -1.0, 0.0, must_not_be_called), 0.25);
  EXPECT_EQ(find_zero(0.25, -1.0, 1.0, -1.0, 0.0, must_not_be_called), 0.25);
}

TEST(FindZero, EndsWhereTheFunctionIsNotANumberAndAtItsLimitOfEvaluations) {
  int calls = 0;
  find_zero(0.0, 1.0, 1.0, -1.0, 0.0, [&](double) {
    ++calls;
    return std::numeric_limits<double>::quiet_NaN();
  });
  EXPECT_EQ(calls, 1);
  calls = 0;
  find_zero(0.0, 1.0, 1.0, -1.0, 0.0, [&](double t) {
    ++calls;
    return t < 1.0 / 3.0 ? 1.0 : -1.0;
  });
  EXPECT_LE(calls, 40);
}

}  // namespace
}  // namespace hapton
