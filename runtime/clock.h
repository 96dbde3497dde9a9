#pragma once

#include <atomic>
#include <cstdint>

namespace hapton {

constexpr std::int64_t kNanosecondsPerMillisecond = 1'000'000;
constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;

// Source of time, so that tests can supply their own.
// Units: nanoseconds of CLOCK_MONOTONIC. RT: yes. Threads: any.
class Clock {
 public:
  virtual ~Clock() = default;

  virtual std::int64_t now_ns() const noexcept = 0;

  // Returns at or after the absolute time deadline_ns; at once when this time has passed.
  virtual void sleep_until_ns(std::int64_t deadline_ns) noexcept = 0;
};

// CLOCK_MONOTONIC and clock_nanosleep to absolute times, so that lateness does not accumulate.
class SteadyClock final : public Clock {
 public:
  std::int64_t now_ns() const noexcept override;
  void sleep_until_ns(std::int64_t deadline_ns) noexcept override;
};

// Simulated time: advances only on request, or when a sleep advances it.
class SimulatedClock final : public Clock {
 public:
  explicit SimulatedClock(std::int64_t start_ns = kNanosecondsPerSecond) : now_(start_ns) {}

  std::int64_t now_ns() const noexcept override { return now_.load(std::memory_order_acquire); }

  // Advances time to deadline_ns, never backwards, and returns at once.
  void sleep_until_ns(std::int64_t deadline_ns) noexcept override;

  // Pre: duration_ns >= 0.
  void advance_ns(std::int64_t duration_ns) noexcept { now_.fetch_add(duration_ns, std::memory_order_acq_rel); }

 private:
  std::atomic<std::int64_t> now_;
};

}  // namespace hapton
