#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "closed_loop/axis_motion.h"
#include "closed_loop/force_chain.h"
#include "closed_loop/hand_path.h"

namespace hapton {

// The state of the loop at one sample.
struct LoopRow {
  std::int64_t time_ns = 0;
  Vec3 p_WD = Vec3::Zero();     // position at the motors, before the encoder
  Vec3 force_n = Vec3::Zero();  // force commanded to the motors after this sample
  double motor_j = 0.0;         // work of the motors since the start
  double lost_j = 0.0;          // heat in the device since the start
};

// Hand, device, link and force law in closed loop, in simulated time: the same seed gives the same rows to the last bit. The axes are
// alike and move independently; only the force law couples them. With one axis, y and z stay those of start_m. Units SI, ns;
// frame W. RT: no. Threads: one.
class LoopSimulation {
 public:
  struct Options {
    DeviceModel device;
    HandModel hand;
    int axes = 1;  // 1 or 3
    std::int64_t period_ns = 1'000'000;
    HandPath path = {};
    Vec3 start_m = Vec3::Zero();  // position at which the device rests at time 0
  };

  // Pre: the chain outlives the simulation, and has not been used before.
  LoopSimulation(ForceChain& chain, const Options& options);

  // Simulates until end_ns, and adds one row for each sample; a sample at end_ns is not taken. False: the position at a sample is beyond
  // kOutOfReachM or not finite; the simulation ends there.
  bool run_until(std::int64_t end_ns, std::vector<LoopRow>* rows = nullptr);

  static constexpr double kOutOfReachM = 1e3;  // no device gets there: the loop is unstable

  Vec3 position_m() const noexcept;
  Vec3 velocity_m_per_s() const noexcept;
  double motor_j() const noexcept;
  double lost_j() const noexcept;
  // Kinetic and elastic energy of device and hand.
  double stored_j() const noexcept;
  std::int64_t now_ns() const noexcept { return now_ns_; }

 private:
  void move_until(std::int64_t time_ns) noexcept;
  LoopRow row() const noexcept;

  ForceChain& chain_;
  Options options_;
  AxisMotion motion_;
  std::array<AxisMotion::State, 3> axes_;
  std::int64_t now_ns_ = 0;
  std::int64_t tick_ns_ = 0;  // time of the next sample
};

}  // namespace hapton
