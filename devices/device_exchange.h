#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>

#include "devices/device.h"
#include "runtime/clock.h"
#include "runtime/mailbox.h"

namespace hapton {

// Where the servo and the thread that a vendor's library or service asks for (the driver) meet: the newest sample goes one way, the newest
// wrench the other, and neither ever waits. The driver is told zero while the servo is silent, so that motors do not go on pushing when
// the servo has died; the servo sees a device that was ready as away while the driver is silent.
// Units: ns of CLOCK_MONOTONIC on both sides. RT: all yes, wait-free. Threads: one servo, one driver.
class DeviceExchange {
 public:
  // The servo reads once a cycle, every 4 ms at the slowest; as long as the guard bears silence.
  static constexpr std::int64_t kServoSilenceNs = 20 * kNanosecondsPerMillisecond;
  // Drivers tick a thousand times a second; a hundred missed are more than a busy machine.
  static constexpr std::int64_t kDriverSilenceNs = 100 * kNanosecondsPerMillisecond;
  // A device that has become ready gets its force back over this time.
  static constexpr std::int64_t kRampNs = 200 * kNanosecondsPerMillisecond;

  // What the driver says of the device. The sample's time is the driver's.
  struct Reading {
    DeviceSample sample;
    DeviceStatus status = DeviceStatus::calibrating;
    double motor_temperature = -1.0;
    bool is_calibrated = false;
  };

  // Servo: the newest sample, as of now_ns; the last one again while nothing new is there.
  DeviceSample read(std::int64_t now_ns) noexcept {
    readings_.take();
    now_ns_ = now_ns;
    wish_.time_ns = now_ns;
    wishes_.publish(wish_);
    DeviceSample sample = readings_.value().sample;
    sample.time_ns = now_ns;
    return sample;
  }

  // Servo: what the motors are to do from now on.
  void write(const Wrench& wrench, std::int64_t now_ns) noexcept {
    wish_ = {wrench, now_ns};
    wishes_.publish(wish_);
  }

  // Any thread: the driver is told zero until restore, and then a ramp.
  void cut() noexcept { is_cut_.store(true, std::memory_order_release); }
  void restore() noexcept { is_cut_.store(false, std::memory_order_release); }

  // Servo: as of the last read.
  const Reading& reading() const noexcept { return readings_.value(); }
  DeviceStatus status() const noexcept {
    const Reading& newest = readings_.value();
    const bool is_silent = now_ns_ - newest.sample.time_ns > kDriverSilenceNs;
    return is_silent && newest.status == DeviceStatus::ready ? DeviceStatus::away : newest.status;
  }

  // Driver: what the device says. Its status decides what wrench() gives.
  void publish(const Reading& reading) noexcept {
    const bool is_ready = reading.status == DeviceStatus::ready;
    if (!is_ready) ready_since_ns_ = -1;
    if (is_ready && ready_since_ns_ < 0) ready_since_ns_ = reading.sample.time_ns;
    readings_.publish(reading);
  }

  // Driver: lets the force go, and back in over the ramp, although the device stays ready.
  void restart_ramp(std::int64_t now_ns) noexcept {
    if (ready_since_ns_ >= 0) ready_since_ns_ = now_ns;
  }

  // Driver: what the motors are to do now: the servo's newest wish; zero while the device is not ready or the servo silent.
  Wrench wrench(std::int64_t now_ns) noexcept {
    wishes_.take();
    const Wish& wish = wishes_.value();
    if (ready_since_ns_ < 0) return {};
    if (now_ns - wish.time_ns > kServoSilenceNs || is_cut_.load(std::memory_order_acquire)) {
      ready_since_ns_ = now_ns;
      return {};
    }
    const double share = std::clamp(static_cast<double>(now_ns - ready_since_ns_) / static_cast<double>(kRampNs), 0.0, 1.0);
    return {share * wish.wrench.force_n, share * wish.wrench.torque_nm};
  }

  // Driver: until the first read nobody has asked for anything.
  bool is_servo_there(std::int64_t now_ns) const noexcept { return now_ns - wishes_.value().time_ns <= kServoSilenceNs; }

 private:
  struct Wish {
    Wrench wrench;
    std::int64_t time_ns = -kNanosecondsPerSecond;
  };

  Mailbox<Reading> readings_;
  Mailbox<Wish> wishes_;
  Wish wish_;                         // the servo's
  std::int64_t now_ns_ = 0;           // the servo's
  std::int64_t ready_since_ns_ = -1;  // the driver's
  std::atomic<bool> is_cut_{false};
};

}  // namespace hapton
