#pragma once

#include <Eigen/Core>
#include <complex>

namespace hapton {

using Complex = std::complex<double>;

// Eigen's solvers for matrices of any size, compiled once: a source that includes them takes a minute. RT: no.

// e^a. Pre: a is square. Scaling and squaring (Higham 2005).
Eigen::MatrixXd compute_exponential(const Eigen::MatrixXd& a);

// In no order. Pre: a is square and finite.
Eigen::VectorXcd compute_eigenvalues(const Eigen::MatrixXd& a);

// x with a x = b, by an LU decomposition with partial pivoting. Pre: a is square and regular, with as many rows as b.
Eigen::VectorXcd solve(const Eigen::MatrixXcd& a, const Eigen::VectorXcd& b);

}  // namespace hapton
