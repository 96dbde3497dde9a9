#pragma once

#include <filesystem>
#include <optional>

#include "core/base/result.h"
#include "devices/device.h"
#include "devices/wooden_kinematics.h"

namespace hapton {

// Three encoders between the lower arm and the stylus, in this order: each axis is in the frame after the previous rotation.
struct WoodenWrist {
  struct Joint {
    Vec3 axis = Vec3::UnitZ();  // unit vector in the frame of the lower arm, with all joints of the wrist at angle zero
    double counts_per_turn = 2000.0;
    double direction = 1.0;
    double offset_rad = 0.0;  // the angle at encoder zero
  };
  std::array<Joint, 3> joints = {};
};

// Parameters of one build of a WoodenHaptics device.
struct WoodenSettings {
  WoodenArm arm;
  std::optional<WoodenWrist> wrist;  // none: the orientation is unknown, the stylus keeps that of W
  DeviceLimits limits;               // force, stiffness, workspace in W
  double max_current_a = 3.0;        // largest current of each motor; the firmware's full scale
  bool has_gravity_compensation = true;
  std::int64_t report_bytes = 0;  // 8 or 14; 0: as the device's report descriptor says

  // The "2016 edition".
  static WoodenSettings make_default();
};

// Reads a TOML file with the keys of docs/wooden-haptics.md; absent keys keep their defaults. Error: one line with file, line and key.
Result<WoodenSettings> read_wooden_settings(const std::filesystem::path& path);

}  // namespace hapton
