#include "hid/hapton_hid_reports.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace hapton::hapton_hid {
namespace {

constexpr double kPositionStepM = 1e-7;  // this and the next three: units of docs/hid.md
constexpr double kQuaternionSteps = 32767.0;
constexpr double kMicro = 1e-6;
constexpr double kMilli = 1e-3;
constexpr std::uint8_t kTemperatureUnknown = 255;
constexpr double kTemperatureSteps = 200.0;
// Rounding of the four numbers changes the length of a quaternion by less than this.
constexpr double kQuaternionTolerance = 0.01;

// Bits of the status (docs/hid.md).
constexpr std::uint8_t kCalibrated = 1, kOn = 2, kHeld = 4, kTripped = 8, kHot = 16, kFault = 32;
// Bits of the abilities (docs/hid.md).
constexpr std::uint8_t kOrientation = 1, kKnowsHeld = 2, kTorque = 4;
constexpr std::uint8_t kFlagOn = 1;

// A device that states limits beyond these is wrongly programmed, or is not one that a hand may hold.
constexpr int kMinRateHz = 100;
constexpr int kMinWatchdogMs = 5;
constexpr int kMaxWatchdogMs = 100;
constexpr double kMaxForceN = 200.0;
constexpr double kMaxTorqueNm = 20.0;
constexpr double kMaxWorkspaceM = 3.0;

std::uint16_t get16(std::span<const std::uint8_t> report, std::size_t at) noexcept {
  return static_cast<std::uint16_t>(report[at] | (report[at + 1] << 8));
}
std::uint32_t get32(std::span<const std::uint8_t> report, std::size_t at) noexcept {
  return get16(report, at) | (std::uint32_t{get16(report, at + 2)} << 16);
}
Vec3 get_position(std::span<const std::uint8_t> report, std::size_t at) noexcept {
  Vec3 position;
  for (std::size_t n = 0; n < 3; ++n) position[n] = kPositionStepM * static_cast<std::int32_t>(get32(report, at + 4 * n));
  return position;
}
std::string get_text(std::span<const std::uint8_t> report, std::size_t at, std::size_t room) {
  const auto text = report.subspan(at, room);
  return {text.begin(), std::find(text.begin(), text.end(), 0)};
}

void put16(std::span<std::uint8_t> report, std::size_t at, std::uint16_t value) noexcept {
  report[at] = static_cast<std::uint8_t>(value);
  report[at + 1] = static_cast<std::uint8_t>(value >> 8);
}
void put_micro(std::span<std::uint8_t> report, std::size_t at, double value) noexcept {
  const double counts = std::isnan(value) ? 0.0 : std::clamp(std::round(value / kMicro), -2147483647.0, 2147483647.0);
  const auto bits = static_cast<std::uint32_t>(static_cast<std::int32_t>(counts));
  put16(report, at, static_cast<std::uint16_t>(bits));
  put16(report, at + 2, static_cast<std::uint16_t>(bits >> 16));
}

Result<void> check(const Limits& limits) {
  if (limits.rate_hz < kMinRateHz) return fail("it reports {} times a second; at least {} are needed", limits.rate_hz, kMinRateHz);
  if (limits.watchdog_ms < kMinWatchdogMs || limits.watchdog_ms > kMaxWatchdogMs) {
    return fail("its watchdog takes {} ms; {} to {} are safe", limits.watchdog_ms, kMinWatchdogMs, kMaxWatchdogMs);
  }
  const Vec3 size = limits.workspace_max_m - limits.workspace_min_m;
  if (size.minCoeff() <= 0.0 || size.maxCoeff() > kMaxWorkspaceM) {
    return fail("its workspace is {:g} x {:g} x {:g} m; more than 0 and at most {} m each is possible", size.x(), size.y(), size.z(),
                kMaxWorkspaceM);
  }
  if (limits.max_force_n <= 0.0 || limits.max_force_n > kMaxForceN || limits.continuous_force_n > limits.max_force_n) {
    return fail("its force limits are {:g} N and {:g} N (continuous); the first must be above 0 and at most {} N, the second no larger",
                limits.max_force_n, limits.continuous_force_n, kMaxForceN);
  }
  if (limits.max_slew_n_per_s <= 0.0) return fail("it states no limit on how fast the force may change");
  if (limits.has_torque && (limits.max_torque_nm <= 0.0 || limits.max_torque_nm > kMaxTorqueNm || limits.max_torque_slew_nm_per_s <= 0.0)) {
    return fail("its torque limits are {:g} Nm and {:g} Nm/s; more than 0 and at most {} Nm is possible", limits.max_torque_nm,
                limits.max_torque_slew_nm_per_s, kMaxTorqueNm);
  }
  return {};
}

}  // namespace

Result<Limits> decode_limits(std::span<const std::uint8_t> report) {
  if (report.size() < kLimitsBytes || report[0] != kLimitsId || std::memcmp(report.data() + 4, "HAPT", 4) != 0) {
    return fail("its usage is that of Hapton HID, but feature report {} does not say HAPT", kLimitsId);
  }
  if (report[1] != kVersion) return fail("it speaks version {} of Hapton HID; this program speaks {}", report[1], kVersion);
  Limits limits;
  limits.has_orientation = (report[2] & kOrientation) != 0;
  limits.knows_held = (report[2] & kKnowsHeld) != 0;
  limits.has_torque = (report[2] & kTorque) != 0;
  limits.buttons = report[3];
  limits.rate_hz = get16(report, 8);
  limits.watchdog_ms = get16(report, 10);
  limits.workspace_min_m = get_position(report, 12);
  limits.workspace_max_m = get_position(report, 24);
  limits.max_force_n = kMicro * get32(report, 36);
  limits.continuous_force_n = kMicro * get32(report, 40);
  limits.max_slew_n_per_s = kMilli * get32(report, 44);
  limits.max_stiffness_n_per_m = kMilli * get32(report, 48);
  limits.max_torque_nm = limits.has_torque ? kMicro * get32(report, 52) : 0.0;
  limits.max_torque_slew_nm_per_s = limits.has_torque ? kMilli * get32(report, 56) : 0.0;
  limits.peak_s = kMilli * get16(report, 60);
  limits.max_speed_m_per_s = kMilli * get16(report, 62);
  if (auto checked = check(limits); !checked) return tl::unexpected(checked.error());
  return limits;
}

Result<Names> decode_names(std::span<const std::uint8_t> report) {
  if (report.size() < kNamesBytes || report[0] != kNamesId) return fail("feature report {} is not that of Hapton HID", kNamesId);
  return Names{get_text(report, 2, 24), get_text(report, 26, 16), get_text(report, 42, 16)};
}

std::optional<State> decode_state(std::span<const std::uint8_t> report) noexcept {
  if (report.size() < kStateBytes || report[0] != kStateId) return std::nullopt;
  Eigen::Vector4d q;
  for (std::size_t n = 0; n < 4; ++n)
    q[static_cast<Eigen::Index>(n)] = static_cast<std::int16_t>(get16(report, 20 + 2 * n)) / kQuaternionSteps;
  if (std::abs(q.norm() - 1.0) > kQuaternionTolerance) return std::nullopt;
  State state;
  state.is_calibrated = (report[1] & kCalibrated) != 0;
  state.is_on = (report[1] & kOn) != 0;
  state.is_held = (report[1] & kHeld) != 0;
  state.has_tripped = (report[1] & kTripped) != 0;
  state.is_hot = (report[1] & kHot) != 0;
  state.has_fault = (report[1] & kFault) != 0;
  state.sequence = get16(report, 2);
  state.time_us = get32(report, 4);
  state.position_m = get_position(report, 8);
  state.orientation = Quat(q.normalized());
  state.buttons = get32(report, 28);
  state.newest_force = get16(report, 32);
  if (report[34] != kTemperatureUnknown) state.temperature = report[34] / kTemperatureSteps;
  return state;
}

std::array<std::uint8_t, kForceBytes> encode_force(const Force& force) noexcept {
  std::array<std::uint8_t, kForceBytes> report = {};
  report[0] = kForceId;
  report[1] = force.is_on ? kFlagOn : 0;
  put16(report, 2, force.sequence);
  put16(report, 4, force.newest_state);
  for (std::size_t n = 0; n < 3; ++n) {
    put_micro(report, 8 + 4 * n, force.force_n[n]);
    put_micro(report, 20 + 4 * n, force.torque_nm[n]);
  }
  return report;
}

}  // namespace hapton::hapton_hid
