#include "hid/hid_port.h"

#include <algorithm>
#include <array>
#include <utility>

#include "runtime/log.h"
#include "runtime/start_thread.h"

namespace hapton {
namespace {

constexpr int kWaitMs = 20;                                              // longest time until the thread notices a request to stop
constexpr std::int64_t kShortSleepNs = 20 * kNanosecondsPerMillisecond;  // the same while it waits for the next search
constexpr int kMaxDrained = 256;  // four full queues: a device that sends faster than it is read must not keep the listener waiting

}  // namespace

HidPort::HidPort(HidOpener opener, HidListener& listener, std::string name, std::optional<RealtimeSettings> realtime)
    : opener_(std::move(opener)), listener_(listener), name_(std::move(name)), realtime_(realtime) {}

HidPort::~HidPort() { close(); }

Result<void> HidPort::open() {
  if (auto found = search(); !found) return found;
  start();
  return {};
}

void HidPort::start() {
  thread_ = start_thread([this] { run(); });
}

void HidPort::close() noexcept {
  ends_.store(true, std::memory_order_release);
  if (thread_.joinable()) thread_.join();
  set_transport(nullptr);
}

std::shared_ptr<HidTransport> HidPort::transport() const noexcept {
  const std::lock_guard lock(mutex_);
  return transport_;
}

void HidPort::set_transport(std::shared_ptr<HidTransport> transport) noexcept {
  // The old transport is closed after the lock is released, since closing may wait for the bus.
  const std::lock_guard lock(mutex_);
  transport_.swap(transport);
}

Result<void> HidPort::search() {
  auto opened = opener_();
  if (!opened) return tl::unexpected(opened.error());
  std::shared_ptr<HidTransport> transport = std::move(*opened);
  has_write_failed_.store(false, std::memory_order_release);
  if (auto usable = listener_.on_opened(*transport); !usable) return usable;
  set_transport(std::move(transport));
  return {};
}

void HidPort::run() noexcept {
  // If the system denies the settings, the servo has already reported it.
  if (realtime_) (void)enter_realtime(*realtime_);
  while (!ends_.load(std::memory_order_acquire)) {
    if (const auto transport = this->transport()) {
      read_until_gone(*transport);
      set_transport(nullptr);
      if (ends_.load(std::memory_order_acquire)) return;
      listener_.on_gone();
      transport->note_gone();
      const bool has_failed = has_write_failed_.load(std::memory_order_acquire);
      log_warning("{}: {}; waiting for it to return", name_, has_failed ? "a write to it failed" : "unplugged");
      logged_failure_.clear();
    }
    await_next_search();
    if (ends_.load(std::memory_order_acquire)) return;
    if (const auto found = search(); !found) {
      report_failure(found.error());
    } else {
      log_info("{}: found at {}", name_, this->transport()->description().path);
    }
  }
}

void HidPort::read_until_gone(HidTransport& transport) noexcept {
  std::array<std::uint8_t, HidTransport::kMaxBytes> report;
  while (!ends_.load(std::memory_order_acquire) && !has_write_failed_.load(std::memory_order_acquire)) {
    HidRead read = transport.read(report, kWaitMs);
    std::int64_t now_ns = clock_.now_ns();
    for (int reports = 1; read.outcome == HidIo::done; ++reports) {
      listener_.on_report(std::span(report).first(std::min(read.size, report.size())), now_ns);
      if (reports == kMaxDrained) break;  // before the next read, whose report would be lost
      read = transport.read(report, 0);
      now_ns = clock_.now_ns();
    }
    listener_.on_drained(now_ns);
    if (read.outcome == HidIo::gone) return;
  }
}

void HidPort::await_next_search() noexcept {
  const std::int64_t until_ns = clock_.now_ns() + kSearchPeriodNs;
  for (std::int64_t now_ns = clock_.now_ns(); now_ns < until_ns && !ends_.load(std::memory_order_acquire); now_ns = clock_.now_ns()) {
    clock_.sleep_until_ns(std::min(now_ns + kShortSleepNs, until_ns));
  }
}

// Logs each reason once, not at each of the four searches a second.
void HidPort::report_failure(const Error& error) {
  if (std::exchange(logged_failure_, error.what) != error.what) log_info("{}: searching: {}", name_, error.what);
}

}  // namespace hapton
