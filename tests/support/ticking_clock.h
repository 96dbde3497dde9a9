#pragma once

#include "runtime/clock.h"

namespace hapton {

// Simulated time that advances by 50 ns with every reading, so that loops that spin end.
class TickingClock final : public Clock {
 public:
  // Pre: clock outlives this.
  explicit TickingClock(SimulatedClock& clock) : clock_(clock) {}
  std::int64_t now_ns() const noexcept override {
    clock_.advance_ns(50);
    return clock_.now_ns();
  }
  void sleep_until_ns(std::int64_t deadline_ns) noexcept override { clock_.sleep_until_ns(deadline_ns); }

 private:
  SimulatedClock& clock_;
};

}  // namespace hapton
