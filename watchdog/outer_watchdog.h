#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "watchdog/guard_page.h"

namespace hapton {

// Judges from outside whether a force may stay on the motors: pure, time comes in.
//
//   heartbeat   the device side has not finished a cycle for kHeartbeatLimitNs, and a force is out: frozen, or starved
//   force       a force answers a sample older than kForceLimitNs although the device side is alive: its governor should have taken it away
//   gone        the process has ended with a force out
//
// A machine that stood still as a whole is no fault of io_node: what looks bad is given kGraceNs to go on, from the first look that finds
// it so. However rare the looks are, the second one after that time trips. RT: yes. Threads: one.
class OuterWatchdog {
 public:
  // io_node lets go by itself after 20 ms; this is for when it does not.
  static constexpr std::int64_t kHeartbeatLimitNs = 21'000'000;
  static constexpr std::int64_t kForceLimitNs = 30'000'000;
  static constexpr std::int64_t kLookEveryNs = 2'000'000;
  static constexpr std::int64_t kGraceNs = 4'000'000;

  enum class Verdict : std::uint8_t { fine, frozen, stale, gone };

  // As of now; is_gone: the process has ended.
  Verdict look(const GuardPage& page, bool is_gone, std::int64_t now_ns) noexcept;

  // At the last look.
  std::int64_t force_age_ns() const noexcept { return force_age_ns_; }
  std::int64_t silence_ns() const noexcept { return silence_ns_; }

 private:
  std::int64_t force_age_ns_ = 0;
  std::int64_t silence_ns_ = 0;
  std::int64_t bad_since_ns_ = 0;  // the first of the looks in a row that found it bad; 0: the last did not
};

// Takes the force of one device away, by the means that its page names; again and again, as long as it is asked to.
// RT: a write to the device. Threads: one.
class ForceCutter {
 public:
  // process: whom to kill where there is no other means.
  ForceCutter(GuardPage& page, int process) : page_(page), process_(process) {}
  ~ForceCutter();
  ForceCutter(const ForceCutter&) = delete;
  ForceCutter& operator=(const ForceCutter&) = delete;

  // Opens the device as soon as it is named, so that nothing is left to open when it counts. Call now and then.
  void prepare() noexcept;
  // True: done, as far as this process can tell.
  bool cut() noexcept;
  std::string describe() const;

 private:
  void close_device() noexcept;

  GuardPage& page_;
  int process_;
  std::uint32_t generation_ = 0;
  int device_ = -1;
  std::vector<std::uint8_t> report_;
};

}  // namespace hapton
