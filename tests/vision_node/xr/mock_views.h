#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "core/math/types.h"
#include "vision_node/xr/eye_frustum.h"

// What the eyes of the mock headset see in frame n: a head that moves and turns, with displays that are canted and not symmetric.
namespace hapton::mock_xr {

inline constexpr std::int64_t kFirstFrameNs = 5'000'000'000;
inline constexpr std::int64_t kPeriodNs = 11'111'111;  // 90 Hz
// The origin of LOCAL in frame STAGE: the stage's origin is on the floor below the eyes, a little to the left and ahead.
inline const Vec3 kLocalInStage(0.05, 1.3, 0.05);

inline double radians(double degrees) { return degrees * std::numbers::pi / 180.0; }

// The pose of the head in frame LOCAL.
inline Pose head_at(int frame) {
  const double t = 0.6 * frame;
  const Vec3 p(0.04 * std::sin(t), 0.03 * std::cos(1.3 * t), 0.02 * std::sin(0.7 * t));
  const Quat turned = Eigen::AngleAxisd(radians(6.0) * std::sin(t), Vec3::UnitY()) *
                      Eigen::AngleAxisd(radians(-12.0) + radians(5.0) * std::cos(t), Vec3::UnitX()) *
                      Eigen::AngleAxisd(radians(8.0) * std::sin(1.7 * t), Vec3::UnitZ());
  return Eigen::Translation3d(p) * Pose(turned);
}

inline std::array<EyeInFrame, 2> eyes_at(int frame) {
  const Pose X_LH = head_at(frame);
  std::array<EyeInFrame, 2> eyes;
  for (std::size_t i = 0; i < 2; ++i) {
    const double side = i == 0 ? -1.0 : 1.0;
    eyes[i].X_FE = X_LH * Eigen::Translation3d(side * 0.0315, 0.0, 0.0) * Pose(Eigen::AngleAxisd(-side * radians(5.0), Vec3::UnitY()));
  }
  eyes[0].fov = {radians(-49.0), radians(38.0), radians(41.0), radians(-46.0)};
  eyes[1].fov = {radians(-37.0), radians(50.0), radians(42.0), radians(-45.0)};
  return eyes;
}

}  // namespace hapton::mock_xr
