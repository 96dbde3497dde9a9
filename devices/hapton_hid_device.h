#pragma once

#include <memory>
#include <optional>

#include "core/base/result.h"
#include "devices/device_settings.h"
#include "devices/hid_backend.h"
#include "hid/hapton_hid_reports.h"

namespace hapton {

// Any maker's device that speaks Hapton HID (docs/hid.md). Its limits are those that it reports when it is first opened; if a device comes
// back with other limits or another serial number, it is taken for another device and not driven.
class HaptonHidBackend final : public HidBackend {
 public:
  Result<void> on_open(HidTransport& transport) override;
  bool decode(std::span<const std::uint8_t> report, std::int64_t now_ns, DeviceExchange::Reading& reading) noexcept override;
  std::size_t encode(const Wrench& wrench, bool is_live, std::int64_t now_ns, std::span<std::uint8_t> into) noexcept override;
  std::string_view advice() const noexcept override { return "it requests calibration; follow its manual"; }
  std::string_view name() const noexcept override { return "Hapton HID"; }
  const DeviceLimits& limits() const noexcept override { return device_limits_; }
  DeviceCondition condition() const noexcept override {
    return {.model = names_.model, .serial = names_.serial, .firmware = names_.firmware};
  }

 private:
  std::optional<hapton_hid::Limits> limits_;
  DeviceLimits device_limits_;
  hapton_hid::Names names_;
  std::optional<std::uint16_t> newest_state_;
  std::uint16_t sequence_ = 0;
};

// settings.id: serial number, path, or index among such devices (from 0). RT: set-up only. Error: one line.
Result<std::unique_ptr<Device>> make_hapton_hid(const DeviceSettings& settings);

}  // namespace hapton
