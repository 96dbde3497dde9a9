#include "tools/doctor/udev_rules.h"

#include <fmt/core.h>
#include <fnmatch.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <string_view>
#include <vector>

namespace hapton::doctor {
namespace {

// A file in an earlier folder hides the files of the same name in later folders.
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

// The lines of a rules file without comments, with continued lines joined.
std::vector<std::string> find_rule_lines(const std::string& text) {
  std::vector<std::string> lines(1);
  for (const std::string_view line : split_lines(text)) {
    const std::size_t first = std::min(line.find_first_not_of(" \t"), line.size());
    if (lines.back().empty() && line.substr(first).starts_with('#')) continue;
    const bool is_continued = line.ends_with('\\');
    lines.back() += line.substr(0, line.size() - (is_continued ? 1 : 0));
    if (!is_continued) lines.emplace_back();
  }
  return lines;
}

// A part of a rule: KEY op "VALUE".
struct Token {
  std::string key;
  std::string op;
  std::string value;

  bool is_match() const { return op == "==" || op == "!="; }
};

std::vector<Token> read_tokens(std::string_view line) {
  constexpr std::string_view kOps = "=!+-:";
  std::vector<Token> tokens;
  while (true) {
    line.remove_prefix(std::min(line.find_first_not_of(" \t,"), line.size()));
    // A key may have the characters of an operator in braces: ATTRS{foo-bar}.
    const std::size_t brace = line.find('{');
    const std::size_t first = line.find_first_of(kOps);
    const std::size_t op = brace < first ? line.find_first_of(kOps, line.find('}', brace)) : first;
    const std::size_t begin = line.find('"');
    if (op == line.npos || begin == line.npos || begin < op) return tokens;
    const std::size_t end = line.find('"', begin + 1);
    if (end == line.npos) return tokens;
    const std::size_t op_end = line.find_first_not_of(kOps, op);
    const std::string_view key = line.substr(0, op);
    tokens.push_back({std::string(key.substr(0, key.find_last_not_of(" \t") + 1)), std::string(line.substr(op, op_end - op)),
                      std::string(line.substr(begin + 1, end - begin - 1))});
    line.remove_prefix(end + 1);
  }
}

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

// udev's patterns are those of the shell, with | between alternatives.
bool matches(const std::string& patterns, const std::string& text) {
  for (std::size_t begin = 0; begin <= patterns.size();) {
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

// The evaluation of the rules for one node.
class RuleEvaluation {
 public:
  RuleEvaluation(const PluggedDevice& device, const DeviceNode& node, bool ignores_case)
      : device_(device), node_(node), ignores_case_(ignores_case) {
    if (node.kind == DevicePath::usb) env_["DEVTYPE"] = "usb_device";
  }

  void read_file(const std::string& file, const std::string& text) {
    label_.clear();
    for (const std::string& line : find_rule_lines(text)) read_line(file, read_tokens(line));
  }

  // The rights that the rules grant; an empty file name: none.
  const UdevRule& rule() const { return rule_; }
  const std::map<std::string, std::string>& env() const { return env_; }

 private:
  void read_line(const std::string& file, const std::vector<Token>& tokens) {
    if (!label_.empty()) {
      const bool has_label =
          std::any_of(tokens.begin(), tokens.end(), [&](const Token& t) { return t.key == "LABEL" && t.value == label_; });
      if (has_label) label_.clear();
      return;
    }
    const bool is_match =
        std::all_of(tokens.begin(), tokens.end(), [&](const Token& t) { return !t.is_match() || (is_equal(t) == (t.op == "==")); });
    if (!is_match) return;
    for (const Token& token : tokens) {
      if (!token.is_match()) apply(file, token);
    }
  }

  bool is_equal(const Token& token) const {
    const std::string& pattern = token.value;
    if (token.key == "ACTION") return matches(pattern, "add");
    if (token.key == "SUBSYSTEM" || token.key == "SUBSYSTEMS") return matches(pattern, std::string(subsystem_of(node_.kind)));
    if (token.key == "KERNEL") return matches(pattern, node_name());
    // The name of the HID device above a hidraw node holds its bus and ids; on Bluetooth nothing else gives the ids.
    if (token.key == "KERNELS") return matches(pattern, hid_name()) || matches(pattern, node_name());
    if (token.key.ends_with("{idVendor}")) return has_id(pattern, device_.vid);
    if (token.key.ends_with("{idProduct}")) return has_id(pattern, device_.pid);
    if (token.key == "ATTRS{serial}") return matches(pattern, device_.serial);
    // The program of 70-hapton.rules searches the report descriptor for \x06\x48\xff, the usage page of Hapton HID.
    if (token.key == "PROGRAM") return device_.device_option == "hapton-hid" && pattern.find("x48") != pattern.npos;
    if (token.key.starts_with("ENV{")) {
      const auto property = env_.find(token.key.substr(4, token.key.size() - 5));
      return matches(pattern, property == env_.end() ? "" : property->second);
    }
    return false;
  }

  void apply(const std::string& file, const Token& token) {
    if (token.key == "GOTO") label_ = token.value;
    if (token.key.starts_with("ENV{")) env_[token.key.substr(4, token.key.size() - 5)] = token.value;
    if (token.key == "GROUP") rule_.group = token.value;
    const bool is_uaccess = token.key == "TAG" && token.value == "uaccess";
    if (is_uaccess) rule_.has_uaccess = token.op != "-=";
    if (is_uaccess && !rule_.has_uaccess && rule_.group.empty() && !has_mode_) rule_.file.clear();
    const bool is_for_all = token.key == "MODE" && (token.value.ends_with('6') || token.value.ends_with('7'));
    has_mode_ = has_mode_ || is_for_all;
    if (token.key == "GROUP" || (is_uaccess && rule_.has_uaccess) || is_for_all) rule_.file = file;
  }

  // Only USB devices have these ids in sysfs; Bluetooth devices do not.
  bool has_id(const std::string& pattern, std::uint16_t id) const {
    const bool is_usb = !device_.sysfs_folder.empty();
    return is_usb && matches(ignores_case_ ? lower(pattern) : pattern, fmt::format("{:04x}", id));
  }
  std::string node_name() const { return node_.path.substr(node_.path.find_last_of('/') + 1); }
  std::string hid_name() const {
    return fmt::format("{}:{:04X}:{:04X}.0001", device_.sysfs_folder.empty() ? "0005" : "0003", device_.vid, device_.pid);
  }

  const PluggedDevice& device_;
  const DeviceNode& node_;
  bool ignores_case_;
  std::string label_;  // target of a GOTO that is being searched; empty: none
  std::map<std::string, std::string> env_;
  UdevRule rule_;
  bool has_mode_ = false;  // a rule gives everyone the right
};

RuleEvaluation evaluate_rules(const Machine& machine, const PluggedDevice& device, const DeviceNode& node, bool ignores_case) {
  RuleEvaluation evaluation(device, node, ignores_case);
  for (const auto& [name, file] : find_rule_files(machine)) evaluation.read_file(file, machine.read(file).value_or(""));
  return evaluation;
}

}  // namespace

std::optional<UdevRule> find_udev_rule(const Machine& machine, const PluggedDevice& device, const DeviceNode& node) {
  const UdevRule rule = evaluate_rules(machine, device, node, false).rule();
  if (!rule.file.empty()) return rule;
  UdevRule rule_ignoring_case = evaluate_rules(machine, device, node, true).rule();
  if (rule_ignoring_case.file.empty()) return std::nullopt;
  rule_ignoring_case.has_capital_digits = true;
  return rule_ignoring_case;
}

bool keeps_modem_manager_off(const Machine& machine, const PluggedDevice& device, const DeviceNode& node) {
  const auto env = evaluate_rules(machine, device, node, false).env();
  const auto ignored = env.find("ID_MM_DEVICE_IGNORE");
  return ignored != env.end() && ignored->second == "1";
}

std::string line_that_applies_rules(DevicePath node) {
  return fmt::format("sudo udevadm control --reload && sudo udevadm trigger --action=change --subsystem-match={}", subsystem_of(node));
}

std::string line_that_adds_rule(const PluggedDevice& device, DevicePath node) {
  const std::string ids = device.sysfs_folder.empty()
                              ? fmt::format("KERNELS==\"0005:{:04X}:{:04X}.*\"", device.vid, device.pid)
                              : fmt::format("ATTRS{{idVendor}}==\"{:04x}\", ATTRS{{idProduct}}==\"{:04x}\"", device.vid, device.pid);
  return fmt::format(
      "echo 'SUBSYSTEM==\"{}\", {}, TAG+=\"uaccess\", GROUP=\"plugdev\", MODE=\"0660\"' | sudo tee -a "
      "/etc/udev/rules.d/70-hapton-local.rules "
      "&& {}",
      subsystem_of(node), ids, line_that_applies_rules(node));
}

}  // namespace hapton::doctor
