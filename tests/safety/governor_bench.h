#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "safety/safety_governor.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/time_units.h"

namespace hapton {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// Round numbers, near those of a PHANToM, so that a reader can compute each limit mentally.
inline DeviceLimits device_limits() {
  return {.max_force_n = 8.0,
          .max_slew_n_per_s = 2000.0,
          .max_stiffness_n_per_m = 1000.0,
          .workspace_min_m = Vec3::Constant(-0.1),
          .workspace_max_m = Vec3::Constant(0.1),
          .max_torque_nm = 0.5,
          .max_torque_slew_nm_per_s = 100.0,
          .max_speed_m_per_s = 2.0};
}

// A governor between a device and a source of forces, in cycles of 1 ms. A test moves the device by writing `sample`, and makes it fail by
// writing `status`. Frame: W.
struct Bench {
  explicit Bench(const DeviceLimits& limits = device_limits()) : governor(limits) {}

  // Runs one cycle in which this force is wanted; none: no command came. Returns what reaches the motors.
  const Wrench& cycle(const std::optional<Wrench>& wanted) {
    now_ns += kMs;
    sample.time_ns = now_ns;
    governor.observe(sample, status);
    if (!wanted) return out = governor.step(std::nullopt, now_ns);
    return out = governor.step(WrenchCommand{*wanted, now_ns - kCommandAgeNs}, now_ns);
  }
  // Runs cycles in which a force along z is wanted; returns the last force at the motors.
  Vec3 press(double z_n, int cycles) {
    for (int n = 0; n < cycles; ++n) cycle(Wrench{Vec3(0, 0, z_n), Vec3::Zero()});
    return out.force_n;
  }
  // Runs cycles without a command; returns the last force at the motors.
  Vec3 wait(int cycles) {
    for (int n = 0; n < cycles; ++n) cycle(std::nullopt);
    return out.force_n;
  }

  static constexpr std::int64_t kCommandAgeNs = 100'000;  // a round trip on a LAN; far from the command timeout

  SafetyGovernor governor;
  DeviceSample sample;
  DeviceStatus status = DeviceStatus::ready;
  std::int64_t now_ns = 0;
  Wrench out;  // what reached the motors in the newest cycle
};

// Moves the device along z at this speed, with a force of 1 N along the motion. Pre: z has room below the workspace's edge at 0.1 m.
inline void move_along_z(Bench& bench, double speed_m_per_s, int cycles) {
  for (int n = 0; n < cycles; ++n) {
    bench.sample.p_WD.z() += 1e-3 * speed_m_per_s;
    bench.press(1.0, 1);
  }
}

}  // namespace hapton
