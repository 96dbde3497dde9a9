#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "tools/doctor/machine.h"

namespace hapton::doctor {

enum class Transport : std::uint8_t { udp, tcp };

struct PortOwner {
  std::string program;  // name and id of the process; both empty: it is another user's, whose open files cannot be read
  std::string pid;
};

// The process that has a UDP socket at this port, or listens at it by TCP, over IPv4 or IPv6; nullopt: none. RT: no.
std::optional<PortOwner> find_port_owner(const Machine& machine, Transport transport, int port);

}  // namespace hapton::doctor
