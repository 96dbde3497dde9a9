#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>

#include "core/math/types.h"
#include "runtime/realtime.h"

namespace hapton {

// A device, its parameters, and its pose in the world frame W.
struct DeviceSettings {
  std::string name = "simulated";  // one of device_makers()
  std::string id;                  // selects one of several: serial number, path, index or the vendor's name for it; empty: the first found
  std::string file;                // TOML with the device's own parameters; empty: those of its maker
  std::string trajectory;          // CSV file with the motion to replay, or with the path of the simulated hand; empty: none
  bool loop = false;               // repeat the trajectory
  std::uint64_t seed = 1;          // seed of the simulated hand's script
  // Limits below the device's own; infinite: the device's own limit. max_force_n 0: no force and no torque; max_torque_nm 0: no torque.
  double max_force_n = std::numeric_limits<double>::infinity();
  double max_torque_nm = std::numeric_limits<double>::infinity();
  double max_slew_n_per_s = 0.0;  // this and the next two: limits below the device's own; 0: the device's own
  double continuous_force_n = 0.0;
  double max_speed_m_per_s = 0.0;
  // The device's mechanics without a hand, for the passivity controller (safety/passivity_controller.h); mass 0: the controller is off.
  double passive_mass_kg = 0.0;
  double passive_damping_ns_per_m = 0.0;
  double passive_friction_n = 0.0;
  double passive_position_step_m = 0.0;
  int dead_mans_switch = 0;                       // button that must be held for a force, counted from 1; 0: none
  int clutch_button = 0;                          // button of the clutch, counted from 1; 0: none
  std::optional<RealtimeSettings> realtime = {};  // for threads that the device itself starts; none: ordinary priority
  Pose X_WB = Pose::Identity();                   // pose of the device's base frame in W, for two hands side by side
};

}  // namespace hapton
