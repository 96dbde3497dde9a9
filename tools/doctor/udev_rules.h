#pragma once

#include <optional>
#include <string>

#include "tools/doctor/machine.h"
#include "tools/doctor/plugged_device.h"

namespace hapton::doctor {

// The rights that udev's rules give on a device node.
struct UdevRule {
  std::string file;          // the last file that grants a right: "/etc/udev/rules.d/70-hapton.rules"
  std::string group;         // the group that GROUP= names; empty: none
  bool has_uaccess = false;  // TAG+="uaccess": the person at the seat gets access
  // True: the rule would match if the hexadecimal digits of its ids were lower case, since udev compares them as text.
  bool has_capital_digits = false;

  std::string name() const { return file.substr(file.find_last_of('/') + 1); }
  // 73-seat-late.rules of systemd acts on the tag uaccess; a tag that a later file sets has no effect.
  bool is_too_late() const { return has_uaccess && name() > "73-seat-late.rules"; }
};

// Evaluates the rules as udev does: files in order, conditions on ids, names and properties, GOTO. If a condition needs sysfs or a program,
// == does not hold and != holds, except for the program of 70-hapton.rules that recognises Hapton HID. nullopt: no rule gives a right on
// the node. RT: no.
std::optional<UdevRule> find_udev_rule(const Machine& machine, const PluggedDevice& device, const DeviceNode& node);

// Whether the rules set ID_MM_DEVICE_IGNORE for the node, which keeps ModemManager from opening it. RT: no.
bool keeps_modem_manager_off(const Machine& machine, const PluggedDevice& device, const DeviceNode& node);

// A shell line that adds a rule, for the group plugdev and the person at the seat, and applies it.
std::string line_that_adds_rule(const PluggedDevice& device, DevicePath node);
// The command line that applies the installed rules to devices already plugged in.
std::string line_that_applies_rules(DevicePath node);

}  // namespace hapton::doctor
