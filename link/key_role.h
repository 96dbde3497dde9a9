#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace hapton {

// The rights of the holder of a key. A role is part of every handshake, and so of the keys of every session; the number is its byte on the
// wire.
//
//   haptics   the haptics node: forces and what they are computed with
//   vision    a vision node: view transforms, frame acknowledgements, the hand target of a simulated device, objects
//   tool      a tool: settings, reports, materials and objects, but no reset of a latched fault
//   operator  the rights of a tool, and the reset of latched faults
enum class KeyRole : std::uint8_t {
  unsealed = 0,  // no key at all: in-memory endpoints of tests
  master = 1,    // the hub's key, from which every other key is derived; no handshake has this role
  haptics = 2,
  vision = 3,
  tool = 4,
  operator_role = 5,
};

constexpr std::uint8_t kFirstKeyRole = 2;
constexpr std::uint8_t kLastKeyRole = 5;
constexpr std::size_t kNodeKeyRoles = kLastKeyRole - kFirstKeyRole + 1;

// The name of a role: "master", "haptics", "vision", "tool", "operator" or "unsealed".
constexpr std::string_view to_string(KeyRole role) noexcept {
  switch (role) {
    case KeyRole::unsealed:
      return "unsealed";
    case KeyRole::master:
      return "master";
    case KeyRole::haptics:
      return "haptics";
    case KeyRole::vision:
      return "vision";
    case KeyRole::tool:
      return "tool";
    case KeyRole::operator_role:
      return "operator";
  }
  return "unknown";
}

// A role that a node can have, by its byte on the wire; none for every other byte.
constexpr std::optional<KeyRole> find_node_key_role(std::uint8_t byte) noexcept {
  if (byte < kFirstKeyRole || byte > kLastKeyRole) return std::nullopt;
  return static_cast<KeyRole>(byte);
}

// A role that a node can have, by its name.
constexpr std::optional<KeyRole> find_node_key_role(std::string_view name) noexcept {
  for (std::uint8_t byte = kFirstKeyRole; byte <= kLastKeyRole; ++byte) {
    if (name == to_string(static_cast<KeyRole>(byte))) return static_cast<KeyRole>(byte);
  }
  return std::nullopt;
}

}  // namespace hapton
