#include "tools/doctor/plugged_device.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <charconv>

#include "hid/choose_hid_device.h"
#include "hid/hid_catalog.h"
#include "hid/hid_layout.h"

namespace hapton::doctor {
namespace {

constexpr std::string_view kUsbFolder = "/sys/bus/usb/devices";
constexpr std::string_view kHidrawFolder = "/sys/class/hidraw";

// The known devices that are not HID devices, or not in every version.
constexpr std::array kUsbDevices = {
    KnownUsbDevice{0x2988, 0x0302, DevicePath::serial, "3D Systems Touch (USB)", "openhaptics", "OpenHaptics"},
    KnownUsbDevice{0x2988, 0, DevicePath::any, "3D Systems Touch", "openhaptics", "OpenHaptics"},
    KnownUsbDevice{0x1451, 0, DevicePath::usb, "Force Dimension device", "forcedimension", "Force Dimension SDK"},
    KnownUsbDevice{0x0403, 0xcb48, DevicePath::usb, "Novint Falcon", "forcedimension", "Force Dimension SDK"},
};

std::string_view device_of(HidKind kind) {
  switch (kind) {
    case HidKind::wooden_haptics:
      return "wooden-haptics";
    case HidKind::hapton_hid:
      return "hapton-hid";
    case HidKind::space_mouse:
      return "spacemouse";
    case HidKind::vendor_driver:
      break;
  }
  return {};
}

std::uint16_t parse_hex(std::string_view text) {
  std::uint32_t number = 0;
  std::from_chars(text.data(), text.data() + text.size(), number, 16);
  return static_cast<std::uint16_t>(number);
}

bool is_below(std::string_view path, std::string_view folder) {
  return !folder.empty() && path.size() > folder.size() && path.starts_with(folder) && path[folder.size()] == '/';
}

// One node as the kernel's HID layer shows it.
struct HidNode {
  std::string name;  // "hidraw0"
  std::string sysfs_folder;
  std::string driver;
  HidDescription description;
};

// Reads a line such as HID_ID=0003:00001234:00000006: bus, vendor and product.
void read_hid_ids(std::string_view uevent, HidDescription& description) {
  const std::string_view id = find_field(uevent, "HID_ID=");
  if (id.size() == 22) {
    description.vid = parse_hex(id.substr(5, 8));
    description.pid = parse_hex(id.substr(14, 8));
  }
  description.product = std::string(find_field(uevent, "HID_NAME="));
  description.serial = std::string(find_field(uevent, "HID_UNIQ="));
}

std::vector<HidNode> find_hid_nodes(const Machine& machine) {
  std::vector<HidNode> nodes;
  for (const std::string& name : machine.list(kHidrawFolder)) {
    const std::string device = fmt::format("{}/{}/device", kHidrawFolder, name);
    HidNode node{
        .name = name, .sysfs_folder = machine.real_path(device), .driver = machine.link_name(device + "/driver"), .description = {}};
    node.description.path = "/dev/" + name;
    read_hid_ids(machine.read(device + "/uevent").value_or(""), node.description);
    const std::string descriptor = machine.read_bytes(device + "/report_descriptor");
    node.description.layout = read_hid_layout({reinterpret_cast<const std::uint8_t*>(descriptor.data()), descriptor.size()});
    if (!node.description.layout.applications.empty()) {
      node.description.usage_page = node.description.layout.applications.front().page;
      node.description.usage = node.description.layout.applications.front().usage;
    }
    nodes.push_back(std::move(node));
  }
  return nodes;
}

void set_kind(const HidCatalogEntry& entry, PluggedDevice& plugged) {
  plugged.name = entry.name;
  plugged.device_option = device_of(entry.kind);
  plugged.path = DevicePath::hidraw;
}

// Looks the ids up in the catalogues; false: unknown.
bool recognise(PluggedDevice& plugged) {
  const auto* usb = std::find_if(kUsbDevices.begin(), kUsbDevices.end(), [&](const KnownUsbDevice& known) {
    return known.vid == plugged.vid && (known.pid == 0 || known.pid == plugged.pid);
  });
  if (usb != kUsbDevices.end()) {
    plugged.name = usb->name;
    plugged.device_option = usb->device_option;
    plugged.library = usb->library;
    plugged.path = usb->path;
    return true;
  }
  const HidCatalogEntry* hid = find_in_hid_catalog(plugged.vid, plugged.pid);
  if (hid != nullptr) set_kind(*hid, plugged);
  return hid != nullptr;
}

PluggedDevice read_usb_device(const Machine& machine, const std::string& folder) {
  const auto text = [&](const char* file) { return machine.read(folder + "/" + file).value_or(""); };
  PluggedDevice plugged;
  plugged.vid = parse_hex(text("idVendor"));
  plugged.pid = parse_hex(text("idProduct"));
  const std::string maker = text("manufacturer");
  plugged.product = maker.empty() ? text("product") : maker + " " + text("product");
  plugged.serial = text("serial");
  plugged.sysfs_folder = machine.real_path(folder);
  plugged.may_sleep = text("power/control") == "auto";
  return plugged;
}

void add_interface_drivers(const Machine& machine, const std::string& folder, PluggedDevice& plugged) {
  for (const std::string& name : machine.list(folder)) {
    if (!machine.exists(folder + "/" + name + "/bInterfaceClass")) continue;
    const std::string driver = machine.link_name(folder + "/" + name + "/driver");
    if (!driver.empty()) plugged.drivers.push_back(driver);
  }
}

void add_serial_nodes(const Machine& machine, PluggedDevice& plugged) {
  for (const std::string& name : machine.list("/sys/class/tty")) {
    if (!name.starts_with("ttyACM") && !name.starts_with("ttyUSB")) continue;
    const std::string device = "/sys/class/tty/" + name + "/device";
    if (is_below(machine.real_path(device), plugged.sysfs_folder))
      plugged.nodes.push_back({"/dev/" + name, machine.link_name(device + "/driver"), DevicePath::serial});
  }
}

void add_usb_node(const Machine& machine, const std::string& folder, PluggedDevice& plugged) {
  const int bus = static_cast<int>(machine.read_number(folder + "/busnum").value_or(0));
  const int number = static_cast<int>(machine.read_number(folder + "/devnum").value_or(0));
  const std::string drivers = plugged.drivers.empty() ? "" : plugged.drivers.front();
  plugged.nodes.push_back({fmt::format("/dev/bus/usb/{:03}/{:03}", bus, number), drivers, DevicePath::usb});
}

// A device of a vendor library keeps all its nodes. Of others, a usage in the catalogue excludes nodes such as a receiver's keyboard.
bool is_device_node_of(const HidNode& node, const PluggedDevice& plugged) {
  return plugged.library.empty() ? find_in_hid_catalog(node.description) != nullptr : true;
}

void add_nodes(const Machine& machine, const std::string& folder, const std::vector<HidNode>& hid, PluggedDevice& plugged) {
  add_interface_drivers(machine, folder, plugged);
  for (const HidNode& node : hid) {
    if (is_below(node.sysfs_folder, plugged.sysfs_folder) && is_device_node_of(node, plugged))
      plugged.nodes.push_back({node.description.path, node.driver, DevicePath::hidraw});
  }
  add_serial_nodes(machine, plugged);
  if (plugged.path == DevicePath::usb) add_usb_node(machine, folder, plugged);
}

bool is_usb_device(const Machine& machine, const std::string& folder) { return machine.exists(folder + "/idVendor"); }

bool has_node(const std::vector<PluggedDevice>& devices, const std::string& path) {
  return std::any_of(devices.begin(), devices.end(), [&](const PluggedDevice& device) {
    return std::any_of(device.nodes.begin(), device.nodes.end(), [&](const DeviceNode& node) { return node.path == path; });
  });
}

// Adds HID devices on Bluetooth, on another bus or with unknown ids: their usage identifies a Hapton HID device.
void add_other_hid(const std::vector<HidNode>& hid, std::vector<PluggedDevice>& devices) {
  for (const HidNode& node : hid) {
    const HidCatalogEntry* entry = find_in_hid_catalog(node.description);
    if (entry == nullptr || has_node(devices, node.description.path)) continue;
    PluggedDevice plugged;
    plugged.vid = node.description.vid;
    plugged.pid = node.description.pid;
    set_kind(*entry, plugged);
    plugged.product = node.description.product;
    plugged.serial = node.description.serial;
    plugged.nodes.push_back({node.description.path, node.driver, DevicePath::hidraw});
    devices.push_back(std::move(plugged));
  }
}

}  // namespace

std::string usb_id(std::uint16_t vid, std::uint16_t pid) { return fmt::format("{:04x}:{:04x}", vid, pid); }

std::vector<PluggedDevice> find_plugged_devices(const Machine& machine) {
  std::vector<PluggedDevice> devices;
  const std::vector<HidNode> hid = find_hid_nodes(machine);
  for (const std::string& name : machine.list(kUsbFolder)) {
    const std::string folder = fmt::format("{}/{}", kUsbFolder, name);
    if (!is_usb_device(machine, folder)) continue;
    PluggedDevice plugged = read_usb_device(machine, folder);
    if (!recognise(plugged)) continue;
    add_nodes(machine, folder, hid, plugged);
    devices.push_back(std::move(plugged));
  }
  add_other_hid(hid, devices);
  return devices;
}

int count_unknown_usb_devices(const Machine& machine) {
  int count = 0;
  for (const std::string& name : machine.list(kUsbFolder)) {
    const std::string folder = fmt::format("{}/{}", kUsbFolder, name);
    if (!is_usb_device(machine, folder) || machine.read(folder + "/bDeviceClass") == "09") continue;
    PluggedDevice plugged = read_usb_device(machine, folder);
    count += recognise(plugged) ? 0 : 1;
  }
  return count;
}

}  // namespace hapton::doctor
