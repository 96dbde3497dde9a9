#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/doctor/machine.h"
#include "tools/doctor/plugged_device.h"

namespace hapton::doctor {

// A line of a udev rules file that is about a device and grants rights on its node.
struct UdevRule {
  std::string file;          // "/etc/udev/rules.d/70-hapton.rules"
  std::string group;         // GROUP=; empty: none
  bool has_uaccess = false;  // TAG+="uaccess": the person at the seat
  // It would match if its hexadecimal digits were small: udev compares letter by letter.
  bool has_capital_digits = false;

  std::string name() const { return file.substr(file.find_last_of('/') + 1); }
  // systemd's 73-seat-late.rules gives the seat's rights; a tag that is set after it comes too late.
  bool is_too_late() const { return has_uaccess && name() > "73-seat-late.rules"; }
};

// The rule for a node of that device, the last one first that udev reads; none: there is none. RT: no.
std::optional<UdevRule> find_udev_rule(const Machine& machine, const PluggedDevice& device, DevicePath node);

// A shell line that adds one, for people in `group` and at the seat, and applies it.
std::string line_that_adds_rule(const PluggedDevice& device, DevicePath node);
// Applies the rules there are to what is plugged in.
std::string line_that_applies_rules(DevicePath node);

}  // namespace hapton::doctor
