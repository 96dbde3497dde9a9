#include "core/tool/motion_energy.h"

#include <cmath>

#include <Eigen/Eigenvalues>

namespace hapton {
namespace {

// Bounds of the curvature along a step, in multiples of the coupling's own: these bound how much contacts make a step longer or shorter.
constexpr double kMinCurvature = 0.125;
constexpr double kMaxCurvature = 64.0;

Vec6 units(double turn_length) { return (Vec6() << Vec3::Ones(), Vec3::Constant(1.0 / turn_length)).finished(); }

}  // namespace

void MotionEnergy::set_plain() noexcept {
  const Vec6 unit = units(turn_length_);
  root_ = unit.cwiseInverse().asDiagonal();
  inverse_root_ = unit.asDiagonal();
}

Mat6 MotionEnergy::coupling_curvature() const noexcept {
  Mat6 curvature = Mat6::Identity();
  curvature.bottomRightCorner<3, 3>() *= turn_length_ * turn_length_;
  return curvature;
}

void MotionEnergy::set_curvature(const Mat6& curvature) noexcept {
  // Works in coordinates in which the coupling's own curvature is the identity.
  const Vec6 unit = units(turn_length_);
  const Eigen::SelfAdjointEigenSolver<Mat6> solver(unit.asDiagonal() * curvature * unit.asDiagonal());
  if (solver.info() != Eigen::Success) return set_plain();
  const Vec6 roots = solver.eigenvalues().cwiseMax(kMinCurvature).cwiseMin(kMaxCurvature).cwiseSqrt();
  const Mat6& axes = solver.eigenvectors();
  // This root is not symmetric: any root with root^T root = curvature will do.
  root_ = roots.asDiagonal() * axes.transpose() * unit.cwiseInverse().asDiagonal();
  inverse_root_ = unit.asDiagonal() * axes * roots.cwiseInverse().asDiagonal();
}

double MotionEnergy::length(const RigidMotion& motion) const noexcept {
  return std::sqrt(motion.shift.squaredNorm() + turn_length_ * turn_length_ * motion.turn.squaredNorm());
}

Vec6 MotionEnergy::to_coordinates(const RigidMotion& motion) const noexcept { return root_ * motion.shift_and_turn(); }

RigidMotion MotionEnergy::to_motion(const Placement& from, const Vec6& y) const noexcept {
  const Vec6 motion = inverse_root_ * y;
  return {from, motion.head<3>(), motion.tail<3>()};
}

Vec6 MotionEnergy::goal_of(const RigidMotion& wanted) const noexcept {
  Vec6 pull;
  pull << wanted.shift, turn_length_ * turn_length_ * wanted.turn;
  return inverse_root_.transpose() * pull;
}

}  // namespace hapton
