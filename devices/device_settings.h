#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>

#include "core/math/types.h"
#include "runtime/realtime.h"

namespace hapton {

// Which device, with which parameters, and where it is placed in W.
struct DeviceSettings {
  std::string name = "simulated";  // one of device_makers()
  std::string id;                  // which of several: serial number, path, index or the vendor's name for it; empty: the first found
  std::string file;                // TOML with the device's own parameters; empty: those of its maker
  std::string trajectory;          // CSV of the replay, or the path of the simulated hand
  bool loop = false;               // it begins again
  std::uint64_t seed = 1;          // of the simulated hand's script
  // Tighter than the device's own limit; 0: no force at all; infinite: the device's own.
  double max_force_n = std::numeric_limits<double>::infinity();
  double max_slew_n_per_s = 0.0;  // tighter than the device's own; 0: the device's, like the next three
  double max_torque_nm = 0.0;
  double continuous_force_n = 0.0;
  double max_speed_m_per_s = 0.0;
  // The device's mechanics without a hand, for the passivity controller (safety/passivity_controller.h); mass 0: it is off.
  double passive_mass_kg = 0.0;
  double passive_damping_ns_per_m = 0.0;
  double passive_friction_n = 0.0;
  double passive_position_step_m = 0.0;
  int hold_button = -1;                           // that must be held for force to be there, lowest bit 0; below 0: none
  int clutch_button = 0;                          // that holds the device point where it is, counted from 1; 0: none
  std::optional<RealtimeSettings> realtime = {};  // of the thread that talks to it, where there is one; none: an ordinary thread
  Pose X_WB = Pose::Identity();                   // of the device's base, as the maker knows it, in W: two hands side by side
};

}  // namespace hapton
