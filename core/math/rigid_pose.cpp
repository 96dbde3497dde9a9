#include "core/math/rigid_pose.h"

namespace hapton {
namespace {

using Matrix34 = Eigen::Matrix<double, 3, 4>;

Matrix34 to_matrix(const std::array<float, 12>& X) noexcept {
  return Eigen::Map<const Eigen::Matrix<float, 3, 4, Eigen::RowMajor>>(X.data()).cast<double>();
}

// False if a number is NaN, because each comparison with NaN is false.
bool is_rigid(const Matrix34& X) noexcept {
  const Mat3 R = X.leftCols<3>();
  const Vec3 t = X.col(3);
  return t.allFinite() && t.cwiseAbs().maxCoeff() <= kMaxTranslationM &&
         (R * R.transpose() - Mat3::Identity()).cwiseAbs().sum() <= kRigidTolerance && R.determinant() > 0.0;
}

}  // namespace

bool is_rigid(const std::array<float, 12>& X) noexcept { return is_rigid(to_matrix(X)); }

std::optional<Pose> find_rigid_pose(const std::array<float, 12>& X) noexcept {
  const Matrix34 numbers = to_matrix(X);
  if (!is_rigid(numbers)) return std::nullopt;
  Pose pose = Pose::Identity();
  pose.linear() = Quat(Mat3(numbers.leftCols<3>())).normalized().toRotationMatrix();
  pose.translation() = numbers.col(3);
  return pose;
}

}  // namespace hapton
