#include "core/math/dense_matrix.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <utility>

namespace hapton {
namespace {

constexpr unsigned kMatrixSeed = 20261122;

Eigen::MatrixXd random_matrix(Eigen::Index n, std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  return Eigen::MatrixXd::NullaryExpr(n, n, [&] { return unit(random); });
}

TEST(DenseMatrix, TheExponentialIsItsSeries) {
  RecordProperty("seed", std::to_string(kMatrixSeed));
  std::mt19937_64 random(kMatrixSeed);
  for (const Eigen::Index n : {1, 2, 5, 12}) {
    const Eigen::MatrixXd a = random_matrix(n, random);
    Eigen::MatrixXd series = Eigen::MatrixXd::Identity(n, n);
    Eigen::MatrixXd term = series;
    for (int k = 1; k < 60; ++k) {
      term = term * a / k;
      series += term;
    }
    EXPECT_LE((compute_exponential(a) - series).norm(), 1e-13 * series.norm()) << "n " << n;
  }
}

TEST(DenseMatrix, TheExponentialOfARotationIsThatAngle) {
  Eigen::MatrixXd turn = Eigen::MatrixXd::Zero(2, 2);
  turn(0, 1) = -1000.0;
  turn(1, 0) = 1000.0;
  const Eigen::MatrixXd turned = compute_exponential(turn);
  EXPECT_NEAR(turned(0, 0), std::cos(1000.0), 1e-11);
  EXPECT_NEAR(turned(1, 0), std::sin(1000.0), 1e-11);
}

TEST(DenseMatrix, EigenvaluesAreThoseThatTheMatrixWasMadeOf) {
  RecordProperty("seed", std::to_string(kMatrixSeed));
  std::mt19937_64 random(kMatrixSeed);
  // Two real eigenvalues and a conjugate pair.
  Eigen::MatrixXd blocks = Eigen::MatrixXd::Zero(4, 4);
  blocks.diagonal() << -3.0, 0.25, 1.0, 1.0;
  blocks(2, 3) = -2.0;
  blocks(3, 2) = 2.0;
  const Eigen::MatrixXd exponent = random_matrix(4, random);
  Eigen::VectorXcd found = compute_eigenvalues(compute_exponential(exponent) * blocks * compute_exponential(-exponent));
  std::sort(found.begin(), found.end(),
            [](const auto& a, const auto& b) { return std::pair(a.real(), a.imag()) < std::pair(b.real(), b.imag()); });
  const std::complex<double> expected[] = {-3.0, 0.25, {1.0, -2.0}, {1.0, 2.0}};
  ASSERT_EQ(found.size(), 4);
  // The real parts of the pair are equal except for rounding, so the sorted order of the two may be either.
  if (found[2].imag() > 0.0) std::swap(found[2], found[3]);
  for (int i = 0; i < 4; ++i) EXPECT_LE(std::abs(found[i] - expected[i]), 1e-12) << i;
}

}  // namespace
}  // namespace hapton
