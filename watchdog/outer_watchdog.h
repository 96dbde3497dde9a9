#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "watchdog/heartbeat_page.h"

namespace hapton {

// Decides, in another process than io_node, whether a force may stay on the motors. Without a clock: time is a parameter.
//
//   frozen   the device side has not finished a cycle for kHeartbeatLimitNs, and there is a force
//   stale    the force replies to a sample older than kForceLimitNs although the device side is alive: its governor should have released it
//   gone     the process has ended with a force on the motors
//
// A stall of the whole machine is not io_node's fault: frozen and stale count only when a check at least kGraceNs after the first one that
// found them still finds them, and none between found the state good. RT: yes. Threads: one.
class OuterWatchdog {
 public:
  // io_node releases the force itself after 20 ms; this is for when it does not.
  // With kCheckPeriodNs and kGraceNs the force is off 27 ms after io_node was frozen, of the 50 ms that docs/safety-case.md promises.
  static constexpr std::int64_t kHeartbeatLimitNs = 21'000'000;
  // Later than the stale-force watchdog (20.5 ms), which goes first while io_node lives.
  static constexpr std::int64_t kForceLimitNs = 30'000'000;
  static constexpr std::int64_t kCheckPeriodNs = 2'000'000;
  static constexpr std::int64_t kGraceNs = 4'000'000;  // two checks

  enum class Verdict : std::uint8_t { fine, frozen, stale, gone };

  // The verdict at now_ns. is_gone: the process has ended.
  Verdict check(const HeartbeatPage& page, bool is_gone, std::int64_t now_ns) noexcept;

  // At the last check: the age of the force, counted from its sample, and the time since the newest heartbeat.
  std::int64_t force_age_ns() const noexcept { return force_age_ns_; }
  std::int64_t silence_ns() const noexcept { return silence_ns_; }

 private:
  std::int64_t force_age_ns_ = 0;
  std::int64_t silence_ns_ = 0;
  std::int64_t bad_since_ns_ = 0;  // first of the consecutive checks that found a bad state; 0: the last one found none
};

// The process that the watchdog watches: one for all of its threads.
struct WatchedProcess {
  int file = -1;                       // a pidfd, since a process id may be reused after the process's end; below 0: none. Not owned
  std::atomic<bool> is_killed{false};  // a ForceCutter has killed it
};

// Releases the force of one device, by the means that its page names, each time it is called.
// RT: a write to the device. Threads: one.
class ForceCutter {
 public:
  // process: is killed if the page names CutMeans::kill. Pre: both outlive this.
  ForceCutter(HeartbeatPage& page, WatchedProcess& process) : page_(page), process_(process) {}
  ~ForceCutter();
  ForceCutter(const ForceCutter&) = delete;
  ForceCutter& operator=(const ForceCutter&) = delete;

  // Opens the device as soon as the page names it, so that nothing needs opening in an emergency. Closes a device that was unplugged: it
  // would not get the same /dev node again while that is open. Call it periodically.
  void prepare() noexcept;
  // True: the report was written, the kill was sent or the process has ended, or motors are simulated (set is_cut as well) or absent.
  bool cut() noexcept;
  // What the last cut() did, or before one what it would do, by the means that the page names at present.
  std::string describe() const;

 private:
  void close_device() noexcept;
  void close_if_unplugged() noexcept;
  bool kill_process() noexcept;
  bool write_report() noexcept;

  HeartbeatPage& page_;
  WatchedProcess& process_;
  std::uint32_t generation_ = 0;
  int device_ = -1;
  bool is_unplugged_ = true;       // the device that the page names is unplugged, or it names none
  bool has_write_failed_ = false;  // the last write to this device failed
  bool had_ended_ = false;         // the process had ended when it was to be killed
  std::vector<std::uint8_t> report_;
};

}  // namespace hapton
