#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "devices/device.h"

namespace hapton {

// One joint that bends between the motors and the device point, and the mass beyond it.
struct StructuralMode {
  double mass_kg = 0.0;
  double stiffness_n_per_m = 0.0;
  double damping_ns_per_m = 0.0;
};

// One axis of a device. The encoder and Coulomb friction sit at the motors; the hand holds the last mass.
struct DeviceModel {
  static constexpr int kMaxModes = 2;

  double mass_kg = 0.0;  // mass of the whole axis, as felt at the device point
  double damping_ns_per_m = 0.0;
  double friction_n = 0.0;
  double encoder_step_m = 0.0;
  double max_force_n = 0.0;   // 0: unlimited
  double amplifier_hz = 0.0;  // cutoff of its first-order low-pass; 0: no lag
  int mode_count = 0;
  std::array<StructuralMode, kMaxModes> modes = {};

  // The mass at the motors: all that is not beyond a joint.
  double motor_mass_kg() const noexcept;
  // The same device with only its first `most` modes; the rest is rigid.
  DeviceModel with_modes(int most) const noexcept;
};

// A real device. Each value has its source; "memory": quoted from memory of a data sheet or paper, not verified.
struct DevicePreset {
  std::string_view name;
  std::string_view title;
  DeviceModel model;
  DeviceLimits limits;
  std::array<std::string_view, 7> sources;  // sources of mass, damping, friction, encoder step, largest force, modes, workspace
  bool is_workspace_known = false;          // false: the workspace in `limits` is an assumed cube
  double workspace_radius_m = 0.0;  // radius of a ball-shaped workspace about the origin of W, inside `limits`; 0: the box of `limits`
};

// model-a, model-a-6dof, premium-1.5, touch, omega.3, falcon, wooden. RT: yes, after the first call.
std::span<const DevicePreset> device_presets() noexcept;
// The preset of that name; null if there is none. RT: yes, after the first call.
const DevicePreset* find_device_preset(std::string_view name) noexcept;
// The presets that may describe a device with this Device::name; empty if there is none. RT: set-up only.
std::vector<const DevicePreset*> presets_of_device(std::string_view kind);
// The names for help texts, "model-a, model-a-6dof, ...". RT: set-up only.
std::string device_preset_names();

}  // namespace hapton
