#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/base/result.h"
#include "devices/device.h"
#include "devices/device_exchange.h"
#include "hid/hid_transport.h"

namespace hapton {

// One kind of HID force-feedback device: what its reports mean. HidDevice does what all kinds have in common.
// RT: all calls but on_open; they do no input or output. Threads: one call at a time, but any thread calls advice and the last three.
class HidBackend {
 public:
  virtual ~HidBackend() = default;

  // Called when the device was opened, for the first time or again after it was unplugged. Error, one line: the device cannot be driven, or
  // is not the one of the first on_open.
  virtual Result<void> on_open(HidTransport& transport) = 0;

  // Reads one report, with its id in front if the device numbers its reports. False: the report has no new reading or is damaged, and
  // `reading` is unchanged.
  virtual bool decode(std::span<const std::uint8_t> report, std::int64_t now_ns, DeviceExchange::Reading& reading) noexcept = 0;

  // Writes the next report for the device into `into`, its id (or 0) in front. Returned: its size; 0: there is none to send. is_live: the
  // device may exert a force. Otherwise the report turns the motors off, so that nothing compensates the device's weight either.
  virtual std::size_t encode(const Wrench& wrench, bool is_live, std::int64_t now_ns, std::span<std::uint8_t> into) noexcept = 0;

  // What the user has to do while the device is calibrating.
  virtual std::string_view advice() const noexcept { return "wait until it has finished calibrating"; }

  // Constant after the first on_open.
  virtual std::string_view name() const noexcept = 0;
  virtual const DeviceLimits& limits() const noexcept = 0;
  virtual DeviceCondition condition() const noexcept = 0;
};

}  // namespace hapton
