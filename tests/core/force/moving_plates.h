#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <vector>

#include "core/force/force_method.h"
#include "tests/support/made_meshes.h"

namespace hapton {

inline constexpr double kPlateStiffness = 1000.0;
inline constexpr double kPlateSpeed = 0.25;  // m/s

inline std::shared_ptr<const KeyframeMotion> shift_motion(const Vec3& from, const Vec3& to, double seconds) {
  return std::make_shared<const KeyframeMotion>(
      Vec3::Zero(), std::vector<Keyframe>{{0.0, from, Quat::Identity()}, {seconds, to, Quat::Identity()}}, false);
}

inline std::shared_ptr<const KeyframeMotion> turn_motion(const Vec3& pivot, const Vec3& axis, double radians, double seconds) {
  const Quat end(Eigen::AngleAxisd(radians, axis));
  return std::make_shared<const KeyframeMotion>(pivot, std::vector<Keyframe>{{0.0, pivot, Quat::Identity()}, {seconds, pivot, end}}, false);
}

inline TouchObject plate_object(const Vec3& low, const Vec3& high, std::shared_ptr<const KeyframeMotion> motion = nullptr,
                                Material material = {}) {
  return {.mesh = made::shared(made::box(low, high)), .material = material, .motion = std::move(motion)};
}

inline std::unique_ptr<ForceMethod> make_method_for(const TouchScene& scene, const MethodSettings& settings = {}) {
  auto made = make_method(settings, scene);
  EXPECT_TRUE(made) << (made ? "" : made.error().what);
  return made ? std::move(*made) : nullptr;
}

}  // namespace hapton
