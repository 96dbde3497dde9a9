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

// The largest stiffness and damping that a loop of hand, device and delay renders stably: the smallest values of recommend_stiffness over
// all hands and all device models with this name.
struct StiffnessAdvice {
  // A device and a hand for which a value is smallest.
  struct Loop {
    std::string device;  // its title
    std::string hand;    // its name
  };

  double safe_n_per_m = 0.0;
  Loop by_stiffness;
  double loop_n_per_m = 0.0;  // without the devices' own stiffness limits: for stiffness that changes from place to place
  Loop by_loop;
  double pressed_n = kMaxPressedN;    // how hard surfaces are pressed: the largest force of the strongest of these devices
  bool is_limited_by_device = false;  // safe_n_per_m is the device's own stiffness limit, whatever hand and delay
  double damping_ns_per_m = 0.0;      // largest damping of materials
  Loop by_damping;
  double viscosity_ns_per_m = 0.0;  // largest viscosity of effects
  Loop by_viscosity;
  double rotational_nm_per_rad = 0.0;  // largest of a rigid tool's coupling (turning_axis.h); 0: no motor turns the stylus
  std::string by_turning;              // name of the hand for which it is smallest
};
// Computes the advice for a loop. None: no model of the device is known, or the facts are empty. RT: no; takes about 0.1 s.
std::optional<StiffnessAdvice> advise_stiffness(const LoopFacts& facts);

// Logs a warning if a scene, or a rigid tool, has a larger stiffness or damping than the measured loop renders stably: once, and again for
// another loop, a stiffer or more damped scene, a tool with a larger rotational stiffness, or a round trip kMuchSlower times as long. RT:
// note, set_gains, note_tool and checks yes; construction and destruction set-up only.
// Threads: one calls note, any the other three; the advice is computed in a thread of its own.
class StiffnessAdviser {
 public:
  static constexpr double kMuchSlower = 1.25;  // ratio to the round trip checked last; less would repeat it for each fluctuation

  explicit StiffnessAdviser(const LargestGains& gains);
  ~StiffnessAdviser();
  StiffnessAdviser(const StiffnessAdviser&) = delete;
  StiffnessAdviser& operator=(const StiffnessAdviser&) = delete;

  void note(const LoopFacts& facts) noexcept { facts_.publish(facts); }
  // To be called when the scene or its materials have changed. Threads: any.
  void set_gains(const LargestGains& gains) noexcept;
  // To be called when the stylus holds a rigid tool. The largest stiffness of all calls of this and of set_gains counts. Threads: any.
  void note_tool(double nm_per_rad) noexcept;
  // How often its thread has checked the facts and gains and logged its advice. Threads: any.
  std::uint64_t checks() const noexcept { return checks_.load(std::memory_order_acquire); }

 private:
  void run();
  LargestGains read_gains() const noexcept;
  void consider(const LoopFacts& facts);
  // Warns of each of these gains that is too large; 0: not checked.
  void advise(const LoopFacts& facts, const LargestGains& gains);

  // The gains, each stored by itself, and each cause before its stiffness.
  std::atomic<double> stiffness_n_per_m_;
  std::atomic<StiffCause> cause_;
  std::atomic<double> by_place_n_per_m_;
  std::atomic<double> of_pressing_n_per_m_;
  std::atomic<StiffCause> place_cause_;
  std::atomic<double> damping_ns_per_m_;
  std::atomic<double> viscosity_ns_per_m_;
  std::atomic<double> rotational_nm_per_rad_;
  Mailbox<LoopFacts> facts_;
  LoopFacts checked_facts_;     // the facts checked last; used by the object's own thread only
  LargestGains checked_gains_;  // the gains checked last; likewise
  std::atomic<std::uint64_t> checks_ = 0;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

}  // namespace hapton
