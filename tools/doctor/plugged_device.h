#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "tools/doctor/machine.h"

namespace hapton::doctor {

// How a device is reached.
enum class DevicePath : std::uint8_t {
  hidraw,  // /dev/hidraw0
  serial,  // /dev/ttyACM0
  usb,     // /dev/bus/usb/001/004, by a vendor's library
  any,     // whatever it has: several generations under one id
};

// A device that Hapton, or a library that it loads, can drive.
struct KnownUsbDevice {
  std::uint16_t vid = 0;
  std::uint16_t pid = 0;  // 0: all of the vendor's
  DevicePath path = DevicePath::any;
  std::string_view name;
  std::string_view device;   // as in --device
  std::string_view library;  // KnownVendorLibrary::name that drives it; empty: none is needed
};

// One device node.
struct DeviceNode {
  std::string path;    // "/dev/hidraw0"
  std::string driver;  // "hid-generic"; empty: none
  DevicePath kind = DevicePath::any;
};

// A known device that is plugged in.
struct PluggedDevice {
  std::uint16_t vid = 0;
  std::uint16_t pid = 0;
  std::string name;     // of the catalogue
  std::string product;  // the device's own product and maker strings
  std::string serial;
  std::string device;   // as in --device; empty: nothing of ours drives it
  std::string library;  // that drives it
  std::string where;    // its folder in sysfs; empty: not by USB
  DevicePath path = DevicePath::any;
  std::vector<DeviceNode> nodes;
  std::vector<std::string> drivers;  // of its USB interfaces
  bool may_sleep = false;            // USB autosuspend
};

// "1234:0006", as lsusb writes it.
std::string usb_id(std::uint16_t vid, std::uint16_t pid);

// Every known device that is plugged in, from sysfs alone, by USB first. RT: no.
std::vector<PluggedDevice> find_plugged_devices(const Machine& machine);
// How many USB devices there are that we do not know, hubs left out.
int count_unknown_usb_devices(const Machine& machine);

}  // namespace hapton::doctor
