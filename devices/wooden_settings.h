#pragma once

#include <filesystem>
#include <optional>

#include "core/base/result.h"
#include "devices/device.h"
#include "devices/wooden_kinematics.h"

namespace hapton {

// Three encoders between the lower arm and the stylus, in this order: each turns about an axis of the frame that the one before it left.
struct WoodenWrist {
  struct Joint {
    Vec3 axis = Vec3::UnitZ();  // of unit length, in the frame of the lower arm where all is zero
    double counts_per_turn = 2000.0;
    double direction = 1.0;
    double offset_rad = 0.0;  // the angle where the encoder says zero
  };
  std::array<Joint, 3> joints = {};
};

// Of one build of a WoodenHaptics device.
struct WoodenSettings {
  WoodenArm arm;
  std::optional<WoodenWrist> wrist;  // none: the stylus' orientation is not known, it points as the world does
  DeviceLimits limits;               // force, stiffness, workspace in W
  double max_current_a = 3.0;        // of each motor; the firmware's full scale
  bool has_gravity_compensation = true;
  std::int64_t report_bytes = 0;  // 8 or 14; 0: as the device's report descriptor says

  // The "2016 edition".
  static WoodenSettings make_default();
};

// docs/wooden-haptics.md has the keys; what is left out is as in the default. Error: one line with file, line and key.
Result<WoodenSettings> read_wooden_settings(const std::filesystem::path& path);

}  // namespace hapton
