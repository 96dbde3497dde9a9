// Any bytes as a report descriptor of a HID device, or as reports of a supported kind of device; the first byte selects which.
#include <algorithm>
#include <array>
#include <cmath>

#include "devices/hapton_hid_device.h"
#include "devices/wooden_haptics.h"
#include "hid/hapton_hid_reports.h"
#include "hid/hid_layout.h"
#include "hid/space_mouse.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/support/fake_hid.h"

namespace hapton {
namespace {

// Reports of 64 bytes at most, one after the other; each begins with its length.
template <class Take>
void for_each_report(std::span<const std::uint8_t> bytes, Take&& take) {
  while (!bytes.empty()) {
    const std::size_t size = std::min<std::size_t>(bytes[0] % 65, bytes.size() - 1);
    take(bytes.subspan(1, size));
    bytes = bytes.subspan(1 + size);
  }
}

void drive(HidBackend& backend, std::span<const std::uint8_t> bytes, double max_force_mn) {
  DeviceExchange::Reading reading;
  std::int64_t now_ns = kNanosecondsPerSecond;
  for_each_report(bytes, [&](std::span<const std::uint8_t> report) {
    now_ns += kNanosecondsPerMillisecond;
    (void)backend.decode(report, now_ns, reading);
    fuzz::require(reading.sample.p_WD.allFinite() && std::abs(reading.sample.q_WT.norm() - 1.0) < 1e-9);
    std::array<std::uint8_t, 64> out;
    const std::size_t size = backend.encode({.force_n = Vec3(5, -5, 5)}, report.size() % 2 == 0, now_ns, out);
    fuzz::require(size > 0 && size <= out.size());
    for (std::size_t at = 1; max_force_mn > 0.0 && at < 7; at += 2) {
      fuzz::require(std::abs(static_cast<std::int16_t>(static_cast<std::uint16_t>(out[at] | (out[at + 1] << 8)))) <= max_force_mn);
    }
  });
}

void drive_wooden(std::span<const std::uint8_t> bytes, std::size_t report_bytes) {
  HidDescription description;
  description.layout.reports = {{0, report_bytes, report_bytes, 0}};
  const FakeHid hid(description);
  const auto transport = hid.opener()();
  WoodenHapticsBackend backend(WoodenSettings::make_default());
  fuzz::require(backend.on_open(**transport).has_value());
  drive(backend, bytes, 3000.0);
}

// The first two reports are the device's description of itself.
void drive_hapton_hid(std::span<const std::uint8_t> bytes) {
  FakeHid hid;
  std::size_t feature_bytes = 0;
  for (const std::size_t size : {hapton_hid::kLimitsBytes, hapton_hid::kNamesBytes}) {
    const auto feature = bytes.subspan(feature_bytes, std::min(size, bytes.size() - feature_bytes));
    if (!feature.empty()) hid.set_feature(feature[0], FakeHid::Bytes(feature.begin(), feature.end()));
    feature_bytes += feature.size();
  }
  const auto transport = hid.opener()();
  HaptonHidBackend backend;
  if (const auto opened = backend.on_open(**transport); !opened) return fuzz::require(opened.error().what.find('\n') == std::string::npos);
  fuzz::require(backend.limits().max_force_n > 0.0 && backend.limits().max_force_n <= 200.0);
  drive(backend, bytes.subspan(feature_bytes), 0.0);
}

void drive_space_mouse(std::span<const std::uint8_t> bytes) {
  SpaceMouseDecoder decoder;
  std::int64_t now_ns = kNanosecondsPerSecond;
  for_each_report(bytes, [&](std::span<const std::uint8_t> report) {
    (void)decoder.take(report, now_ns);
    now_ns += 50 * kNanosecondsPerMillisecond;
    const SpaceMouseState state = decoder.state(now_ns);
    fuzz::require(state.push.cwiseAbs().maxCoeff() <= 1.0 && state.turn.cwiseAbs().maxCoeff() <= 1.0);
  });
}

}  // namespace
}  // namespace hapton

FUZZ_TARGET(hid) {
  using namespace hapton;
  if (bytes.empty()) return;
  const auto rest = bytes.subspan(1);
  switch (bytes[0] % 5) {
    case 0:
      for (const HidLayout::Report& report : read_hid_layout(rest).reports) fuzz::require(report.input_bytes <= std::size_t{1} << 16);
      return;
    case 1:
      return drive_wooden(rest, 8);
    case 2:
      return drive_wooden(rest, 14);
    case 3:
      return drive_hapton_hid(rest);
    default:
      return drive_space_mouse(rest);
  }
}
