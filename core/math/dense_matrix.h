#pragma once

#include <Eigen/Core>
#include <complex>

namespace hapton {

using Complex = std::complex<double>;

// Functions of Eigen on matrices of any size, compiled only once: a source with these headers takes a minute to compile. RT: no.

// The matrix exponential e^a, by scaling and squaring (Higham 2005). Pre: a is square.
Eigen::MatrixXd compute_exponential(const Eigen::MatrixXd& a);

// The eigenvalues of a, in no particular order. Pre: a is square and finite.
Eigen::VectorXcd compute_eigenvalues(const Eigen::MatrixXd& a);

}  // namespace hapton
