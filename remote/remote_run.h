#pragma once

#include <cstdint>
#include <vector>

#include "core/base/result.h"
#include "loop/device_model.h"
#include "loop/hand_model.h"
#include "remote/force_comparison.h"
#include "remote/remote_methods.h"
#include "remote/slide_path.h"

namespace hapton {

// The hand's device, as in the laboratory.
struct RemoteDevice {
  DeviceModel model;
  DeviceLimits limits;
  HandModel hand;
};

// One method across one network.
struct RemoteCase {
  const RemoteMethod* method = nullptr;
  RemoteNetwork network;
  double round_trip_s = 0.0;
  RemoteSettings settings;
  double stall_s = 0.0;  // the device's machine stands still for so long on average (machine_stalls.h); given path only
};

// Datagrams and bytes of IP packets a second; greetings of the nodes (ten a second each way) among them.
struct RemoteRates {
  double packets_up = 0.0;
  double packets_down = 0.0;
  double bytes_up = 0.0;
  double bytes_down = 0.0;
};

// The hand goes along the path whatever the force.
struct PrescribedTouch {
  ForceComparison force;
  RemoteRates rates;       // while it slides and rests
  double scene_kb = 0.0;   // parts of the scene, in all
  double ready_s = 0.0;    // until all around the hand was there
  std::size_t missed = 0;  // periods that the machine stood still for
  std::vector<ForceRow> rows;
};
// Error: what the method needs around the hand does not come within two minutes.
Result<PrescribedTouch> run_prescribed(const RemoteScene& scene, const SlidePath& path, const RemoteDevice& device,
                                       const RemoteCase& which);

// Hand and device in closed loop, the hand aiming along the path. Measures as in loop/press.h.
struct ClosedLoopTouch {
  bool is_bounded = true;
  double limit_cycle_m = 0.0;  // while the hand rests: half of the largest distance between two places in the last half of it
  double generated_j = 0.0;    // the most energy that the hand had got in all, so far, at any time, less what the device had turned to heat
  double path_error_m = 0.0;   // RMS distance from where the device is with zero delay, sliding and resting
  double most_force_n = 0.0;
  std::vector<Vec3> p_WD;  // each period
};
// zero_delay: positions of the same run with method `local`; none: no path error.
Result<ClosedLoopTouch> run_closed_loop(const RemoteScene& scene, const SlidePath& path, const RemoteDevice& device,
                                        const RemoteCase& which, const std::vector<Vec3>* zero_delay);

// The largest stiffness of a flat wall, a mesh, at which a press of 1 N comes to rest within a second: a limit cycle of two encoder steps,
// or 1 % of the depth, at most, and half of the newton at least. 0: at none. Searched upwards to most_n_per_m. The hand has a spring.
Result<double> find_rest_stiffness_of(const RemoteDevice& device, const RemoteCase& which, double most_n_per_m);

}  // namespace hapton
