#include "haptic_step/view_pose.h"

#include <limits>

namespace hapton {

std::optional<Pose> compute_view_pose(const std::array<float, 12>& X_WS) noexcept {
  // A turned knob box multiplies many rotations in single precision before it has to renormalise: a thousand roundings are let pass.
  constexpr double kTolerance = 1000.0 * std::numeric_limits<float>::epsilon();
  Mat3 rotation;
  Vec3 translation;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      rotation(row, column) = static_cast<double>(X_WS[static_cast<std::size_t>(4 * row + column)]);
    }
    translation[row] = static_cast<double>(X_WS[static_cast<std::size_t>(4 * row + 3)]);
  }
  if (!rotation.allFinite() || !translation.allFinite() || rotation.determinant() <= 0.0 ||
      !((rotation.transpose() * rotation - Mat3::Identity()).cwiseAbs().maxCoeff() <= kTolerance)) {
    return std::nullopt;
  }
  Pose pose = Pose::Identity();
  pose.linear() = Quat(rotation).normalized().toRotationMatrix();
  pose.translation() = translation;
  return pose;
}

}  // namespace hapton
