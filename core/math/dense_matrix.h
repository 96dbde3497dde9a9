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

}  // namespace hapton
