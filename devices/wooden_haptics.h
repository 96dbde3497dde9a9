#pragma once

#include <memory>

#include "core/base/result.h"
#include "devices/device_settings.h"
#include "devices/hid_backend.h"
#include "devices/wooden_settings.h"

namespace hapton {

// WoodenHaptics, the open-hardware device. Its reports contain:
//   in, 8 bytes:   int16 encoder a, b, c; uint16 counter
//   out, 8 bytes:  int16 current a, b, c in mA; uint16 unused
//   in, 14 bytes (from 2018):  int16 encoder a .. f; int16 that is ignored
//   out, 14 bytes: int16 current a, b, c in mA; int16 command; 3 int16 attributes; command and attributes stay 0
// Little-endian, without report numbers. The motors are on while reports come, and off 0.5 s after the last.
//
// The encoders count from where the arm was when its electronics got power: that must be its rest pose, upper arm upright, lower arm
// hanging down. When the electronics restart while in use, the device is calibrating until the arm has not moved for kRestNs; that pose is
// assumed to be the rest pose. W: x is the base's y (right), y its z (up), z its x (from the column to the person).
class WoodenHapticsBackend final : public HidBackend {
 public:
  // A choice; advice() tells the person to hold the arm for this time.
  static constexpr std::int64_t kRestNs = 2 * kNanosecondsPerSecond;
  // Duration of the ramp up of the compensation of the arm's weight. A choice: slow enough that the arm does not jump.
  static constexpr double kGravityRampS = 0.5;

  explicit WoodenHapticsBackend(const WoodenSettings& settings) : settings_(settings), kinematics_(settings.arm) {}

  Result<void> on_open(HidTransport& transport) override;
  bool decode(std::span<const std::uint8_t> report, std::int64_t now_ns, DeviceExchange::Reading& reading) noexcept override;
  std::size_t encode(const Wrench& wrench, bool is_live, std::int64_t now_ns, std::span<std::uint8_t> into) noexcept override;
  std::string_view name() const noexcept override { return "WoodenHaptics"; }
  const DeviceLimits& limits() const noexcept override { return settings_.limits; }
  std::string_view advice() const noexcept override;
  DeviceCondition condition() const noexcept override { return {.model = name(), .serial = serial_, .firmware = {}}; }

 private:
  using Counts = std::array<std::int16_t, 6>;

  Vec3 position_m() const noexcept { return kinematics_.position_m(angles_rad_); }
  Quat compute_orientation() const noexcept;
  DeviceStatus update_zero(const Counts& counts, std::int64_t now_ns) noexcept;
  Vec3 compute_currents_a(const Vec3& force_n, bool is_live, std::int64_t now_ns) noexcept;

  WoodenSettings settings_;
  WoodenKinematics kinematics_;
  std::string serial_;
  std::size_t report_bytes_ = 8;

  Counts counts_ = {};        // the counts in the newest report
  Counts rest_counts_ = {};   // the counts in the rest pose
  Counts still_counts_ = {};  // the arm has been within one count of these since still_ns_; 0: unknown
  std::int64_t still_ns_ = 0;
  bool has_counts_ = false;      // a report has been decoded, perhaps before the device was opened again
  bool is_first_report_ = true;  // no report has been decoded since the device was opened
  bool is_zero_lost_ = false;
  Vec3 angles_rad_ = Vec3::Zero();
  double gravity_share_ = 0.0;
  std::int64_t last_encode_ns_ = 0;
};

// settings.id: serial number, path, or index among such devices (from 0); settings.file: see read_wooden_settings. RT: set-up only. Error:
// one line.
Result<std::unique_ptr<Device>> make_wooden_haptics(const DeviceSettings& settings);

}  // namespace hapton
