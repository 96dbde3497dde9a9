#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <thread>

#include "core/base/mailbox.h"
#include "core/force/stiffest.h"
#include "link/messages.h"

namespace hapton {

// The largest stiffness and damping that a loop of hand, device and delay renders stably: recommend_stiffness, the least over all hands and
// all devices with this name.
struct StiffnessAdvice {
  // A device and a hand with the least.
  struct Loop {
    std::string device;  // its title
    std::string hand;    // its name
  };

  double safe_n_per_m = 0.0;
  Loop by_stiffness;
  double loop_n_per_m = 0.0;  // without the stiffness limits of the devices: where the stiffness changes from place to place
  Loop by_loop;
  double pressed_n = kMaxPressedN;    // how hard surfaces are pressed: the largest force of the strongest of these devices
  bool is_limited_by_device = false;  // the device's own stiffness limit is the least, whatever hand and delay
  double damping_ns_per_m = 0.0;      // of materials
  Loop by_damping;
  double viscosity_ns_per_m = 0.0;  // of effects
  Loop by_viscosity;
  double rotational_nm_per_rad = 0.0;  // of a rigid tool's coupling (turning_axis.h); 0: no motor turns the stylus
  std::string by_turning;              // name of the hand with the least
};
// None: no model of the device is known, or the facts are empty. RT: no; takes about 0.1 s.
std::optional<StiffnessAdvice> advise_stiffness(const LoopFacts& facts);

// Logs a warning if a scene, or a rigid tool, has a larger stiffness or damping than the measured loop renders stably: once, and again for
// another loop, a stiffer or more damped scene, a tool that turns more stiffly, or a round trip that has become longer by kMuchSlower. RT:
// note and the setters yes; construction and destruction set-up only.
// Threads: one calls note; a thread of its own computes.
class StiffnessAdviser {
 public:
  static constexpr double kMuchSlower = 1.25;  // round trip over that of the last warning; less would repeat it for every fluctuation

  explicit StiffnessAdviser(const LargestGains& gains);
  ~StiffnessAdviser();
  StiffnessAdviser(const StiffnessAdviser&) = delete;
  StiffnessAdviser& operator=(const StiffnessAdviser&) = delete;

  void note(const LoopFacts& facts) noexcept { facts_.publish(facts); }
  // The materials of the scene have changed. Threads: any.
  void set_gains(const LargestGains& gains) noexcept;
  // The stylus holds a rigid tool with this rotational stiffness. Of several, and those of set_gains, the largest counts. Threads: any.
  void note_tool(double nm_per_rad) noexcept;
  // How often its thread has checked the facts and gains and logged its advice. Threads: any.
  std::uint64_t checks() const noexcept { return checks_.load(std::memory_order_acquire); }

 private:
  void run();
  LargestGains read_gains() const noexcept;
  void consider(const LoopFacts& facts);
  // Of those gains that are above 0.
  void advise(const LoopFacts& facts, const LargestGains& gains);

  // Each stands for itself.
  std::atomic<double> stiffness_n_per_m_;
  std::atomic<StiffCause> cause_;
  std::atomic<double> by_place_n_per_m_;
  std::atomic<double> of_pressing_n_per_m_;
  std::atomic<StiffCause> place_cause_;
  std::atomic<double> damping_ns_per_m_;
  std::atomic<double> viscosity_ns_per_m_;
  std::atomic<double> rotational_nm_per_rad_;
  Mailbox<LoopFacts> facts_;
  LoopFacts considered_;           // of the last advice; used by its own thread alone
  LargestGains considered_gains_;  // then; the same
  std::atomic<std::uint64_t> checks_ = 0;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

}  // namespace hapton
