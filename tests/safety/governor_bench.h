#pragma once

// A governor with a simulated device, and a source of forces.
#include <gtest/gtest.h>
#include <cmath>
#include <limits>
#include "safety/safety_governor.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/time_units.h"

namespace hapton {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

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

// A simulated device and a source of forces: a cycle of 1 ms each.
struct Bench {
  explicit Bench(const DeviceLimits& limits = device_limits()) : governor(limits) {}

  const Wrench& cycle(const std::optional<Wrench>& wanted) {
    now_ns += kMs;
    sample.time_ns = now_ns;
    governor.observe(sample, status);
    if (!wanted) return out = governor.step(std::nullopt, now_ns);
    return out = governor.step(WrenchCommand{*wanted, now_ns - 100'000}, now_ns);
  }
  Vec3 press(double z_n, int cycles) {
    for (int n = 0; n < cycles; ++n) cycle(Wrench{Vec3(0, 0, z_n), Vec3::Zero()});
    return out.force_n;
  }
  Vec3 wait(int cycles) {
    for (int n = 0; n < cycles; ++n) cycle(std::nullopt);
    return out.force_n;
  }

  SafetyGovernor governor;
  DeviceSample sample;
  DeviceStatus status = DeviceStatus::ready;
  std::int64_t now_ns = 0;
  Wrench out;
};

// z from -0.09 on, at this speed, with a force of 1 N along it.
inline void sweep(Bench& bench, double speed_m_per_s, int cycles) {
  for (int n = 0; n < cycles; ++n) {
    bench.sample.p_WD.z() += 1e-3 * speed_m_per_s;
    bench.press(1.0, 1);
  }
}

}  // namespace hapton
