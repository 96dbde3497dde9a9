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

// A kind of device: what --device knows, what its help says and how one is made.
struct DeviceMaker {
  std::string_view name;
  std::string_view about;  // a few words for --help
  bool takes_id = false;   // there may be several, DeviceSettings::id tells them apart
  bool takes_file = false;
  bool takes_trajectory = false;  // and loop
  // Settings the kind does not take are empty. Error: one line: what is missing and how to fix it.
  Result<std::unique_ptr<Device>> (*make)(const DeviceSettings& settings) = nullptr;
};

// Every kind, simulated ones first. RT: no.
std::span<const DeviceMaker> device_makers();
std::vector<std::string> device_names();
// The kind that --device names: the word itself, but "plugin" for "plugin:FILE.so". RT: yes.
std::string_view kind_of(std::string_view name);
// "NAME: about; NAME: about", for --help. RT: no.
std::string describe_devices();

// The device that the settings name, where they put it in W. RT: set-up only. Error: one line: no such kind (with those there are), a
// setting that it does not take, or why this one is not to be had.
Result<std::unique_ptr<Device>> make_device(const DeviceSettings& settings);

}  // namespace hapton
