#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>

#include "core/base/result.h"
#include "hid/hid_transport.h"
#include "runtime/clock.h"
#include "runtime/realtime.h"

namespace hapton {

// Receives the events of a HidPort. Threads: one at a time calls it: that of the caller in HidPort::open, then the port's own.
class HidListener {
 public:
  virtual ~HidListener() = default;

  // The device was opened, for the first time or again. Error, one line: it is not usable; the port closes it and searches again later.
  virtual Result<void> on_opened(HidTransport& transport) = 0;
  // A report was received. now_ns: CLOCK_MONOTONIC when it was read. RT: required.
  virtual void on_report(std::span<const std::uint8_t> report, std::int64_t now_ns) noexcept = 0;
  // The queue is empty (or 256 reports were read from it without a pause): the last report is the newest. RT: required.
  virtual void on_drained(std::int64_t now_ns) noexcept = 0;
  virtual void on_gone() noexcept = 0;  // the device was unplugged, or a write to it failed
};

// Keeps one HID device open. A thread of its own reads each report, up to the newest one (the kernel's queue holds 64 and drops new ones
// when it is full), notices when the device is unplugged, searches for it and opens it again. RT: report_write_failure; the thread while it
// reads, if `realtime` is given. Threads: one for open, start, close and the destructor; any for transport and report_write_failure.
class HidPort {
 public:
  // Time between two searches: a person who plugs in a device does not notice this delay.
  static constexpr std::int64_t kSearchPeriodNs = 250 * kNanosecondsPerMillisecond;

  // Pre: the listener outlives the port. name: for the log. realtime: settings of the reading thread; none: an ordinary thread.
  HidPort(HidOpener opener, HidListener& listener, std::string name, std::optional<RealtimeSettings> realtime = {});
  ~HidPort();
  HidPort(const HidPort&) = delete;
  HidPort& operator=(const HidPort&) = delete;

  // Opens the device and begins to read. Error, one line: it is not plugged in, or not usable.
  Result<void> open();
  // In place of open(): begins to search for a device that need not be plugged in yet; the log says when it was found.
  void start();
  void close() noexcept;

  // The open device, for writing; null while it is unplugged. The pointer keeps it alive. RT: a mutex is held while a pointer is copied.
  std::shared_ptr<HidTransport> transport() const noexcept;

  // To be called when a write failed: the device is closed and opened again.
  void report_write_failure() noexcept { has_write_failed_.store(true, std::memory_order_release); }

 private:
  Result<void> search();
  void run() noexcept;
  void read_until_gone(HidTransport& transport) noexcept;
  void await_next_search() noexcept;
  void set_transport(std::shared_ptr<HidTransport> transport) noexcept;
  void report_failure(const Error& error);

  HidOpener opener_;
  HidListener& listener_;
  std::string name_;
  std::optional<RealtimeSettings> realtime_;
  SteadyClock clock_;
  mutable std::mutex mutex_;
  std::shared_ptr<HidTransport> transport_;
  std::string logged_failure_;  // the last failure in the log, which is not logged again
  std::atomic<bool> has_write_failed_{false};
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

}  // namespace hapton
