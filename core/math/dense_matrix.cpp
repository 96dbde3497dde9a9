#include "core/math/dense_matrix.h"

#include <Eigen/Eigenvalues>
#include <unsupported/Eigen/MatrixFunctions>

namespace hapton {

Eigen::MatrixXd compute_exponential(const Eigen::MatrixXd& a) { return a.exp(); }

Eigen::VectorXcd compute_eigenvalues(const Eigen::MatrixXd& a) { return Eigen::EigenSolver<Eigen::MatrixXd>(a, false).eigenvalues(); }

}  // namespace hapton
