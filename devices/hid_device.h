#pragma once

#include <semaphore.h>

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "devices/device.h"
#include "devices/device_exchange.h"
#include "devices/hid_backend.h"
#include "hid/hid_port.h"

namespace hapton {

// A force-feedback device that speaks HID. Two threads of its own talk to it, because a write may wait for the bus: one reads and drains
// (HidPort), one writes the newest wrench as soon as there is one, and repeats it every kRepeatNs, so that a watchdog in the device does
// not trip. The servo only exchanges newest values with them. An unplugged device is away; it is searched for, and when it is back its
// force starts at zero and ramps up. While the servo neither reads nor writes, the device is commanded to release the force.
// RT and Threads: as Device says.
class HidDevice final : public Device, private HidListener {
 public:
  // A write may take a millisecond (USB), half of this period; the watchdogs of firmware trip after 5 ms or more (docs/hid.md).
  static constexpr std::int64_t kRepeatNs = 2 * kNanosecondsPerMillisecond;
  // The time within which a device must send its first report after it was opened.
  static constexpr std::int64_t kFirstReportNs = 2 * kNanosecondsPerSecond;
  // The number of rejected reports in succession after which the device is reopened.
  static constexpr int kMaxRejected = 100;

  // Opens the device and waits for its first valid report. Error, one line: it is not there, cannot be driven or sends no such report.
  static Result<std::unique_ptr<HidDevice>> open(std::unique_ptr<HidBackend> backend, HidOpener opener,
                                                 std::optional<RealtimeSettings> realtime = {});
  ~HidDevice() override;

  std::string_view name() const noexcept override { return backend_->name(); }
  const DeviceLimits& limits() const noexcept override { return backend_->limits(); }
  DeviceSample read(std::int64_t now_ns) noexcept override { return exchange_.read(now_ns); }
  void write(const Wrench& wrench, std::int64_t now_ns) noexcept override;
  bool cut() noexcept override {
    exchange_.cut();
    ::sem_post(&commands_);
    return true;
  }
  void restore() noexcept override { exchange_.restore(); }
  void use_heartbeat_page(HeartbeatPage& page) noexcept override;
  DeviceStatus status() const noexcept override { return exchange_.status(); }
  DeviceCondition condition() const noexcept override;
  bool set_hand_target(const std::optional<Vec3>&) noexcept override { return false; }

 private:
  HidDevice(std::unique_ptr<HidBackend> backend, HidOpener opener, std::optional<RealtimeSettings> realtime);

  Result<void> on_opened(HidTransport& transport) override;
  void on_report(std::span<const std::uint8_t> report, std::int64_t now_ns) noexcept override;
  void on_drained(std::int64_t now_ns) noexcept override;
  void on_gone() noexcept override;
  void log_status() noexcept;

  bool await_first_report() noexcept;
  void run_writer() noexcept;
  void await_command() noexcept;
  void write_newest() noexcept;
  bool may_exert(std::int64_t now_ns) noexcept;
  void release_force() noexcept;
  void show_in_heartbeat_page() noexcept;

  std::unique_ptr<HidBackend> backend_;
  std::optional<RealtimeSettings> realtime_;
  SteadyClock clock_;
  DeviceExchange exchange_;
  // Held while a report is decoded or encoded and while a device is set up, never during a read or a write; the servo does not lock it.
  std::mutex driver_mutex_;
  DeviceExchange::Reading reading_;
  bool has_new_state_ = false;
  bool is_first_report_ = true;                       // no report has been written to the device since it was opened
  DeviceStatus logged_status_ = DeviceStatus::ready;  // the last one logged
  HeartbeatPage* heartbeat_page_ = nullptr;
  std::string path_;  // path of the device; empty while it is unplugged
  int rejected_ = 0;  // reports rejected in succession; the writer's
  sem_t commands_;    // posted by the servo: a wrench is there
  std::atomic<bool> has_received_{false};
  std::atomic<bool> ends_{false};
  HidPort port_;
  std::thread writer_;
};

}  // namespace hapton
