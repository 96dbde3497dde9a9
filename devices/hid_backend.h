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
// RT: all calls but on_open; they do no input or output. Threads: one call at a time.
class HidBackend {
 public:
  virtual ~HidBackend() = default;

  // Called when the device was opened, at first or again after it was unplugged. Error, one line: it cannot be driven, or it is another
  // device than at the first on_open.
  virtual Result<void> on_open(HidTransport& transport) = 0;

  // Reads one report, with its id in front if the device numbers its reports. False: it has no reading or is damaged, and `reading` is
  // unchanged.
  virtual bool decode(std::span<const std::uint8_t> report, std::int64_t now_ns, DeviceExchange::Reading& reading) noexcept = 0;

  // Writes the next report to the device, with its id (or 0) in front. Returned: its size; 0: there is none to send. is_live: the device
  // may exert a force. Otherwise it must release it, and its motors be off: no compensation of its own weight either.
  virtual std::size_t encode(const Wrench& wrench, bool is_live, std::int64_t now_ns, std::span<std::uint8_t> into) noexcept = 0;

  // What the user has to do while the device is calibrating.
  virtual std::string_view advice() const noexcept { return "wait until it has finished calibrating"; }

  // Known from the first on_open on.
  virtual std::string_view name() const noexcept = 0;
  virtual const DeviceLimits& limits() const noexcept = 0;
  virtual DeviceCondition condition() const noexcept = 0;
};

}  // namespace hapton
