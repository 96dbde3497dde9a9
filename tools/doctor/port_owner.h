#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "tools/doctor/machine.h"

namespace hapton::doctor {

enum class Transport : std::uint8_t { udp, tcp };

struct PortOwner {
  std::string program;  // empty: another user's process, whose files are not readable
  std::string pid;
};

// The process that listens at a port of this machine, over IPv4 or IPv6; empty if there is none. RT: no.
std::optional<PortOwner> find_port_owner(const Machine& machine, Transport transport, int port);

}  // namespace hapton::doctor
