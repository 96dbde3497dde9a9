#include "devices/hid_device.h"

#include <array>
#include <ctime>
#include <utility>

#include "runtime/log.h"
#include "runtime/start_thread.h"

namespace hapton {

Result<std::unique_ptr<HidDevice>> HidDevice::open(std::unique_ptr<HidBackend> backend, HidOpener opener,
                                                   std::optional<RealtimeSettings> realtime) {
  std::unique_ptr<HidDevice> device(new HidDevice(std::move(backend), std::move(opener), realtime));
  if (auto opened = device->port_.open(); !opened) return tl::unexpected(opened.error());
  device->writer_ = start_thread([raw = device.get()] { raw->run_writer(); });
  const auto transport = device->port_.transport();
  const std::string path = transport ? transport->description().path : "gone";
  if (!device->await_first_report()) {
    return fail("{} at {}: its reports are invalid; check that its firmware runs, then plug it in again", device->name(), path);
  }
  const DeviceCondition condition = device->backend_->condition();
  log_info("{}: {} {} at {}", device->name(), condition.model, condition.serial, path);
  return device;
}

HidDevice::HidDevice(std::unique_ptr<HidBackend> backend, HidOpener opener, std::optional<RealtimeSettings> realtime)
    : backend_(std::move(backend)), realtime_(realtime), port_(std::move(opener), *this, std::string(backend_->name()), realtime) {
  ::sem_init(&commands_, 0, 0);
}

HidDevice::~HidDevice() {
  ends_.store(true, std::memory_order_release);
  ::sem_post(&commands_);
  if (writer_.joinable()) writer_.join();
  port_.close();
  ::sem_destroy(&commands_);
}

bool HidDevice::await_first_report() noexcept {
  const std::int64_t until_ns = clock_.now_ns() + kFirstReportNs;
  while (!has_received_.load(std::memory_order_acquire)) {
    if (clock_.now_ns() >= until_ns) return false;
    clock_.sleep_until_ns(clock_.now_ns() + kNanosecondsPerMillisecond);
  }
  return true;
}

void HidDevice::write(const Wrench& wrench, std::int64_t now_ns) noexcept {
  exchange_.write(wrench, now_ns);
  ::sem_post(&commands_);
}

DeviceCondition HidDevice::condition() const noexcept {
  DeviceCondition condition = backend_->condition();
  condition.is_calibrated = exchange_.reading().is_calibrated;
  condition.motor_temperature = exchange_.reading().motor_temperature;
  return condition;
}

Result<void> HidDevice::on_opened(HidTransport& transport) {
  // The writer has no device to write to yet, so it may wait for the lock.
  const std::lock_guard lock(driver_mutex_);
  if (auto begun = backend_->on_open(transport); !begun) return begun;
  reading_.status = DeviceStatus::calibrating;
  reading_.sample.time_ns = clock_.now_ns();
  is_first_report_ = true;
  exchange_.publish(reading_);
  path_ = transport.description().path;
  show_in_heartbeat_page();
  return {};
}

void HidDevice::on_report(std::span<const std::uint8_t> report, std::int64_t now_ns) noexcept {
  const std::lock_guard lock(driver_mutex_);
  if (!backend_->decode(report, now_ns, reading_)) return;
  if (now_ns - reading_.sample.time_ns > DeviceExchange::kDriverTimeoutNs) exchange_.restart_ramp();
  reading_.sample.time_ns = now_ns;
  has_new_state_ = true;
}

void HidDevice::on_drained(std::int64_t) noexcept {
  if (!std::exchange(has_new_state_, false)) return;
  {
    const std::lock_guard lock(driver_mutex_);
    exchange_.publish(reading_);
  }
  has_received_.store(true, std::memory_order_release);
  log_status();
}

void HidDevice::log_status() noexcept {
  const DeviceStatus was = std::exchange(logged_status_, reading_.status);
  if (was == logged_status_) return;
  if (logged_status_ == DeviceStatus::calibrating) log_warning("{}: not calibrated yet: {}", name(), backend_->advice());
  if (logged_status_ == DeviceStatus::ready && was == DeviceStatus::calibrating) log_info("{}: calibrated", name());
  if (logged_status_ == DeviceStatus::fault) log_error("{}: it reports a device fault; switch it off and on", name());
}

void HidDevice::use_heartbeat_page(HeartbeatPage& page) noexcept {
  const std::lock_guard lock(driver_mutex_);
  heartbeat_page_ = &page;
  page.set_means(CutMeans::hid);  // also while the device is unplugged and has no device file
  show_in_heartbeat_page();
}

// Pre: the mutex is held. Stores the report that the watchdog would write: it switches the motors off.
void HidDevice::show_in_heartbeat_page() noexcept {
  if (heartbeat_page_ == nullptr || path_.empty()) return;
  std::array<std::uint8_t, HidTransport::kMaxBytes> report = {};
  const std::size_t size = backend_->encode({}, false, clock_.now_ns(), report);
  heartbeat_page_->set_hid(path_, std::span(report).first(size));
}

void HidDevice::on_gone() noexcept {
  const std::lock_guard lock(driver_mutex_);
  path_.clear();
  reading_.status = DeviceStatus::away;
  reading_.sample.time_ns = clock_.now_ns();
  exchange_.publish(reading_);
}

void HidDevice::run_writer() noexcept {
  if (realtime_) (void)enter_realtime(*realtime_);
  while (!ends_.load(std::memory_order_acquire)) {
    await_command();
    write_newest();
  }
  release_force();
}

// Pre: the mutex is held. The first report after the device was opened has no force: its firmware may need a report without force first.
bool HidDevice::may_exert(std::int64_t now_ns) noexcept {
  const bool is_first = std::exchange(is_first_report_, false);
  const bool is_known = reading_.status == DeviceStatus::ready && now_ns - reading_.sample.time_ns <= DeviceExchange::kDriverTimeoutNs;
  return is_known && !is_first && exchange_.is_servo_alive(now_ns) && !exchange_.is_cut();
}

// Waits for a command, or until the force has to be repeated. Commands that have piled up count as one.
void HidDevice::await_command() noexcept {
  const std::int64_t until_ns = clock_.now_ns() + kRepeatNs;
  const timespec until{until_ns / kNanosecondsPerSecond, until_ns % kNanosecondsPerSecond};
  if (::sem_clockwait(&commands_, CLOCK_MONOTONIC, &until) != 0) return;
  while (::sem_trywait(&commands_) == 0) {
  }
}

void HidDevice::write_newest() noexcept {
  std::array<std::uint8_t, HidTransport::kMaxBytes> report = {};
  // Takes the transport while locked: a report encoded for a newly opened device must not go to the device before it.
  std::unique_lock lock(driver_mutex_);
  const auto transport = port_.transport();
  if (!transport) {
    rejected_ = 0;
    return;
  }
  // A write may have hung while the device was opened again: rejected_ then counts rejections by the device before.
  if (is_first_report_) rejected_ = 0;
  const std::int64_t now_ns = clock_.now_ns();
  const Wrench wrench = exchange_.wrench(now_ns);
  const std::size_t size = backend_->encode(wrench, may_exert(now_ns), now_ns, report);
  lock.unlock();
  if (size == 0) return;
  rejected_ = transport->write(std::span(report).first(size)) ? 0 : rejected_ + 1;
  if (rejected_ < kMaxRejected) return;
  rejected_ = 0;
  if (transport == port_.transport()) port_.report_write_failure();
}

void HidDevice::release_force() noexcept {
  const auto transport = port_.transport();
  if (!transport) return;
  std::array<std::uint8_t, HidTransport::kMaxBytes> report = {};
  std::unique_lock lock(driver_mutex_);
  const std::size_t size = backend_->encode({}, false, clock_.now_ns(), report);
  lock.unlock();
  if (size > 0) (void)transport->write(std::span(report).first(size));
}

}  // namespace hapton
