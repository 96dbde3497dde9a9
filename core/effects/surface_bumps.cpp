#include "core/effects/surface_bumps.h"

#include <cmath>
#include <numbers>

namespace hapton {
namespace {

constexpr double kTwoPi = 2.0 * std::numbers::pi;

}  // namespace

double SurfaceBumps::slope() const noexcept { return std::numbers::pi * height_m / length_m; }

double SurfaceBumps::height_at(const Vec3& p_SP) const noexcept {
  const double per_m = kTwoPi / length_m;
  const double wave = pattern == Pattern::ridges ? std::cos(per_m * p_SP.dot(direction)) : (per_m * p_SP).array().cos().sum() / 3.0;
  return -0.5 * height_m * (1.0 - wave);
}

Vec3 SurfaceBumps::gradient_at(const Vec3& p_SP) const noexcept {
  const double per_m = kTwoPi / length_m;
  const double amplitude = -0.5 * height_m * per_m;
  if (pattern == Pattern::ridges) return (amplitude * std::sin(per_m * p_SP.dot(direction))) * direction;
  return (amplitude / 3.0) * (per_m * p_SP).array().sin().matrix();
}

}  // namespace hapton
