#include "tools/doctor/port_owner.h"

#include <fmt/core.h>

#include <algorithm>
#include <string_view>
#include <vector>

namespace hapton::doctor {
namespace {

constexpr std::string_view kListening = "0A";  // a state of TCP; of UDP only one state matters

// Adds the inodes of the sockets at a port, from one of the kernel's tables.
void add_inodes(const std::string& table, int port, bool only_listening, std::vector<std::string>& inodes) {
  const std::string port_suffix = fmt::format(":{:04X}", port);
  for (const std::string_view line : split_lines(table)) {
    // Columns: sl local_address rem_address st tx:rx tr:when retrnsmt uid timeout inode
    const auto words = split_words(line);
    if (words.size() < 10 || !words[1].ends_with(port_suffix)) continue;
    if (!only_listening || words[3] == kListening) inodes.emplace_back(words[9]);
  }
}

bool is_number(const std::string& text) { return !text.empty() && text.find_first_not_of("0123456789") == text.npos; }

}  // namespace

std::optional<PortOwner> find_port_owner(const Machine& machine, Transport transport, int port) {
  std::vector<std::string> inodes;
  const bool is_tcp = transport == Transport::tcp;
  const std::string_view name = is_tcp ? "tcp" : "udp";
  for (const std::string_view family : {"", "6"}) {
    add_inodes(machine.read(fmt::format("/proc/net/{}{}", name, family)).value_or(""), port, is_tcp, inodes);
  }
  if (inodes.empty()) return std::nullopt;
  for (const std::string& pid : machine.list("/proc")) {
    if (!is_number(pid)) continue;
    const std::string files = "/proc/" + pid + "/fd";
    for (const std::string& file : machine.list(files)) {
      const std::string target = machine.link_name(files + "/" + file);
      const bool is_owner =
          std::any_of(inodes.begin(), inodes.end(), [&](const std::string& inode) { return target == "socket:[" + inode + "]"; });
      if (is_owner) return PortOwner{machine.read("/proc/" + pid + "/comm").value_or(""), pid};
    }
  }
  return PortOwner{};
}

}  // namespace hapton::doctor
