#include "tests/hid_guest/virtual_devices.h"

#include <cmath>

namespace hapton::guest {
namespace {

constexpr double kUpperArmDegrees = 40.0;
constexpr double kCountsPerDegree = 2000.0 * 12.0 / 360.0;

Bytes wooden_descriptor(std::uint8_t bytes) {
  return {0x06, 0xAB, 0xFF,  0x0A, 0x00, 0x02, 0xA1, 0x01, 0x75,  0x08, 0x15, 0x00, 0x26, 0xFF,
          0x00, 0x95, bytes, 0x09, 0x01, 0x81, 0x02, 0x95, bytes, 0x09, 0x02, 0x91, 0x02, 0xC0};
}

// The descriptor of a SpaceNavigator: page 1, usage 8; report 1 has translations, report 2 rotations, report 3 two buttons.
const Bytes kSpaceMouseDescriptor = {
    0x05, 0x01, 0x09, 0x08, 0xA1, 0x01,                                                                          //
    0xA1, 0x00, 0x85, 0x01, 0x16, 0xA2, 0xFE, 0x26, 0x5E, 0x01, 0x36, 0x88, 0xFA, 0x46, 0x78, 0x05, 0x55, 0x0C,  //
    0x65, 0x11, 0x09, 0x30, 0x09, 0x31, 0x09, 0x32, 0x75, 0x10, 0x95, 0x03, 0x81, 0x06, 0xC0,                    //
    0xA1, 0x00, 0x85, 0x02, 0x09, 0x33, 0x09, 0x34, 0x09, 0x35, 0x75, 0x10, 0x95, 0x03, 0x81, 0x06, 0xC0,        //
    0xA1, 0x02, 0x85, 0x03, 0x05, 0x09, 0x19, 0x01, 0x29, 0x02, 0x15, 0x00, 0x25, 0x01, 0x35, 0x00, 0x45, 0x01,  //
    0x75, 0x01, 0x95, 0x02, 0x81, 0x02, 0x95, 0x0E, 0x81, 0x03, 0xC0, 0xC0};

void put16(Bytes& bytes, int value) {
  bytes.push_back(static_cast<std::uint8_t>(value));
  bytes.push_back(static_cast<std::uint8_t>(value >> 8));
}

int int16_at(const Bytes& bytes, std::size_t at) {
  return static_cast<std::int16_t>(static_cast<std::uint16_t>(bytes[at] | (bytes[at + 1] << 8)));
}

hapton_hid_limits maker_limits() {
  hapton_hid_limits limits = {};
  limits.has_orientation = true;
  limits.rate_hz = 1000;
  limits.watchdog_ms = VirtualHaptonHid::kWatchdogMs;
  for (int n = 0; n < 3; ++n) {
    limits.workspace_min_m[n] = -0.1f;
    limits.workspace_max_m[n] = 0.1f;
  }
  limits.max_force_n = static_cast<float>(VirtualHaptonHid::kMaxForceN);
  limits.max_slew_n_per_s = 2000.0f;
  limits.max_stiffness_n_per_m = 1000.0f;
  limits.model = "Virtual arm";
  limits.serial = "V1";
  limits.firmware = "1";
  return limits;
}

}  // namespace

VirtualWooden::VirtualWooden(bool has_wrist)
    : UhidDevice({"HID DEVICE", has_wrist ? "W14" : "W8", 0x1234, 0x0006, wooden_descriptor(has_wrist ? 14 : 8)}), has_wrist_(has_wrist) {}

std::array<std::int16_t, 3> VirtualWooden::counts() const {
  const auto rounded = [](double degrees) { return static_cast<std::int16_t>(std::lround(degrees * kCountsPerDegree)); };
  return {0, rounded(kUpperArmDegrees), rounded(degrees_)};
}

std::vector<Bytes> VirtualWooden::make_inputs(std::uint32_t) {
  Bytes report;
  for (const std::int16_t count : counts()) put16(report, count);
  for (int wrist = 0; has_wrist_ && wrist < 3; ++wrist) put16(report, 100 * wrist);
  put16(report, counter_++);
  return {report};
}

// hidraw passes on to uhid the leading 0 of a report without a number; over USB a device would not get it.
void VirtualWooden::take_output(const Bytes& report, std::uint32_t) {
  const std::size_t size = has_wrist_ ? 14 : 8;
  if (report.size() != size && report.size() != size + 1) return;
  const std::size_t at = report.size() - size;
  received_.add(Vec3(int16_at(report, at), int16_at(report, at + 2), int16_at(report, at + 4)));
}

VirtualHaptonHid::VirtualHaptonHid()
    : UhidDevice({"Virtual arm", "V1", 0xCAFE, 0x4001, Bytes(std::begin(hapton_hid_descriptor), std::end(hapton_hid_descriptor))}) {
  const hapton_hid_limits limits = maker_limits();
  hapton_hid_init(&device_, &limits);
}

std::vector<Bytes> VirtualHaptonHid::make_inputs(std::uint32_t time_us) {
  hapton_hid_measured measured = {};
  measured.is_calibrated = true;
  measured.position_m[2] = static_cast<float>(z_m_.load());
  measured.orientation[3] = 1.0f;
  measured.temperature = 0.1f;
  Bytes report(HAPTON_HID_STATE_BYTES);
  hapton_hid_state(&device_, &measured, time_us, report.data());
  is_on_ = device_.is_on;
  return {report};
}

void VirtualHaptonHid::take_output(const Bytes& report, std::uint32_t time_us) {
  if (!hapton_hid_take_force(&device_, report.data(), report.size(), time_us)) return;
  float force[3], torque[3];
  hapton_hid_motors(&device_, time_us, force, torque);
  received_.add(Vec3(force[0], force[1], force[2]));
}

Bytes VirtualHaptonHid::make_feature(std::uint8_t id) {
  Bytes report(64);
  report.resize(hapton_hid_feature(&device_, id, report.data(), report.size()));
  return report;
}

VirtualSpaceMouse::VirtualSpaceMouse() : UhidDevice({"SpaceMouse Compact", "S1", 0x256F, 0xC635, kSpaceMouseDescriptor}) {}

std::vector<Bytes> VirtualSpaceMouse::make_inputs(std::uint32_t time_us) {
  if (static_cast<std::int32_t>(time_us - next_us_) < 0) return {};
  next_us_ = time_us + 16'000;
  Bytes pushed = {1}, turned = {2}, pressed = {3};
  put16(pushed, x_);
  for (int n = 0; n < 2; ++n) put16(pushed, 0);
  for (int n = 0; n < 3; ++n) put16(turned, 0);
  put16(pressed, buttons_);
  return {pushed, turned, pressed};
}

VirtualUnknownDevice::VirtualUnknownDevice() : UhidDevice({"Unknown", "X1", 0xCAFE, 0x0001, wooden_descriptor(8)}) {}

}  // namespace hapton::guest
