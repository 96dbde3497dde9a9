#pragma once

#include <cstdint>

#include "link/key_role.h"

namespace hapton {

// Whether a request to reset a latched fault counts.
enum class ResetDecision : std::uint8_t {
  granted,
  no_right,  // the sender's key is not an operator's
  no_person  // no person is known to be at the device
};

// A reset lets the force come back, so two things must hold. The right: the session's key is an operator's. Presence: a person is at the
// device, which is known when the request comes from the hub's own host (loopback addresses cannot come from a network), or while the dead
// man's switch that the device was started with is held.
// KeyRole::unsealed is the role of in-memory endpoints; no sealed session has it. RT: yes.
constexpr ResetDecision check_reset(KeyRole key_role, bool is_from_this_host, bool is_switch_held) noexcept {
  if (key_role != KeyRole::operator_role && key_role != KeyRole::unsealed) return ResetDecision::no_right;
  return is_from_this_host || is_switch_held ? ResetDecision::granted : ResetDecision::no_person;
}

}  // namespace hapton
