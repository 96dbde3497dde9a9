#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "devices/device.h"
#include "devices/device_settings.h"

namespace hapton {

// A kind of device: its name for --device, its help and its constructor.
struct DeviceMaker {
  std::string_view name;
  std::string_view about;         // a few words for --help
  bool takes_id = false;          // --device-id, which selects one of several that are connected
  bool takes_file = false;        // --device-file
  bool takes_trajectory = false;  // --trajectory and --loop
  // Pre: settings that the kind does not take are empty. Error, one line: what is missing and how to fix it.
  Result<std::unique_ptr<Device>> (*make)(const DeviceSettings& settings) = nullptr;
};

// Every kind, simulated ones first. RT: no.
std::span<const DeviceMaker> device_makers();
std::vector<std::string> device_names();
// The kind that --device names: the name itself, but "plugin" for "plugin:FILE.so". RT: yes.
std::string_view kind_of(std::string_view name);
// "NAME: about; NAME: about", for --help. RT: no.
std::string describe_devices();

// Makes the device that the settings name, placed in W by X_WB. RT: set-up only. Error, one line: an unknown kind (with the known ones), a
// setting that the kind does not take, or the reason why the device cannot be opened.
Result<std::unique_ptr<Device>> make_device(const DeviceSettings& settings);

}  // namespace hapton
