#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/base/result.h"
#include "devices/device.h"
#include "devices/device_exchange.h"
#include "hid/hid_transport.h"

namespace hapton {

// What is special about one kind of HID force-feedback device: what its reports mean. HidDevice does the rest.
// All calls but begin are RT and pure. Threads: one call at a time.
class HidBackend {
 public:
  virtual ~HidBackend() = default;

  // The device is there, for the first time or after it was gone. Error: it cannot be driven, one line; or it is not the one it was.
  virtual Result<void> begin(HidTransport& transport) = 0;

  // A report, an id in front if the device numbers them; false: it says nothing, or it is damaged, and `reading` is as it was.
  virtual bool decode(std::span<const std::uint8_t> report, std::int64_t now_ns, DeviceExchange::Reading& reading) noexcept = 0;

  // The next report to the device, an id (or 0) in front: its size, or 0 for none. is_live: the device may exert a force; else it must
  // release it.
  virtual std::size_t encode(const Wrench& wrench, bool is_live, std::int64_t now_ns, std::span<std::uint8_t> into) noexcept = 0;

  // What a person is to do while the device is calibrating.
  virtual std::string_view advice() const noexcept { return "wait until it has finished calibrating"; }

  // As of the first begin.
  virtual std::string_view name() const noexcept = 0;
  virtual const DeviceLimits& limits() const noexcept = 0;
  virtual DeviceCondition condition() const noexcept = 0;
};

}  // namespace hapton
