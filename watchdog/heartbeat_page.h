#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace hapton {

// How another process can release the force of a device.
enum class CutMeans : std::uint32_t {
  none,       // no means is known: io_node logs this at its start
  hid,        // the watchdog writes the report that turns the device off, through its own handle of the device
  kill,       // a vendor's library in the process: killing the process closes its handles, and the device or its driver releases the force
  simulated,  // the motors are numbers in this page: setting is_cut suffices
  no_motors,  // there is no force to release (a replay)
};

// The page of memory that io_node's device side and the watchdog process share. Each field has one writer; the other side polls it and
// never waits. Units: ns of CLOCK_MONOTONIC, which is one clock for the whole machine. RT: all yes, wait-free.
struct HeartbeatPage {
  static constexpr std::uint64_t kMagic = 0x32647261'75477048;  // "HpGuard2": identifies the page and its layout
  static constexpr std::size_t kMaxPath = 64;
  static constexpr std::size_t kMaxReport = 128;

  std::atomic<std::uint64_t> magic{kMagic};

  // io_node, device side.
  std::atomic<std::int64_t> heartbeat_ns{0};      // the newest cycle; 0: none yet
  std::atomic<std::int64_t> force_sample_ns{0};   // time of the sample that the force on the motors replies to; 0: no force
  std::array<std::atomic<double>, 3> motors_n{};  // the force last written to simulated motors, N

  std::atomic<std::uint32_t> is_cut_within{0};  // simulated motors: 1 while io_node itself has cut them off

  // io_node, or another process that opens the device. generation is odd while path and report are being written.
  std::atomic<std::uint32_t> generation{0};
  std::atomic<CutMeans> means{CutMeans::none};
  std::array<std::atomic<char>, kMaxPath> path{};              // path of the HID device, ends with 0
  std::array<std::atomic<std::uint8_t>, kMaxReport> report{};  // the report that turns the HID device off
  std::atomic<std::uint32_t> report_size{0};

  // The watchdog. is_cut: it has released the force; the device side clears it once its own force is zero.
  std::atomic<std::uint32_t> is_cut{0};
  std::atomic<std::int64_t> watchdog_beat_ns{0};
  std::atomic<std::uint64_t> cuts{0};
  std::atomic<std::int64_t> longest_force_ns{0};  // largest age of a force when it was cut, counted from its sample

  void set_means(CutMeans wanted) noexcept { means.store(wanted, std::memory_order_release); }

  // If path or report does not fit, means is none: then only io_node and the device itself can release the force.
  void set_hid(std::string_view device_path, std::span<const std::uint8_t> off_report) noexcept {
    generation.fetch_add(1, std::memory_order_acq_rel);
    const bool fits = device_path.size() < kMaxPath && off_report.size() <= kMaxReport;
    for (std::size_t n = 0; fits && n < kMaxPath; ++n)
      path[n].store(n < device_path.size() ? device_path[n] : '\0', std::memory_order_relaxed);
    for (std::size_t n = 0; fits && n < off_report.size(); ++n) report[n].store(off_report[n], std::memory_order_relaxed);
    report_size.store(fits ? static_cast<std::uint32_t>(off_report.size()) : 0, std::memory_order_relaxed);
    means.store(fits ? CutMeans::hid : CutMeans::none, std::memory_order_relaxed);
    generation.fetch_add(1, std::memory_order_acq_rel);
  }
};

static_assert(std::atomic<std::int64_t>::is_always_lock_free && std::atomic<double>::is_always_lock_free);

}  // namespace hapton
