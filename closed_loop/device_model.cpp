#include "closed_loop/device_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "devices/model_a.h"

namespace hapton {
namespace {

// A joint of this stiffness. damping_ratio: share of critical damping of ringing_kg, which oscillates on it while the device point is held.
StructuralMode joint(double mass_beyond_kg, double stiffness_n_per_m, double ringing_kg, double damping_ratio) {
  return {mass_beyond_kg, stiffness_n_per_m, 2.0 * damping_ratio * std::sqrt(stiffness_n_per_m * ringing_kg)};
}

constexpr std::string_view kNoSource = "assumed: no source";
constexpr std::string_view kNoWorkspace = "none known: a cube of 0.2 m is assumed";
constexpr double kAssumedHalfM = 0.1;  // half a side of the cube in kNoWorkspace

// half_m: half a side of the cube around the workspace.
DeviceLimits limits_of(double max_force_n, double stiffness_n_per_m, double half_m) {
  return {.max_force_n = max_force_n,
          .max_slew_n_per_s = max_force_n / kForceRiseS,
          .max_stiffness_n_per_m = stiffness_n_per_m,
          .workspace_min_m = Vec3::Constant(-half_m),
          .workspace_max_m = Vec3::Constant(half_m),
          .max_speed_m_per_s = 3.0};
}

// The values are those of devices/stylus_dynamics.h, so that this model and the simulated device agree.
DevicePreset model_a_preset() {
  const double structure = 0.070 * std::pow(2.0 * std::numbers::pi * 30.0, 2);
  return {"model-a",
          "PHANToM Model A",
          {.mass_kg = 0.075,
           .damping_ns_per_m = 0.1,
           .friction_n = 0.04,
           .encoder_step_m = model_a::kPositionStepM,
           .max_force_n = model_a::kMaxForceN,
           .mode_count = 1,
           .modes = {joint(0.005, structure, 0.070, 0.2)}},
          model_a::limits(),
          {"Premium 1.5 data sheet (memory): below 75 g", kNoSource, "Premium 1.5 data sheet (memory)", "HP memo: 1/800 in",
           "HP memo: 1.9 lbf", "HP memo: 30 Hz mechanical bandwidth; its damping is assumed", "HP memo: 7.5 x 10.5 x 15 in"},
          true};
}

// The device simulated-6dof, whose motors turn the stylus, too (turning_axis.h).
DevicePreset model_a_6dof_preset() {
  DevicePreset preset = model_a_preset();
  preset.name = "model-a-6dof";
  preset.title = "PHANToM Model A with motors on its gimbals";
  preset.limits = model_a::limits_with_torque();
  return preset;
}

DevicePreset premium_preset() {
  return {"premium-1.5",
          "PHANToM Premium 1.5",
          {.mass_kg = 0.075,
           .damping_ns_per_m = 0.005,
           .friction_n = 0.04,
           .encoder_step_m = 0.03e-3,
           .max_force_n = 8.5,
           .mode_count = 1,
           .modes = {joint(0.005, 3500.0, 0.070, 0.2)}},
          limits_of(8.5, 800.0, kAssumedHalfM),
          {"data sheet (memory)", "Diolaiti et al. 2006 (memory): 0.005 Ns/m of a PHANToM 1.0", "data sheet (memory)",
           "data sheet (memory)", "data sheet (memory)", "data sheet (memory): 3.5 N/mm; its damping is assumed", kNoWorkspace}};
}

DevicePreset touch_preset() {
  constexpr double kBallM = 0.075;
  return {"touch",
          "Touch, PHANToM Omni",
          {.mass_kg = 0.045,
           .damping_ns_per_m = 0.1,
           .friction_n = 0.26,
           .encoder_step_m = 0.055e-3,
           .max_force_n = 3.3,
           .mode_count = 1,
           .modes = {joint(0.010, 1260.0, 0.035, 0.2)}},
          limits_of(3.3, 400.0, kBallM),
          {"data sheet (memory)", kNoSource, "data sheet (memory)", "data sheet (memory): 450 dpi", "data sheet (memory)",
           "data sheet (memory): 1.26 N/mm along x; its damping is assumed", "CHAI3D 3.3.0: a ball of 75 mm radius"},
          true,
          kBallM};
}

DevicePreset omega_preset() {
  constexpr double kBallM = 0.075;
  return {"omega.3",
          "Force Dimension omega.3",
          {.mass_kg = 0.22,
           .damping_ns_per_m = 0.5,
           .friction_n = 0.1,
           .encoder_step_m = 0.01e-3,
           .max_force_n = 12.0,
           .mode_count = 1,
           .modes = {joint(0.05, 14'500.0, 0.17, 0.1)}},
          limits_of(12.0, 5000.0, kBallM),
          {kNoSource, kNoSource, kNoSource, "data sheet (memory): below 0.01 mm", "data sheet (memory)",
           "data sheet (memory): 14.5 N/mm; its damping is assumed", "CHAI3D 3.3.0: a ball of 75 mm radius"},
          true,
          kBallM};
}

DevicePreset falcon_preset() {
  constexpr double kInchM = 0.0254;
  return {"falcon",
          "Novint Falcon",
          {.mass_kg = 0.25, .damping_ns_per_m = 1.0, .friction_n = 0.5, .encoder_step_m = 0.06e-3, .max_force_n = 9.0},
          limits_of(9.0, 1000.0, 2.0 * kInchM),
          {kNoSource, kNoSource, kNoSource, "data sheet (memory): 400 dpi", "data sheet (memory)", "none known: rigid",
           "the maker's list in SenseGraphics' wiki: 4 x 4 x 4 in"},
          true};
}

DevicePreset wooden_preset() {
  constexpr double kBallM = 0.1;
  return {"wooden",
          "WoodenHaptics",
          {.mass_kg = 0.1, .damping_ns_per_m = 0.2, .friction_n = 0.1, .encoder_step_m = 0.064e-3, .max_force_n = 5.0},
          limits_of(5.0, 1000.0, kBallM),
          {"estimated from its bodies and rotors (docs/wooden-haptics.md)", kNoSource, kNoSource,
           "2000 counts on a 10 mm capstan: 0.064 mm at the tip", "published 5 N, 1000 N/m (memory)", "none known: rigid",
           "the authors' configuration: a ball of 100 mm radius"},
          true,
          kBallM};
}

const std::array<DevicePreset, 7>& presets() noexcept {
  static const std::array<DevicePreset, 7> all = {model_a_preset(), model_a_6dof_preset(), premium_preset(), touch_preset(),
                                                  omega_preset(),   falcon_preset(),       wooden_preset()};
  return all;
}

}  // namespace

double DeviceModel::motor_mass_kg() const noexcept {
  double mass = mass_kg;
  for (int i = 0; i < mode_count; ++i) mass -= modes[static_cast<std::size_t>(i)].mass_kg;
  return mass;
}

DeviceModel DeviceModel::with_modes(int most) const noexcept {
  DeviceModel model = *this;
  model.mode_count = std::clamp(most, 0, mode_count);
  return model;
}

std::span<const DevicePreset> device_presets() noexcept { return presets(); }

const DevicePreset* find_device_preset(std::string_view name) noexcept {
  const auto found = std::find_if(presets().begin(), presets().end(), [&](const DevicePreset& device) { return device.name == name; });
  return found == presets().end() ? nullptr : &*found;
}

std::vector<const DevicePreset*> presets_of_device(std::string_view kind) {
  struct Known {
    std::string_view kind;
    std::string_view preset;
  };
  constexpr std::array kKnown = {Known{"simulated", "model-a"},     Known{"simulated-6dof", "model-a-6dof"},
                                 Known{"openhaptics", "model-a"},   Known{"openhaptics", "premium-1.5"},
                                 Known{"openhaptics", "touch"},     Known{"forcedimension", "omega.3"},
                                 Known{"forcedimension", "falcon"}, Known{"WoodenHaptics", "wooden"}};
  std::vector<const DevicePreset*> found;
  for (const Known& one : kKnown) {
    if (one.kind == kind) found.push_back(find_device_preset(one.preset));
  }
  return found;
}

std::string device_preset_names() {
  std::string names;
  for (const DevicePreset& device : presets()) names += (names.empty() ? "" : ", ") + std::string(device.name);
  return names;
}

}  // namespace hapton
