#include "tools/doctor/udev_rules.h"

#include <fmt/core.h>
#include <fnmatch.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <string_view>

namespace hapton::doctor {
namespace {

// Files of a name in an earlier folder hide those of the same name in later ones.
constexpr std::array<std::string_view, 4> kFolders = {"/etc/udev/rules.d", "/run/udev/rules.d", "/usr/lib/udev/rules.d",
                                                      "/lib/udev/rules.d"};

std::map<std::string, std::string> find_rule_files(const Machine& machine) {
  std::map<std::string, std::string> files;  // by name, in udev's order
  for (const std::string_view folder : kFolders) {
    for (const std::string& name : machine.list(folder)) {
      if (name.ends_with(".rules")) files.emplace(name, fmt::format("{}/{}", folder, name));
    }
  }
  return files;
}

std::vector<std::string> find_rule_lines(const std::string& text) {
  std::vector<std::string> lines(1);
  for (const std::string_view line : split_lines(text)) {
    if (lines.back().empty() && line.find_first_not_of(" \t") != line.npos && line[line.find_first_not_of(" \t")] == '#') continue;
    const bool goes_on = line.ends_with('\\');
    lines.back() += line.substr(0, line.size() - (goes_on ? 1 : 0));
    if (!goes_on) lines.emplace_back();
  }
  return lines;
}

// What stands in quotes after a key and its operator: `ATTRS{idVendor}=="1234"`; none: the line has no such key.
std::optional<std::string> value_of(std::string_view line, std::string_view key) {
  const std::size_t at = line.find(key);
  if (at == line.npos) return std::nullopt;
  const std::size_t begin = line.find('"', at);
  const std::size_t end = begin == line.npos ? begin : line.find('"', begin + 1);
  if (end == line.npos) return std::nullopt;
  return std::string(line.substr(begin + 1, end - begin - 1));
}

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

// udev's patterns are the shell's, with | between several.
bool matches(const std::string& patterns, const std::string& text) {
  std::size_t begin = 0;
  while (begin <= patterns.size()) {
    const std::size_t end = std::min(patterns.find('|', begin), patterns.size());
    if (::fnmatch(patterns.substr(begin, end - begin).c_str(), text.c_str(), 0) == 0) return true;
    begin = end + 1;
  }
  return false;
}

std::string_view subsystem_of(DevicePath node) {
  switch (node) {
    case DevicePath::hidraw:
      return "hidraw";
    case DevicePath::serial:
      return "tty";
    case DevicePath::usb:
    case DevicePath::any:
      break;
  }
  return "usb";
}

// folds: capital digits count as small ones.
bool is_about(const std::string& line, const PluggedDevice& device, bool folds) {
  const auto matches_id = [&](const std::string& pattern, std::uint16_t id) {
    return matches(folds ? lower(pattern) : pattern, fmt::format("{:04x}", id));
  };
  const auto vendor = value_of(line, "idVendor}");
  const auto product = value_of(line, "idProduct}");
  if (vendor) return matches_id(*vendor, device.vid) && (!product || matches_id(*product, device.pid));
  // By Bluetooth the ids are in the name of the HID device: 0005:256F:C63A.0001.
  const auto parent = value_of(line, "KERNELS");
  return parent && matches(*parent, fmt::format("0005:{:04X}:{:04X}.0001", device.vid, device.pid));
}

std::optional<UdevRule> read_rule(const std::string& line, const PluggedDevice& device, DevicePath node) {
  if (line.find(subsystem_of(node)) == line.npos) return std::nullopt;
  UdevRule rule;
  rule.group = value_of(line, "GROUP").value_or("");
  rule.has_uaccess = line.find("uaccess") != line.npos;
  if (rule.group.empty() && !rule.has_uaccess && line.find("MODE") == line.npos) return std::nullopt;
  if (is_about(line, device, false)) return rule;
  rule.has_capital_digits = is_about(line, device, true);
  if (rule.has_capital_digits || (device.device == "hapton-hid" && line.find("FF48") != line.npos)) return rule;
  return std::nullopt;
}

}  // namespace

std::optional<UdevRule> find_udev_rule(const Machine& machine, const PluggedDevice& device, DevicePath node) {
  std::optional<UdevRule> last;
  for (const auto& [name, file] : find_rule_files(machine)) {
    for (const std::string& line : find_rule_lines(machine.read(file).value_or(""))) {
      auto rule = read_rule(line, device, node);
      if (!rule || (last && rule->has_capital_digits && !last->has_capital_digits)) continue;
      rule->file = file;
      last = std::move(rule);
    }
  }
  return last;
}

std::string line_that_applies_rules(DevicePath node) {
  return fmt::format("sudo udevadm control --reload && sudo udevadm trigger --action=change --subsystem-match={}", subsystem_of(node));
}

std::string line_that_adds_rule(const PluggedDevice& device, DevicePath node) {
  return fmt::format(
      "echo 'SUBSYSTEM==\"{}\", ATTRS{{idVendor}}==\"{:04x}\", ATTRS{{idProduct}}==\"{:04x}\", TAG+=\"uaccess\", GROUP=\"plugdev\", "
      "MODE=\"0660\"' | sudo tee -a /etc/udev/rules.d/70-hapton-local.rules && {}",
      subsystem_of(node), device.vid, device.pid, line_that_applies_rules(node));
}

}  // namespace hapton::doctor
