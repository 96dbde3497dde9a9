// Shows: a device of your own behind the interface that io_node drives, and the governor that stands before its motors.
// Run:   own_device
#include <cmath>
#include <cstdio>

#include "safety/safety_governor.h"

using namespace hapton;

// One axis: 100 g that a hand pushes with 0.5 N. Yours talks to hardware in read() and write().
class PaddleDevice final : public Device {
 public:
  std::string_view name() const noexcept override { return "paddle"; }
  const DeviceLimits& limits() const noexcept override { return limits_; }
  DeviceSample read(std::int64_t now_ns) noexcept override {
    const double dt_s = last_ns_ == 0 ? 0.0 : 1e-9 * static_cast<double>(now_ns - last_ns_);
    last_ns_ = now_ns;
    v_m_per_s_ += dt_s * (kHandN + motor_n_ - 2.0 * v_m_per_s_) / 0.1;
    x_m_ += dt_s * v_m_per_s_;
    return {.time_ns = now_ns, .p_WD = {x_m_, 0.0, 0.0}};
  }
  void write(const Wrench& wrench, std::int64_t) noexcept override { motor_n_ = wrench.force_n.x(); }
  DeviceStatus status() const noexcept override { return DeviceStatus::ready; }
  bool set_hand_target(const std::optional<Vec3>&) noexcept override { return false; }  // a real hand moves it

 private:
  static constexpr double kHandN = 0.5;
  DeviceLimits limits_{.max_force_n = 2.0, .max_slew_n_per_s = 500.0, .max_speed_m_per_s = 2.0};
  double x_m_ = 0.0;
  double v_m_per_s_ = 0.0;
  double motor_n_ = 0.0;
  std::int64_t last_ns_ = 0;
};

int main() {
  PaddleDevice device;
  SafetyGovernor governor(device.limits());
  double max_written_n = 0.0;
  DeviceSample sample;
  for (std::int64_t now_ns = 1'000'000; now_ns < 3'000'000'000; now_ns += 1'000'000) {  // your loop waits for each tick
    sample = device.read(now_ns);
    governor.observe(sample, device.status());
    // A wall at 20 mm, and nonsense from second 2 on: the governor lets neither 500 N nor NaN reach the motor.
    double requested_n = std::min(0.0, -800.0 * (sample.p_WD.x() - 0.02));
    if (now_ns > 2'000'000'000) requested_n = now_ns % 2'000'000 == 0 ? 500.0 : std::nan("");
    device.write(governor.step(WrenchCommand{.wrench = {.force_n = {requested_n, 0.0, 0.0}}, .sample_time_ns = now_ns}, now_ns), now_ns);
    max_written_n = std::max(max_written_n, governor.output().force_n.norm());
  }
  std::printf("at most %.2f N; %llu commands not finite; ends in '%s'\n", max_written_n,
              static_cast<unsigned long long>(governor.counters().not_finite), std::string(to_string(governor.fault())).c_str());
  return max_written_n <= 2.0 && governor.counters().not_finite > 0 ? 0 : 1;
}
