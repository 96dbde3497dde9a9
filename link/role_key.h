#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "link/key_role.h"

namespace hapton {

class LinkKey;

// The key of one role, held by a node. The hub derives the same key from the master key; neither the master key nor another role's key can
// be derived from it. It is wiped from memory on destruction.
class RoleKey {
 public:
  static constexpr std::size_t kBytes = 32;
  using Bytes = std::array<std::uint8_t, kBytes>;

  // Pre: role is one that a node can have; seal::start_crypto() succeeded before the first constructor is called.
  RoleKey(const LinkKey& master, KeyRole role);
  RoleKey(const Bytes& bytes, KeyRole role) : bytes_(bytes), role_(role) {}
  ~RoleKey();
  RoleKey(const RoleKey&) = default;
  RoleKey& operator=(const RoleKey&) = default;

  const Bytes& bytes() const { return bytes_; }
  KeyRole role() const { return role_; }

 private:
  Bytes bytes_;
  KeyRole role_;
};

}  // namespace hapton
