#include "tools/doctor/network_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <string_view>

#include "link/link_key.h"
#include "tools/doctor/port_owner.h"

namespace hapton::doctor {
namespace {

constexpr int kVrpnPort = 3883;  // assigned by IANA

std::string describe(const PortOwner& owner) {
  return owner.program.empty() ? "another user's program" : fmt::format("{} (process {})", owner.program, owner.pid);
}

std::string line_that_shows(Transport transport, int port) {
  return fmt::format("sudo ss -{}lpn 'sport = :{}'", transport == Transport::udp ? "u" : "t", port);
}

Finding check_hub_port(const Machine& machine) {
  const int port = machine.settings().hub_port;
  const std::string subject = fmt::format("port {}/udp", port);
  const auto owner = find_port_owner(machine, Transport::udp, port);
  if (!owner) return good(subject, "free for io_node");
  if (owner->program == "io_node") return good(subject, fmt::format("io_node has it (process {})", owner->pid));
  const std::string command = owner->program.empty() ? line_that_shows(Transport::udp, port) : "kill " + owner->pid;
  return problem(subject, fmt::format("{} has it, so io_node cannot", describe(*owner)),
                 fmt::format("{}   # or give the hub another one: io_node --bind 127.0.0.1:{}, --hub the same", command, port + 1));
}

Finding check_vrpn_port(const Machine& machine) {
  const std::string subject = fmt::format("port {} (VRPN)", kVrpnPort);
  for (const Transport transport : {Transport::tcp, Transport::udp}) {
    const auto owner = find_port_owner(machine, transport, kVrpnPort);
    if (!owner) continue;
    if (owner->program == "io_node") return good(subject, fmt::format("io_node has it (process {})", owner->pid));
    return warning(subject, fmt::format("{} has it, so io_node --vrpn cannot", describe(*owner)),
                   owner->program.empty() ? line_that_shows(transport, kVrpnPort) : fmt::format("kill {}", owner->pid));
  }
  return good(subject, "free for io_node --vrpn");
}

// Where nodes of this user look for the key if none is named.
std::string shared_key_path(const Machine& machine) {
  if (const std::string runtime = machine.environment("XDG_RUNTIME_DIR"); runtime.starts_with('/')) return runtime + "/hapton/master";
  if (const std::string home = machine.environment("HOME"); home.starts_with('/')) return home + "/.config/hapton/master";
  return {};
}

Finding check_key_file(const Machine& machine, const std::string& subject, const std::string& path, bool is_own) {
  const auto file = machine.facts(path);
  const User& user = machine.user();
  if (!file) return problem(subject, path + " is not there", "hapton keygen " + path);
  if (!file->is_regular) return problem(subject, path + " is not a regular file", fmt::format("rm -r {0} && hapton keygen {0}", path));
  if (is_own && file->uid != user.uid) {
    return problem(subject,
                   fmt::format("{} belongs to user {}, and the nodes of {} (user {}) reject it", path, file->uid, user.name, user.uid),
                   fmt::format("sudo chown {} {}", user.name, path));
  }
  if ((file->mode & 077) != 0) {
    return problem(subject, fmt::format("{} is open to other users (mode {:04o})", path, file->mode),
                   fmt::format("{}chmod 600 {}", is_own ? "" : "sudo ", path));
  }
  if (file->bytes == LinkKey::kBytes) {
    return problem(
        subject, fmt::format("{} is a key of an older Hapton, one for all nodes", path),
        fmt::format("{0}rm {1} && {0}hapton keygen {1}   # then a key for each other host: hapton keygen --role haptics --master {1} FILE",
                    is_own ? "" : "sudo ", path));
  }
  if (file->bytes != kKeyFileBytes) {
    return problem(
        subject, fmt::format("{} has {} bytes, but a key file has {}", path, file->bytes, kKeyFileBytes),
        fmt::format("{0}rm {1} && {0}hapton keygen {1}   # then make the keys of the other hosts again", is_own ? "" : "sudo ", path));
  }
  return good(subject, fmt::format("{}, {} bytes, mode {:04o}", path, file->bytes, file->mode));
}

Finding check_own_key(const Machine& machine) {
  const std::string key_file = machine.settings().key_file;
  if (!key_file.empty()) return check_key_file(machine, "key given", key_file, true);
  const std::string path = shared_key_path(machine);
  if (path.empty()) {
    return problem("key of this user", "no place for one: neither XDG_RUNTIME_DIR nor HOME is set",
                   "hapton keygen hapton.key   # and give --key hapton.key to every node");
  }
  if (!machine.exists(path)) return good("key of this user", fmt::format("the first node that starts makes it: {}", path));
  return check_key_file(machine, "key of this user", path, true);
}

bool is_enabled(const Machine& machine, const std::string& unit) {
  const auto units = machine.list("/etc/systemd/system/multi-user.target.wants");
  return std::find(units.begin(), units.end(), unit) != units.end();
}

void check_system_key(const Machine& machine, Findings& findings) {
  constexpr const char* kPath = "/etc/hapton/key";
  const bool is_needed = is_enabled(machine, "hapton-io.service") || is_enabled(machine, "hapton-haptics.service");
  if (machine.exists(kPath)) {
    findings.push_back(check_key_file(machine, "key of the services", kPath, false));
  } else if (is_needed) {
    findings.push_back(problem("key of the services", "a hapton service is enabled, but there is no /etc/hapton/key: it does not start",
                               "sudo hapton keygen /etc/hapton/key   # on the hub's host; for another: hapton keygen --role haptics "
                               "--master /etc/hapton/key FILE"));
  }
}

// True if the text has the number as a whole: 4950 is not in 14950.
bool has_number(std::string_view text, std::string_view number) {
  const auto is_digit = [&](std::size_t at) { return at < text.size() && text[at] >= '0' && text[at] <= '9'; };
  for (std::size_t at = text.find(number); at != text.npos; at = text.find(number, at + 1)) {
    if ((at == 0 || !is_digit(at - 1)) && !is_digit(at + number.size())) return true;
  }
  return false;
}

// In XML a comment is from <!-- to -->, otherwise from a # outside quotation marks to the end of the line.
std::string without_comments(std::string_view rules, bool is_xml) {
  std::string kept;
  if (is_xml) {
    for (std::size_t begin = rules.find("<!--"); begin != rules.npos; begin = rules.find("<!--")) {
      kept += rules.substr(0, begin);
      kept += ' ';
      rules.remove_prefix(std::min(rules.find("-->", begin), rules.size()));
    }
    return kept.append(rules);
  }
  for (const std::string_view line : split_lines(rules)) {
    bool is_quoted = false;
    const auto end = std::find_if(line.begin(), line.end(), [&](char c) {
      is_quoted = is_quoted != (c == '"');
      return c == '#' && !is_quoted;
    });
    kept.append(line.begin(), end);
    kept += '\n';
  }
  return kept;
}

Finding check_rules(const Machine& machine, const std::string& name, const std::string& rules_file, const std::string& remedy) {
  const auto rules = machine.read(rules_file);
  const std::string port = std::to_string(machine.settings().hub_port);
  if (!rules) return note(name, fmt::format("is on; only root can read its rules. Other hosts need UDP port {}", port), remedy);
  if (has_number(without_comments(*rules, rules_file.ends_with(".xml")), port))
    return good(name, fmt::format("is on and lets port {} through", port));
  return warning(name, fmt::format("is on and has no rule for port {}: other hosts cannot reach the hub (this host can)", port), remedy);
}

}  // namespace

Findings check_ports(const Machine& machine) { return {check_hub_port(machine), check_vrpn_port(machine)}; }

Findings check_keys(const Machine& machine) {
  Findings findings = {check_own_key(machine)};
  check_system_key(machine, findings);
  return findings;
}

Findings check_firewall(const Machine& machine) {
  const int port = machine.settings().hub_port;
  const std::string ufw = machine.read("/etc/ufw/ufw.conf").value_or("");
  if (find_field(ufw, "ENABLED=") == "yes") {
    return {check_rules(machine, "ufw", "/etc/ufw/user.rules",
                        fmt::format("sudo ufw allow from 192.168.0.0/16 to any port {} proto udp   # your network's addresses", port))};
  }
  if (machine.find_process("firewalld")) {
    return {check_rules(machine, "firewalld", "/etc/firewalld/zones/public.xml",
                        fmt::format("sudo firewall-cmd --permanent --add-port={}/udp && sudo firewall-cmd --reload", port))};
  }
  const std::string nft = without_comments(machine.read("/etc/nftables.conf").value_or(""), false);
  if (nft.find("policy drop") != nft.npos) {
    return {
        check_rules(machine, "nftables", "/etc/nftables.conf",
                    fmt::format("sudo nft add rule inet filter input udp dport {} accept   # and the same in /etc/nftables.conf", port))};
  }
  return {good("firewall", "none found in ufw, firewalld or /etc/nftables.conf")};
}

}  // namespace hapton::doctor
