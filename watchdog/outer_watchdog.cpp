#include "watchdog/outer_watchdog.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>

namespace hapton {

OuterWatchdog::Verdict OuterWatchdog::check(const HeartbeatPage& page, bool is_gone, std::int64_t now_ns) noexcept {
  const std::int64_t heartbeat_ns = page.heartbeat_ns.load(std::memory_order_acquire);
  const std::int64_t sample_ns = page.force_sample_ns.load(std::memory_order_acquire);
  silence_ns_ = heartbeat_ns != 0 ? std::max(now_ns - heartbeat_ns, std::int64_t{0}) : 0;
  force_age_ns_ = sample_ns != 0 ? std::max(now_ns - sample_ns, std::int64_t{0}) : 0;
  if (sample_ns != 0 && is_gone) return Verdict::gone;
  const bool is_frozen = silence_ns_ >= kHeartbeatLimitNs;
  const bool is_bad = sample_ns != 0 && (is_frozen || force_age_ns_ >= kForceLimitNs);
  if (!is_bad) {
    bad_since_ns_ = 0;
    return Verdict::fine;
  }
  if (bad_since_ns_ == 0) bad_since_ns_ = now_ns;
  if (now_ns - bad_since_ns_ < kGraceNs) return Verdict::fine;
  return is_frozen ? Verdict::frozen : Verdict::stale;
}

ForceCutter::~ForceCutter() { close_device(); }

void ForceCutter::close_device() noexcept {
  if (device_ >= 0) ::close(device_);
  device_ = -1;
  has_write_failed_ = false;
}

// A device that gets the same /dev node later counts as another device: it is not opened until the page names a device again.
void ForceCutter::close_if_unplugged() noexcept {
  pollfd device = {.fd = device_, .events = 0, .revents = 0};
  if (device_ < 0 || ::poll(&device, 1, 0) != 1 || (device.revents & (POLLERR | POLLHUP)) == 0) return;
  close_device();
  is_unplugged_ = true;
}

bool ForceCutter::kill_process() noexcept {
  pollfd ended = {.fd = process_.file, .events = POLLIN, .revents = 0};
  had_ended_ = process_.file >= 0 && ::poll(&ended, 1, 0) > 0 && (ended.revents & POLLIN) != 0;
  if (had_ended_ || process_.file < 0) return had_ended_;
  // Set before the signal: another thread may notice and report the end of the process at once.
  const bool was_killed = process_.is_killed.exchange(true);
  const bool is_sent = ::syscall(SYS_pidfd_send_signal, process_.file, SIGKILL, nullptr, 0) == 0;
  if (!is_sent) process_.is_killed.store(was_killed);
  return is_sent;
}

bool ForceCutter::write_report() noexcept {
  if (device_ < 0) return false;
  has_write_failed_ = ::write(device_, report_.data(), report_.size()) != static_cast<ssize_t>(report_.size());
  return !has_write_failed_;
}

void ForceCutter::prepare() noexcept {
  const std::uint32_t generation = page_.generation.load(std::memory_order_acquire);
  close_if_unplugged();
  if (generation % 2 != 0 || (generation == generation_ && (device_ >= 0 || is_unplugged_))) return;
  std::array<char, HeartbeatPage::kMaxPath> path = {};
  std::array<std::uint8_t, HeartbeatPage::kMaxReport> report = {};
  std::transform(page_.path.begin(), page_.path.end(), path.begin(), [](const auto& c) { return c.load(std::memory_order_relaxed); });
  std::transform(page_.report.begin(), page_.report.end(), report.begin(), [](const auto& b) { return b.load(std::memory_order_relaxed); });
  const std::size_t size = std::min<std::size_t>(page_.report_size.load(std::memory_order_relaxed), report.size());
  std::atomic_thread_fence(std::memory_order_acquire);
  if (page_.generation.load(std::memory_order_relaxed) != generation) return;
  generation_ = generation;
  path.back() = '\0';
  report_.assign(report.begin(), report.begin() + static_cast<std::ptrdiff_t>(size));
  close_device();
  is_unplugged_ = path[0] == '\0';
  if (!is_unplugged_) device_ = ::open(path.data(), O_WRONLY | O_CLOEXEC | O_NONBLOCK);
}

bool ForceCutter::cut() noexcept {
  prepare();
  switch (page_.means.load(std::memory_order_acquire)) {
    case CutMeans::none:
      return false;
    case CutMeans::hid:
      return write_report();
    case CutMeans::kill:
      return kill_process();
    case CutMeans::simulated:
      return true;  // by HeartbeatPage::is_cut, which the caller sets
    case CutMeans::no_motors:
      return true;
  }
  return false;
}

std::string ForceCutter::describe() const {
  switch (page_.means.load(std::memory_order_acquire)) {
    case CutMeans::none:
      return "it has no means of releasing the force of this device";
    case CutMeans::hid:
      if (is_unplugged_) return "could not turn the device off: it is unplugged";
      if (device_ < 0) return "could not open the device to release the force: give this user access (udev rule)";
      return has_write_failed_ ? "could not turn the device off: it took no report; check whether it is plugged in"
                               : "released the force (device off)";
    case CutMeans::kill:
      if ((had_ended_ || process_.file < 0) && !process_.is_killed.load())
        return "its end closed the vendor's library, so that the driver releases the force";
      return "killed io_node, so that the vendor's driver releases the force";
    case CutMeans::simulated:
      return "released the force of the simulated motors";
    case CutMeans::no_motors:
      return "the device has no motors";
  }
  return {};
}

}  // namespace hapton
