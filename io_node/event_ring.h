#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "link/endpoint.h"
#include "link/messages.h"
#include "safety/safety_fault.h"

namespace hapton {

// An event for the log, from the device side or the network side.
struct ServoEvent {
  enum class Kind : std::uint8_t {
    joined,
    left,
    rejected,
    rate_changed,
    method_requested,
    material_requested,
    wrong_key,
    wrong_version,
    latched,
    reset,
    reset_rejected,
    away,
    calibrating,
    back,
    reset_without_right,   // a tool whose key is not an operator's requested a reset
    reset_without_person,  // an operator requested a reset, but no person is known to be at the device
    flood,                 // more datagrams were rejected than any program of good will sends
    out_of_reach,          // the device cannot reach the scene
    too_small,             // the scene is too small for the device's workspace to be found in it
    in_reach,              // the device can reach the scene, after out_of_reach or too_small
    parts_requested,       // parts of the scene were requested, so that io_node computes the force
    force_from_parts,      // io_node computes the force, from parts of the scene
    force_from_haptics,    // the haptics node computes the force again
    role_violation,        // a node requested a role, or sent a message, that its key does not allow
  };
  Kind kind = Kind::joined;
  NodeRole role = NodeRole::tool;
  Address address;
  double rate_hz = 0.0;                    // of rate_changed: the new rate; of flood: datagrams in a second
  std::array<char, 16> method = {};        // of method_requested
  SafetyFault fault = SafetyFault::none;   // of latched, reset and reset_rejected
  Rejection flood = Rejection::malformed;  // of flood: the most frequent kind of rejection
  bool is_from_several = false;            // of flood: from other addresses as well
  bool is_mostly_filtered = false;         // of flood: most of it was dropped in the kernel
  double round_trip_s = -1.0;              // of parts_requested and force_from_haptics; below 0: not known
};

// Passes events from the network side to a thread without deadlines. A full ring drops new events and counts them; its last
// kReservedForFaults places are kept for latched faults and resets, which a flood of requests must not hide. RT: push yes, wait-free.
// Threads: one pushes, one pops; any calls dropped().
class EventRing {
 public:
  void push(const ServoEvent& event) noexcept {
    const std::size_t end = end_.load(std::memory_order_relaxed);
    const bool is_of_fault = event.kind == ServoEvent::Kind::latched || event.kind == ServoEvent::Kind::reset;
    if (end - begin_.load(std::memory_order_acquire) >= kCapacity - (is_of_fault ? 0 : kReservedForFaults)) {
      dropped_.fetch_add(1, std::memory_order_relaxed);
      return;
    }
    events_[end % kCapacity] = event;
    end_.store(end + 1, std::memory_order_release);
  }

  bool pop(ServoEvent& event) noexcept {
    const std::size_t begin = begin_.load(std::memory_order_relaxed);
    if (begin == end_.load(std::memory_order_acquire)) return false;
    event = events_[begin % kCapacity];
    begin_.store(begin + 1, std::memory_order_release);
    return true;
  }

  std::uint64_t dropped() const noexcept { return dropped_.load(std::memory_order_relaxed); }

 private:
  // The ring is emptied every 20 ms (io_session.cpp); a node that joins or fails makes a few events.
  static constexpr std::size_t kCapacity = 64;
  static constexpr std::size_t kReservedForFaults = 8;  // few: only a person resets a fault, which can then be latched again
  std::array<ServoEvent, kCapacity> events_ = {};
  alignas(64) std::atomic<std::size_t> begin_{0};
  alignas(64) std::atomic<std::size_t> end_{0};
  std::atomic<std::uint64_t> dropped_{0};
};

}  // namespace hapton
