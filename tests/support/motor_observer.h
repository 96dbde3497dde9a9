#pragma once

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "runtime/clock.h"
#include "watchdog/heartbeat_memory.h"

namespace hapton {

// Observes from another process what the simulated motors of a running io_node do: io_node may be stopped or killed meanwhile.
class MotorObserver {
 public:
  struct Release {
    bool was_out = false;          // there was a force on the motors just before the event
    double after_event_ms = -1.0;  // from the event until the motors had no force; below 0: they never had none
    double after_sample_ms = -1.0;
    double blind_ms = 0.0;  // the longest time between two readings of this observer: the true times may be longer by this
  };
  struct Watched {
    double oldest_force_ms = 0.0;  // the largest age of a force on the motors, counted from its sample
    double longest_same_ms = 0.0;  // the longest time for which the force did not change, not even in its last bit
    double strongest_n = 0.0;
    double force_share = 0.0;  // share of this observer's readings with a force on the motors
    double blind_ms = 0.0;     // as in Release
  };

  // False: the process has no heartbeat memory (it has no watchdog, or its device is not simulated).
  bool attach(int process) {
    process_ = process;
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator("/proc/" + std::to_string(process) + "/fd", error)) {
      const auto target = std::filesystem::read_symlink(entry.path(), error);
      if (error || target.string().find("hapton-heartbeat") == std::string::npos) continue;
      const int file = ::open(entry.path().c_str(), O_RDWR | O_CLOEXEC);
      if (file >= 0 && memory_.open(file)) return true;
    }
    return false;
  }

  HeartbeatPage& page() const { return memory_.page(); }
  double force_n() const {
    if (page().is_cut.load() != 0 || page().is_cut_within.load() != 0) return 0.0;
    return std::hypot(page().motors_n[0].load(), page().motors_n[1].load(), page().motors_n[2].load());
  }

  // Waits for a force of at least `at_least_n`, for up to `seconds`. Returns whether it came.
  bool await_force(double at_least_n, double seconds) {
    const std::int64_t end_ns = clock_.now_ns() + static_cast<std::int64_t>(1e9 * seconds);
    while (clock_.now_ns() < end_ns) {
      if (force_n() >= at_least_n) return true;
      clock_.sleep_until_ns(clock_.now_ns() + 200'000);
    }
    return false;
  }

  // Calls `event`, then reads the force until the motors have none, for `at_most_s` at most.
  Release release_after(const std::function<void()>& event, double at_most_s = 0.5) {
    Release release;
    release.was_out = force_n() > 0.0;
    std::int64_t sample_ns = page().force_sample_ns.load();
    event();
    const std::int64_t begin_ns = clock_.now_ns();
    std::int64_t read_ns = begin_ns;
    while (read_ns - begin_ns < static_cast<std::int64_t>(1e9 * at_most_s)) {
      if (const std::int64_t newest_ns = page().force_sample_ns.load(); newest_ns != 0) sample_ns = newest_ns;
      const bool is_off = force_n() == 0.0;
      const std::int64_t now_ns = clock_.now_ns();
      release.blind_ms = std::max(release.blind_ms, 1e-6 * static_cast<double>(now_ns - read_ns));
      if (is_off) {
        // At the previous reading, at read_ns, the force was certainly still on the motors.
        release.after_event_ms = 1e-6 * static_cast<double>(read_ns - begin_ns);
        release.after_sample_ms = 1e-6 * static_cast<double>(read_ns - sample_ns);
        break;
      }
      read_ns = now_ns;
      clock_.sleep_until_ns(now_ns + 100'000);
    }
    return release;
  }

  Watched watch(double seconds) {
    Watched watched;
    const std::int64_t begin_ns = clock_.now_ns();
    const std::int64_t end_ns = begin_ns + static_cast<std::int64_t>(1e9 * seconds);
    std::int64_t read_ns = begin_ns;
    std::int64_t same_since_ns = begin_ns;
    double last_n = 0.0;
    std::uint64_t readings = 0;
    std::uint64_t forces = 0;
    while (read_ns < end_ns) {
      // The time is read first: if this thread is displaced before it reads the rest, a force seems younger than it is, never older.
      const std::int64_t now_ns = clock_.now_ns();
      const std::int64_t sample_ns = page().force_sample_ns.load();
      const double now_n = force_n();
      watched.blind_ms = std::max(watched.blind_ms, 1e-6 * static_cast<double>(now_ns - read_ns));
      read_ns = now_ns;
      ++readings;
      if (now_n != last_n) same_since_ns = now_ns;
      last_n = now_n;
      if (now_n > 0.0 && sample_ns != 0) {
        ++forces;
        watched.oldest_force_ms = std::max(watched.oldest_force_ms, 1e-6 * static_cast<double>(now_ns - sample_ns));
        watched.longest_same_ms = std::max(watched.longest_same_ms, 1e-6 * static_cast<double>(now_ns - same_since_ns));
        watched.strongest_n = std::max(watched.strongest_n, now_n);
      }
      clock_.sleep_until_ns(now_ns + 100'000);
    }
    watched.force_share = readings > 0 ? static_cast<double>(forces) / static_cast<double>(readings) : 0.0;
    return watched;
  }

 private:
  HeartbeatMemory memory_;
  SteadyClock clock_;
  int process_ = 0;
};

}  // namespace hapton
