#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <utility>

#include "core/base/mailbox.h"
#include "devices/device.h"
#include "runtime/clock.h"

namespace hapton {

// Exchange between the servo and the thread that a vendor's library or service requires (the driver): the newest sample in one direction,
// the newest wrench in the other, and neither side ever waits. When the servo times out the driver gets zero, so that the motors stop; when
// the driver times out the servo sees a ready device as away. Units: ns of CLOCK_MONOTONIC on both sides. RT: all yes, wait-free. Threads:
// one servo, one driver.
class DeviceExchange {
 public:
  // The servo reads once a cycle, every 4 ms at the slowest; this time equals the command timeout.
  static constexpr std::int64_t kServoTimeoutNs = 20 * kNanosecondsPerMillisecond;
  // Drivers tick a thousand times a second; a hundred missed ticks are more than load explains.
  static constexpr std::int64_t kDriverTimeoutNs = 100 * kNanosecondsPerMillisecond;
  // Duration of the ramp up for a device that has become ready. The ramp begins with the first wrench that the driver takes, so that a
  // driver that is late after its first sample does not begin in the middle of it.
  static constexpr std::int64_t kDriverRampNs = 200 * kNanosecondsPerMillisecond;

  // What the driver reports about the device. The sample's time is that at which the driver read it.
  struct Reading {
    DeviceSample sample;
    DeviceStatus status = DeviceStatus::calibrating;
    double motor_temperature = -1.0;
    bool is_calibrated = false;
  };

  // Servo: the newest sample, with the time now_ns; the last one again if there is no newer one. Also prolongs the last wrench written.
  DeviceSample read(std::int64_t now_ns) noexcept {
    readings_.take();
    now_ns_ = now_ns;
    command_.time_ns = now_ns;
    commands_.publish(command_);
    DeviceSample sample = readings_.value().sample;
    sample.time_ns = now_ns;
    return sample;
  }

  // Servo: the wrench from now_ns on.
  void write(const Wrench& wrench, std::int64_t now_ns) noexcept {
    command_ = {wrench, now_ns};
    commands_.publish(command_);
  }

  // Any thread: the driver gets zero until restore, then a ramp.
  void cut() noexcept { is_cut_.store(true, std::memory_order_release); }
  void restore() noexcept { is_cut_.store(false, std::memory_order_release); }
  bool is_cut() const noexcept { return is_cut_.load(std::memory_order_acquire); }

  // Servo: the reading that the last read() took, and the status according to it.
  const Reading& reading() const noexcept { return readings_.value(); }
  DeviceStatus status() const noexcept {
    const Reading& newest = readings_.value();
    const bool has_timed_out = now_ns_ - newest.sample.time_ns > kDriverTimeoutNs;
    return has_timed_out && newest.status == DeviceStatus::ready ? DeviceStatus::away : newest.status;
  }

  // Driver: passes the newest reading to the servo. wrench() returns zero unless the status of this reading is ready.
  void publish(const Reading& reading) noexcept {
    const bool was_ready = std::exchange(is_ready_, reading.status == DeviceStatus::ready);
    if (!was_ready) restart_ramp();
    readings_.publish(reading);
  }

  // Driver: releases the force and ramps it up again, although the device stays ready.
  void restart_ramp() noexcept { ramp_begin_ns_ = kNotBegun; }

  // Driver: the wrench to apply now: the servo's newest, times the ramp; zero while the device is cut or not ready or the servo timed out.
  Wrench wrench(std::int64_t now_ns) noexcept {
    commands_.take();
    const Command& command = commands_.value();
    if (!is_ready_) return {};
    if (now_ns - command.time_ns > kServoTimeoutNs || is_cut()) {
      restart_ramp();
      return {};
    }
    if (ramp_begin_ns_ == kNotBegun) ramp_begin_ns_ = now_ns;
    const double share = std::clamp(static_cast<double>(now_ns - ramp_begin_ns_) / static_cast<double>(kDriverRampNs), 0.0, 1.0);
    return {share * command.wrench.force_n, share * command.wrench.torque_nm};
  }

  // Driver: whether the servo had read or written in the kServoTimeoutNs before now_ns, as far as the last call of wrench() found out.
  bool is_servo_alive(std::int64_t now_ns) const noexcept { return now_ns - commands_.value().time_ns <= kServoTimeoutNs; }

 private:
  struct Command {
    Wrench wrench;
    std::int64_t time_ns = -kNanosecondsPerSecond;
  };

  static constexpr std::int64_t kNotBegun = -1;

  Mailbox<Reading> readings_;
  Mailbox<Command> commands_;
  Command command_;                         // the servo's
  std::int64_t now_ns_ = 0;                 // the servo's
  bool is_ready_ = false;                   // the driver's
  std::int64_t ramp_begin_ns_ = kNotBegun;  // the driver's
  std::atomic<bool> is_cut_{false};
};

}  // namespace hapton
