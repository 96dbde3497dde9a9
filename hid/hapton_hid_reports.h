#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "core/base/result.h"
#include "core/math/types.h"

namespace hapton {

// The host's side of Hapton HID, version 1 (docs/hid.md). The first byte of a report is its id; numbers are little-endian.
namespace hapton_hid {

constexpr std::uint8_t kVersion = 1;
constexpr std::uint8_t kStateId = 1;
constexpr std::uint8_t kForceId = 2;
constexpr std::uint8_t kLimitsId = 3;
constexpr std::uint8_t kNamesId = 4;
constexpr std::size_t kStateBytes = 36;
constexpr std::size_t kForceBytes = 32;
constexpr std::size_t kLimitsBytes = 64;
constexpr std::size_t kNamesBytes = 58;

// Feature report 3. SI units, frame W.
struct Limits {
  bool has_orientation = false;
  bool knows_held = false;  // the device senses whether a hand holds it
  bool has_torque = false;
  int buttons = 0;
  int rate_hz = 0;
  int watchdog_ms = 0;
  Vec3 workspace_min_m = Vec3::Zero();
  Vec3 workspace_max_m = Vec3::Zero();
  double max_force_n = 0.0;
  double continuous_force_n = 0.0;
  double max_slew_n_per_s = 0.0;
  double max_stiffness_n_per_m = 0.0;
  double max_torque_nm = 0.0;
  double max_torque_slew_nm_per_s = 0.0;
  double peak_s = 0.0;
  double max_speed_m_per_s = 0.0;

  friend bool operator==(const Limits&, const Limits&) = default;
};

// Feature report 4. The texts should be UTF-8, but are not checked.
struct Names {
  std::string model;
  std::string serial;
  std::string firmware;
};

// Input report 1.
struct State {
  bool is_calibrated = false;
  bool is_on = false;  // the motors are on
  bool is_held = false;
  bool has_tripped = false;  // the device's watchdog has tripped: the motors stay off until they are commanded off
  bool is_hot = false;
  bool has_fault = false;
  std::uint16_t sequence = 0;
  std::uint32_t time_us = 0;
  Vec3 position_m = Vec3::Zero();
  Quat orientation = Quat::Identity();
  std::uint32_t buttons = 0;
  std::uint16_t newest_force = 0;  // sequence of the newest force report that the device has received
  double temperature = -1.0;       // 0: cold, 1: the hottest allowed, up to 1.27; below 0: not known
};

// Output report 2.
struct Force {
  bool is_on = false;
  std::uint16_t sequence = 0;
  std::uint16_t newest_state = 0;
  Vec3 force_n = Vec3::Zero();
  Vec3 torque_nm = Vec3::Zero();
};

// Error: not a Hapton HID device, another version, or limits that are impossible or unsafe; one line without the device's name.
Result<Limits> decode_limits(std::span<const std::uint8_t> report);
Result<Names> decode_names(std::span<const std::uint8_t> report);

// None: too short, another report, or an invalid quaternion. Longer reports are accepted: a later version may add to them. RT: yes.
std::optional<State> decode_state(std::span<const std::uint8_t> report) noexcept;

// Values beyond the format's range, 2147 N, are clamped to it; NaN becomes zero. RT: yes.
std::array<std::uint8_t, kForceBytes> encode_force(const Force& force) noexcept;

}  // namespace hapton_hid
}  // namespace hapton
