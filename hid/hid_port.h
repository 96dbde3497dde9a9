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

// Who takes what a HidPort brings. All calls come from one thread at a time: the caller's in HidPort::open, then the port's own.
class HidListener {
 public:
  virtual ~HidListener() = default;

  // The device is there, for the first time or again. Error: it is not usable, one line; it is closed and tried again later.
  virtual Result<void> on_opened(HidTransport& transport) = 0;
  // A report, stamped with when it was read. RT: must be.
  virtual void on_report(std::span<const std::uint8_t> report, std::int64_t now_ns) noexcept = 0;
  // No more reports are waiting: the last one received is the newest. RT: must be.
  virtual void on_drained(std::int64_t now_ns) noexcept = 0;
  virtual void on_gone() noexcept = 0;
};

// Keeps one HID device open: a thread of its own reads it, drains its queue to the newest report each time (the kernel's holds 64 and drops
// the new ones when it is full), notices when it is gone, looks for it and opens it again.
// Threads: open, close and the destructor one; transport() and suspect() any.
class HidPort {
 public:
  static constexpr std::int64_t kLookEveryNs = 250 * kNanosecondsPerMillisecond;

  // Pre: the listener outlives the port. name is for the log. priority: SCHED_FIFO of the reading thread; none: an ordinary one.
  HidPort(HidOpener opener, HidListener& listener, std::string name, std::optional<RealtimeSettings> realtime = {});
  ~HidPort();
  HidPort(const HidPort&) = delete;
  HidPort& operator=(const HidPort&) = delete;

  // Opens the device and begins to read. Error: it is not there or not usable, one line.
  Result<void> open();
  // Begins to look for the device, should it not be there yet; the log says when it is.
  void start();
  void close() noexcept;

  // The open device, for writing; null while it is away. It stays valid for who holds it. RT: no lock that is ever held for long.
  std::shared_ptr<HidTransport> transport() const noexcept;

  // A write to it failed: it is closed and opened again.
  void suspect() noexcept { is_suspect_.store(true, std::memory_order_release); }

 private:
  Result<void> look();
  void run() noexcept;
  void read_until_gone(HidTransport& transport) noexcept;
  void await_next_look() noexcept;
  void set_transport(std::shared_ptr<HidTransport> transport) noexcept;
  void report_failure(const Error& error);

  HidOpener opener_;
  HidListener& listener_;
  std::string name_;
  std::optional<RealtimeSettings> realtime_;
  SteadyClock clock_;
  mutable std::mutex mutex_;
  std::shared_ptr<HidTransport> transport_;
  std::string reported_;  // the last failure in the log, not to be repeated
  std::atomic<bool> is_suspect_{false};
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

}  // namespace hapton
