#pragma once

#include <cstdint>
#include <optional>

#include "devices/device.h"
#include "devices/device_exchange.h"

namespace hapton {

// A device that a vendor's library or service drives from a thread of its own: the servo exchanges newest values with that thread, and the
// watchdog process, which cannot reach such a device, kills the process that drives it. RT and threads: as Device and DeviceExchange say.
class VendorDevice : public Device {
 public:
  DeviceSample read(std::int64_t now_ns) noexcept final { return exchange_.read(now_ns); }
  void write(const Wrench& wrench, std::int64_t now_ns) noexcept final { exchange_.write(wrench, now_ns); }
  bool cut() noexcept final {
    exchange_.cut();
    return true;
  }
  void restore() noexcept final { exchange_.restore(); }
  void use_heartbeat_page(HeartbeatPage& page) noexcept final { page.set_means(CutMeans::kill); }
  DeviceStatus status() const noexcept final { return exchange_.status(); }
  bool set_hand_target(const std::optional<Vec3>&) noexcept final { return false; }

 protected:
  DeviceExchange exchange_;
};

}  // namespace hapton
