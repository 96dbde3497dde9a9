#include "devices/device_maker.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "devices/force_dimension_device.h"
#include "devices/haply_device.h"
#include "devices/hapton_hid_device.h"
#include "devices/open_haptics_device.h"
#include "devices/placed_device.h"
#include "devices/plugin_device.h"
#include "devices/replay_device.h"
#include "devices/simulated_phantom.h"
#include "devices/space_mouse_device.h"
#include "devices/wooden_haptics.h"

namespace hapton {
namespace {

using Made = Result<std::unique_ptr<Device>>;

Made make_phantom(const DeviceSettings& settings, bool has_torque) {
  SimulatedPhantom::Options options{
      .seed = settings.seed, .stylus = {}, .path = {}, .repeat_path = settings.loop, .has_torque = has_torque};
  if (settings.trajectory.empty() && settings.loop) return fail("--loop repeats a --trajectory; give one or leave --loop out");
  if (!settings.trajectory.empty()) {
    auto rows = read_trajectory_csv(settings.trajectory);
    if (!rows) return tl::unexpected(rows.error());
    options.path = std::move(*rows);
  }
  return std::make_unique<SimulatedPhantom>(options);
}

Made make_simulated(const DeviceSettings& settings) { return make_phantom(settings, false); }
Made make_simulated_6dof(const DeviceSettings& settings) { return make_phantom(settings, true); }

Made make_replay(const DeviceSettings& settings) {
  if (settings.trajectory.empty()) return fail("--device replay needs --trajectory FILE");
  auto rows = read_trajectory_csv(settings.trajectory);
  if (!rows) return tl::unexpected(rows.error());
  return std::make_unique<ReplayDevice>(std::move(*rows), ReplayDevice::Options{.loop = settings.loop});
}

Made make_openhaptics(const DeviceSettings& settings) { return make_open_haptics(settings); }
Made make_forcedimension(const DeviceSettings& settings) { return make_force_dimension(settings); }

constexpr std::array kMakers = {
    DeviceMaker{.name = "simulated", .about = "a PHANToM Model A with a scripted hand", .takes_trajectory = true, .make = make_simulated},
    DeviceMaker{.name = "simulated-6dof",
                .about = "the same with motors on its gimbals: force and torque",
                .takes_trajectory = true,
                .make = make_simulated_6dof},
    DeviceMaker{.name = "replay", .about = "a recorded trajectory", .takes_trajectory = true, .make = make_replay},
    DeviceMaker{
        .name = "wooden-haptics", .about = "WoodenHaptics by USB", .takes_id = true, .takes_file = true, .make = make_wooden_haptics},
    DeviceMaker{.name = "hapton-hid", .about = "any device that speaks Hapton HID", .takes_id = true, .make = make_hapton_hid},
    DeviceMaker{.name = "spacemouse", .about = "a SpaceMouse moves the hand; no force", .takes_id = true, .make = make_space_mouse},
    DeviceMaker{.name = "openhaptics", .about = "PHANToM, Omni, Touch by libHD", .takes_id = true, .make = make_openhaptics},
    DeviceMaker{
        .name = "forcedimension", .about = "omega, delta, sigma, lambda, Falcon by libdrd", .takes_id = true, .make = make_forcedimension},
    DeviceMaker{.name = "haply", .about = "Haply Inverse3 by its service", .takes_id = true, .make = make_haply},
    DeviceMaker{.name = "plugin",
                .about = "a device from a shared library, --device plugin:FILE.so:KEY=VALUE,... (docs/plugins.md)",
                .make = make_plugin_device},
};

// The names of the devices that take a setting, such as "replay" or "wooden-haptics or haply".
std::string names_that_take(bool DeviceMaker::*takes) {
  std::vector<std::string_view> names;
  for (const DeviceMaker& maker : kMakers) {
    if (maker.*takes) names.push_back(maker.name);
  }
  return fmt::format("{}", fmt::join(names, " or "));
}

Result<void> check_settings(const DeviceMaker& maker, const DeviceSettings& settings) {
  const auto check = [&](bool is_given, bool DeviceMaker::*takes, std::string_view flag) -> Result<void> {
    if (!is_given || maker.*takes) return {};
    const std::string names = names_that_take(takes);
    return fail("{} applies to --device {}, not to {}; change one or leave {} out", flag, names, maker.name, flag);
  };
  if (auto checked = check(!settings.trajectory.empty(), &DeviceMaker::takes_trajectory, "--trajectory"); !checked) return checked;
  if (auto checked = check(settings.loop, &DeviceMaker::takes_trajectory, "--loop"); !checked) return checked;
  if (auto checked = check(!settings.id.empty(), &DeviceMaker::takes_id, "--device-id"); !checked) return checked;
  return check(!settings.file.empty(), &DeviceMaker::takes_file, "--device-file");
}

}  // namespace

std::span<const DeviceMaker> device_makers() { return kMakers; }

std::vector<std::string> device_names() {
  std::vector<std::string> names;
  for (const DeviceMaker& maker : kMakers) names.emplace_back(maker.name);
  return names;
}

std::string describe_devices() {
  std::string text;
  for (const DeviceMaker& maker : kMakers) text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", maker.name, maker.about);
  return text;
}

std::string_view kind_of(std::string_view name) { return name.starts_with(kPluginDevice) ? "plugin" : name; }

Result<std::unique_ptr<Device>> make_device(const DeviceSettings& settings) {
  const auto maker = std::find_if(kMakers.begin(), kMakers.end(), [&](const DeviceMaker& m) { return m.name == kind_of(settings.name); });
  if (maker == kMakers.end()) return fail("unknown device '{}'; choose one of {}", settings.name, fmt::join(device_names(), ", "));
  if (const auto checked = check_settings(*maker, settings); !checked) return tl::unexpected(checked.error());
  auto made = maker->make(settings);
  if (!made || settings.X_WB.matrix() == Pose::Identity().matrix()) return made;
  return std::make_unique<PlacedDevice>(std::move(*made), settings.X_WB);
}

}  // namespace hapton
