#include "devices/wooden_haptics.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "devices/hid_device.h"
#include "hid/hidapi_transport.h"

namespace hapton {
namespace {

constexpr std::size_t kShortReport = 8;  // bytes, as wooden_haptics.h lists them
constexpr std::size_t kLongReport = 14;
// In encoder counts. After a loss of power the counts are near zero, although the arm cannot have moved so far meanwhile. Both limits are
// choices: 0.75 and 3 degrees for an arm with 2000 counts per turn of the motor and a ratio of 12.
constexpr int kNearZero = 50;
constexpr int kMovedCounts = 200;
constexpr int kStillCounts = 1;               // an encoder between two counts flickers
constexpr double kMaxMilliamperes = 32767.0;  // of an int16
constexpr double kLongestGapS = 0.01;         // a longer time between two reports counts as this, so that the ramp does not jump

// B to W: the base's x points to the person, its z up.
Vec3 to_world(const Vec3& in_base) noexcept { return {in_base.y(), in_base.z(), in_base.x()}; }
Vec3 to_base(const Vec3& in_world) noexcept { return {in_world.z(), in_world.x(), in_world.y()}; }

Quat base_in_world() noexcept {
  Mat3 turn;
  turn << 0, 1, 0, 0, 0, 1, 1, 0, 0;
  return Quat(turn);
}

std::int16_t int16_at(std::span<const std::uint8_t> report, std::size_t byte) noexcept {
  return static_cast<std::int16_t>(static_cast<std::uint16_t>(report[byte] | (report[byte + 1] << 8)));
}

void put_int16(std::span<std::uint8_t> into, std::size_t byte, double value) noexcept {
  const auto rounded =
      static_cast<std::uint16_t>(static_cast<std::int16_t>(std::clamp(std::round(value), -kMaxMilliamperes, kMaxMilliamperes)));
  into[byte] = static_cast<std::uint8_t>(rounded);
  into[byte + 1] = static_cast<std::uint8_t>(rounded >> 8);
}

std::int16_t subtract_modulo(std::int16_t a, std::int16_t b) noexcept {
  return static_cast<std::int16_t>(static_cast<std::uint16_t>(a) - static_cast<std::uint16_t>(b));
}

// The largest share of `added` for which held + share * added stays within the limit, each motor for itself; 0 .. 1.
double find_share(const Vec3& held, const Vec3& added, double limit) noexcept {
  double share = 1.0;
  for (int n = 0; n < 3; ++n) {
    if (added[n] == 0.0) continue;
    const double room = std::max(limit - std::copysign(1.0, added[n]) * held[n], 0.0);
    share = std::min(share, room / std::abs(added[n]));
  }
  return share;
}

}  // namespace

Result<void> WoodenHapticsBackend::on_open(HidTransport& transport) {
  const HidDescription& device = transport.description();
  const HidLayout::Report* report = device.layout.find_report(0);
  std::size_t bytes = static_cast<std::size_t>(settings_.report_bytes);
  if (bytes == 0 && report == nullptr) {
    return fail("{}: its report descriptor cannot be read; say which variant it is with report_bytes = 8 or 14 in a --device-file",
                device.path);
  }
  if (bytes == 0) bytes = report->input_bytes;
  if (bytes != kShortReport && bytes != kLongReport) {
    return fail("{}: its reports have {} bytes; WoodenHaptics has 8 or 14, so it is another device or firmware", device.path, bytes);
  }
  report_bytes_ = bytes;
  if (serial_.empty()) serial_ = device.serial;
  is_first_report_ = true;
  still_ns_ = 0;
  gravity_share_ = 0.0;
  return {};
}

// ready while the counts have the same zero as before. If the electronics restarted: calibrating, until the arm has rested.
DeviceStatus WoodenHapticsBackend::update_zero(const Counts& counts, std::int64_t now_ns) noexcept {
  const auto arm_differs = [](const Counts& a, const Counts& b, int by) {
    return std::abs(subtract_modulo(a[0], b[0])) > by || std::abs(subtract_modulo(a[1], b[1])) > by ||
           std::abs(subtract_modulo(a[2], b[2])) > by;
  };
  if (std::exchange(is_first_report_, false) && has_counts_ && !arm_differs(counts, {}, kNearZero) &&
      arm_differs(counts, counts_, kMovedCounts)) {
    is_zero_lost_ = true;
  }
  has_counts_ = true;
  counts_ = counts;
  if (!is_zero_lost_) return DeviceStatus::ready;
  if (still_ns_ == 0 || arm_differs(counts, still_counts_, kStillCounts)) {
    still_counts_ = counts;
    still_ns_ = now_ns;
  }
  if (now_ns - still_ns_ < kRestNs) return DeviceStatus::calibrating;
  rest_counts_ = counts;
  is_zero_lost_ = false;
  return DeviceStatus::ready;
}

std::string_view WoodenHapticsBackend::advice() const noexcept {
  return "encoders restarted from zero: hold the arm in its rest pose for 2 s, upper arm upright, lower arm hanging down";
}

bool WoodenHapticsBackend::decode(std::span<const std::uint8_t> report, std::int64_t now_ns, DeviceExchange::Reading& reading) noexcept {
  if (report.size() != report_bytes_) return false;
  Counts counts = {};
  const std::size_t encoders = report_bytes_ == kLongReport ? 6 : 3;
  for (std::size_t n = 0; n < encoders; ++n) counts[n] = int16_at(report, 2 * n);
  reading.status = update_zero(counts, now_ns);
  reading.is_calibrated = reading.status == DeviceStatus::ready;
  angles_rad_ = kinematics_.angles_rad({subtract_modulo(counts[0], rest_counts_[0]), subtract_modulo(counts[1], rest_counts_[1]),
                                        subtract_modulo(counts[2], rest_counts_[2])});
  reading.sample.p_WD = to_world(position_m());
  reading.sample.q_WT = compute_orientation();
  return true;
}

Quat WoodenHapticsBackend::compute_orientation() const noexcept {
  if (!settings_.wrist || report_bytes_ != kLongReport) return Quat::Identity();
  Quat q = base_in_world() * kinematics_.lower_arm(angles_rad_);
  for (std::size_t n = 0; n < 3; ++n) {
    const WoodenWrist::Joint& joint = settings_.wrist->joints[n];
    const double turned = 2.0 * std::numbers::pi * subtract_modulo(counts_[3 + n], rest_counts_[3 + n]) / joint.counts_per_turn;
    q = q * Quat(Eigen::AngleAxisd(joint.direction * turned + joint.offset_rad, joint.axis));
  }
  return q.normalized();
}

// The current for the weight of the arm comes first, so that the arm does not sink when a force needs all the current.
Vec3 WoodenHapticsBackend::compute_currents_a(const Vec3& force_n, bool is_live, std::int64_t now_ns) noexcept {
  const double passed_s = std::clamp(1e-9 * static_cast<double>(now_ns - std::exchange(last_encode_ns_, now_ns)), 0.0, kLongestGapS);
  gravity_share_ = is_live && settings_.has_gravity_compensation ? std::min(gravity_share_ + passed_s / kGravityRampS, 1.0) : 0.0;
  if (!is_live || !force_n.allFinite()) return Vec3::Zero();
  const double limit = settings_.max_current_a;
  const Vec3 weight =
      kinematics_.motor_current_a(gravity_share_ * kinematics_.gravity_torque_nm(angles_rad_)).cwiseMax(-limit).cwiseMin(limit);
  const Vec3 push = kinematics_.motor_current_a(kinematics_.joint_torque_nm(angles_rad_, to_base(force_n)));
  return weight + find_share(weight, push, limit) * push;
}

std::size_t WoodenHapticsBackend::encode(const Wrench& wrench, bool is_live, std::int64_t now_ns, std::span<std::uint8_t> into) noexcept {
  const std::size_t size = 1 + report_bytes_;
  if (into.size() < size) return 0;
  std::fill_n(into.begin(), size, std::uint8_t{0});
  const Vec3 currents_a = compute_currents_a(wrench.force_n, is_live, now_ns);
  for (std::size_t n = 0; n < 3; ++n) put_int16(into, 1 + 2 * n, 1e3 * currents_a[static_cast<Eigen::Index>(n)]);
  return size;
}

Result<std::unique_ptr<Device>> make_wooden_haptics(const DeviceSettings& settings) {
  WoodenSettings wooden = WoodenSettings::make_default();
  if (!settings.file.empty()) {
    auto read = read_wooden_settings(settings.file);
    if (!read) return tl::unexpected(read.error());
    wooden = *read;
  }
  return HidDevice::open(std::make_unique<WoodenHapticsBackend>(wooden), make_hid_opener(HidKind::wooden_haptics, settings.id),
                         settings.realtime);
}

}  // namespace hapton
