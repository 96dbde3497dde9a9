#pragma once

#include <optional>
#include <string>

#include "tools/doctor/machine.h"
#include "tools/doctor/plugged_device.h"

namespace hapton::doctor {

// What udev's rules say of a device node.
struct UdevRule {
  std::string file;          // the last that grants anything: "/etc/udev/rules.d/70-hapton.rules"
  std::string group;         // GROUP=; empty: none
  bool has_uaccess = false;  // TAG+="uaccess": the person at the seat
  // It would match if its hexadecimal digits were small: udev compares letter by letter.
  bool has_capital_digits = false;

  std::string name() const { return file.substr(file.find_last_of('/') + 1); }
  // systemd's 73-seat-late.rules gives the seat's rights; a tag that is set after it comes too late.
  bool is_too_late() const { return has_uaccess && name() > "73-seat-late.rules"; }
};

// Evaluates the rules as udev does: files in order, matches on ids, names and properties, GOTO. A match that would need sysfs or a
// program counts as no match, except the program of 70-hapton.rules that recognises Hapton HID. Empty: no rule gives anybody a right on
// the node.
std::optional<UdevRule> find_udev_rule(const Machine& machine, const PluggedDevice& device, const DeviceNode& node);

// Whether the rules keep ModemManager off the node.
bool keeps_modem_manager_off(const Machine& machine, const PluggedDevice& device, const DeviceNode& node);

// A shell line that adds a rule, for the group plugdev and the person at the seat, and applies it.
std::string line_that_adds_rule(const PluggedDevice& device, DevicePath node);
// The command line that applies the installed rules to devices already plugged in.
std::string line_that_applies_rules(DevicePath node);

}  // namespace hapton::doctor
