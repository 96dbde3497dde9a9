#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "tools/doctor/machine.h"

namespace hapton::doctor {

// The kind of device node by which a device is reached.
enum class DevicePath : std::uint8_t {
  hidraw,  // /dev/hidraw0
  serial,  // /dev/ttyACM0
  usb,     // /dev/bus/usb/001/004, which a vendor's library opens
  any,     // not fixed: devices of several generations have one id
};

// A device that Hapton, or a library that it loads, can drive.
struct KnownUsbDevice {
  std::uint16_t vid = 0;
  std::uint16_t pid = 0;  // 0: all products of the vendor
  DevicePath path = DevicePath::any;
  std::string_view name;
  std::string_view device_option;  // its name for io_node --device
  std::string_view library;        // KnownVendorLibrary::name that drives it; empty: none is needed
};

// One device node.
struct DeviceNode {
  std::string path;    // "/dev/hidraw0"
  std::string driver;  // the kernel driver: "hid-generic"; empty: none
  DevicePath kind = DevicePath::any;
};

// A known device that is plugged in.
struct PluggedDevice {
  std::uint16_t vid = 0;
  std::uint16_t pid = 0;
  std::string name;     // as in the catalogue of known devices
  std::string product;  // the maker and product strings of the device itself
  std::string serial;
  std::string device_option;  // its name for io_node --device; empty: Hapton cannot drive it
  std::string library;        // the vendor's library that drives it; empty: none is needed
  std::string sysfs_folder;   // its folder in sysfs; empty: not a USB device, or not found as one
  DevicePath path = DevicePath::any;
  std::vector<DeviceNode> nodes;
  std::vector<std::string> drivers;  // the kernel drivers of its USB interfaces
  bool may_sleep = false;            // USB autosuspend is on
};

// "1234:0006", as lsusb writes it.
std::string usb_id(std::uint16_t vid, std::uint16_t pid);

// Every known device that is plugged in, found in sysfs only: USB devices first, then other HID devices (Bluetooth). RT: no.
std::vector<PluggedDevice> find_plugged_devices(const Machine& machine);
// The number of USB devices whose ids are not known, without USB hubs. RT: no.
int count_unknown_usb_devices(const Machine& machine);

}  // namespace hapton::doctor
