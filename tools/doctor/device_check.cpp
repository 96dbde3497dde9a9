#include "tools/doctor/device_check.h"

#include <fmt/format.h>

#include <algorithm>

#include "tools/doctor/plugged_device.h"
#include "tools/doctor/udev_rules.h"

namespace hapton::doctor {
namespace {

std::string subject_of(const PluggedDevice& device) {
  return fmt::format("{} {}{}", device.name, usb_id(device.vid, device.pid), device.serial.empty() ? "" : " " + device.serial);
}

std::string with_driver(const DeviceNode& node) { return node.driver.empty() ? node.path : fmt::format("{} ({})", node.path, node.driver); }

// The kernel makes the hidraw node as soon as its HID driver has taken the device.
Finding explain_no_node(const Machine& machine, const PluggedDevice& device) {
  const std::string subject = subject_of(device);
  const bool has_hid_driver = std::find(device.drivers.begin(), device.drivers.end(), "usbhid") != device.drivers.end();
  if (has_hid_driver && !machine.exists("/sys/class/hidraw"))
    return problem(subject, "this kernel has no hidraw (CONFIG_HIDRAW)", "sudo apt-get install linux-image-amd64 && sudo reboot");
  if (!has_hid_driver && device.path == DevicePath::hidraw)
    return problem(subject, "plugged in, but no kernel driver has taken it", "sudo modprobe usbhid && sudo modprobe hid-generic");
  return problem(subject, "plugged in, but it has no device node", "unplug it, plug it in again, and look at the end of: sudo dmesg");
}

// Finds the reason why access is denied.
Finding explain_denial(const Machine& machine, const PluggedDevice& device, const DeviceNode& node) {
  const std::string subject = subject_of(device);
  const User& user = machine.user();
  const std::string denied = fmt::format("{} is closed to {}", node.path, user.name);
  const auto rule = find_udev_rule(machine, device, node);
  if (!rule) return problem(subject, denied + ": no udev rule names it", line_that_adds_rule(device, node.kind));
  if (rule->has_capital_digits) {
    return problem(subject, fmt::format("{}: {} has capital hexadecimal digits, which udev never matches", denied, rule->file),
                   fmt::format("sudo sed -i -E '/id(Vendor|Product)/s/\"[0-9A-F]{{4}}\"/\\L&/g' {} && {}", rule->file,
                               line_that_applies_rules(node.kind)));
  }
  if (rule->is_too_late() && rule->group.empty()) {
    const std::string folder = rule->file.substr(0, rule->file.find_last_of('/'));
    return problem(subject, fmt::format("{}: {} sorts after 73-seat-late.rules, so its uaccess comes too late", denied, rule->file),
                   fmt::format("sudo mv {} {}/70-{} && {}", rule->file, folder, rule->name().substr(rule->name().find('-') + 1),
                               line_that_applies_rules(node.kind)));
  }
  const auto group = rule->group.empty() ? std::nullopt : machine.find_group(rule->group);
  const auto facts = machine.facts(node.path);
  if (group && facts && facts->gid == group->gid && !group->has_user) {
    return problem(subject, fmt::format("{}: it is for the group {} (rule {})", denied, rule->group, rule->name()),
                   fmt::format("sudo adduser {} {}   # then log out and in again", user.name, rule->group));
  }
  if (group && group->has_user && !user.is_in(group->gid)) {
    return problem(subject, fmt::format("{}: {} is in the group {} since this session began", denied, user.name, rule->group),
                   "log out and in again, or: newgrp " + rule->group);
  }
  return problem(subject, fmt::format("{}: the rule {} has not been applied to it", denied, rule->name()),
                 line_that_applies_rules(node.kind));
}

Finding check_node(const Machine& machine, const PluggedDevice& device, const DeviceNode& node) {
  if (!machine.exists(node.path)) {
    return problem(
        subject_of(device), fmt::format("the kernel has it as {}, but there is no such file", node.path),
        "start udev (sudo systemctl start systemd-udevd && sudo udevadm trigger), or hand /dev to the container: docker run --device=" +
            node.path);
  }
  if (!machine.may_use(node.path)) return explain_denial(machine, device, node);
  const auto rule = find_udev_rule(machine, device, node);
  return good(subject_of(device), fmt::format("{}, open to {}{}{}", with_driver(node), machine.user().name,
                                              rule ? " by rule " + rule->name() : "", "; io_node --device " + device.device_option));
}

void check_device(const Machine& machine, const PluggedDevice& device, Findings& findings) {
  if (device.device_option.empty()) {
    findings.push_back(note(subject_of(device), "plugged in, but Hapton cannot drive it",
                            "its maker's software does; or give it the firmware of docs/hid.md"));
    return;
  }
  if (device.nodes.empty()) findings.push_back(explain_no_node(machine, device));
  for (const DeviceNode& node : device.nodes) findings.push_back(check_node(machine, device, node));
  if (device.may_sleep && device.path != DevicePath::any) {
    const std::string control = device.sysfs_folder + "/power/control";
    findings.push_back(warning(subject_of(device),
                               "the kernel may put it to sleep (USB autosuspend): the first reports after that are late",
                               fmt::format("echo on | sudo tee {}", control)));
  }
}

Finding make_no_device_finding(int other_count) {
  const std::string observation =
      other_count == 0 ? "none is plugged in, and no other USB device either"
                       : fmt::format("none that is known is plugged in ({} other USB device{})", other_count, other_count == 1 ? "" : "s");
  return note("force-feedback device", observation,
              "plug it in, switch its power on, then: lsusb (docs/devices.md has the ids); io_node --device simulated needs none");
}

void check_modem_manager(const Machine& machine, const std::vector<PluggedDevice>& devices, Findings& findings) {
  const auto pid = machine.find_process("ModemManager");
  if (!pid) {
    findings.push_back(good("ModemManager", "does not run"));
    return;
  }
  for (const PluggedDevice& device : devices) {
    const auto serial =
        std::find_if(device.nodes.begin(), device.nodes.end(), [](const DeviceNode& node) { return node.kind == DevicePath::serial; });
    if (serial == device.nodes.end() || keeps_modem_manager_off(machine, device, *serial)) continue;
    findings.push_back(
        problem("ModemManager",
                fmt::format("talks to {} ({}) as if it were a modem, for the first half minute and at random", serial->path, device.name),
                fmt::format("echo 'ATTRS{{idVendor}}==\"{:04x}\", ENV{{ID_MM_DEVICE_IGNORE}}=\"1\"' | sudo tee -a "
                            "/etc/udev/rules.d/70-hapton-local.rules && {} && sudo systemctl restart ModemManager",
                            device.vid, line_that_applies_rules(DevicePath::serial))));
    return;
  }
  findings.push_back(good("ModemManager", "runs, and does not interfere with haptic devices"));
}

void check_spacenavd(const Machine& machine, const std::vector<PluggedDevice>& devices, Findings& findings) {
  const bool has_mouse =
      std::any_of(devices.begin(), devices.end(), [](const PluggedDevice& d) { return d.device_option == "spacemouse"; });
  if (!machine.find_process("spacenavd")) {
    findings.push_back(good("spacenavd", "does not run, and is not needed"));
  } else if (!has_mouse) {
    findings.push_back(good("spacenavd", "runs, without a SpaceMouse"));
  } else {
    findings.push_back(warning("spacenavd", "runs beside Hapton: the SpaceMouse moves other programs too",
                               "sudo systemctl stop spacenavd   # as long as the SpaceMouse is for Hapton alone"));
  }
}

void check_haply(const Machine& machine, Findings& findings) {
  constexpr const char* kUnit = "haply-inverse-service";
  const bool is_installed = machine.exists("/usr/lib/systemd/system/haply-inverse-service.service") ||
                            machine.exists("/lib/systemd/system/haply-inverse-service.service") ||
                            machine.exists("/etc/systemd/system/haply-inverse-service.service");
  // The kernel keeps the first 15 letters of a program's name.
  const bool is_running = machine.find_process(std::string(kUnit).substr(0, 15)).has_value();
  if (is_running) {
    findings.push_back(good("Haply service", "runs; io_node --device haply connects to ws://localhost:10001"));
  } else if (is_installed) {
    findings.push_back(warning("Haply service", "is installed, but does not run", "sudo systemctl enable --now haply-inverse-service"));
  } else {
    findings.push_back(note("Haply service", "not installed; it is for Haply's Inverse3"));
  }
}

}  // namespace

Findings check_devices(const Machine& machine) {
  Findings findings;
  const std::vector<PluggedDevice> devices = find_plugged_devices(machine);
  for (const PluggedDevice& device : devices) check_device(machine, device, findings);
  if (devices.empty()) findings.push_back(make_no_device_finding(count_unknown_usb_devices(machine)));
  return findings;
}

Findings check_services(const Machine& machine) {
  Findings findings;
  const std::vector<PluggedDevice> devices = find_plugged_devices(machine);
  check_modem_manager(machine, devices, findings);
  check_spacenavd(machine, devices, findings);
  check_haply(machine, findings);
  return findings;
}

}  // namespace hapton::doctor
