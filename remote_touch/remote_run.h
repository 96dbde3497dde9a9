#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "closed_loop/device_model.h"
#include "closed_loop/hand_model.h"
#include "core/base/result.h"
#include "remote_touch/force_comparison.h"
#include "remote_touch/remote_methods.h"
#include "remote_touch/slide_path.h"

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
  double stall_s = 0.0;  // mean length of the stalls of the device's machine (machine_stalls.h); run_prescribed only
};

// Datagrams, and bytes of IP packets, a second; including the nodes' Hello and Welcome (ten a second each way).
struct RemoteRates {
  double packets_up = 0.0;
  double packets_down = 0.0;
  double bytes_up = 0.0;
  double bytes_down = 0.0;
};

// The hand follows the path, whatever the force.
struct PrescribedTouch {
  ForceComparison force;
  RemoteRates rates;       // while the hand slides and rests
  double scene_kb = 0.0;   // size of all parts of the scene that were sent
  double ready_s = 0.0;    // time until the scene around the hand had arrived
  std::size_t missed = 0;  // periods in which the machine was stalled
  std::vector<ForceRow> rows;
};
// Error: what the method needs around the hand does not come within two minutes.
Result<PrescribedTouch> run_prescribed(const RemoteScene& scene, const SlidePath& path, const RemoteDevice& device,
                                       const RemoteCase& which);

// Hand and device in closed loop, the hand aiming along the path. Measures as in closed_loop/press.h.
struct ClosedLoopTouch {
  bool is_bounded = true;
  double limit_cycle_m = 0.0;  // half of the largest distance between two positions in the second half of the hand's rest
  double generated_j = 0.0;    // the largest net energy that the hand had received at any time, less the heat in the device
  double path_error_m = 0.0;   // RMS distance from where the device is with zero delay, sliding and resting
  double most_force_n = 0.0;
  std::vector<Vec3> p_WD;  // in each period
};

// The largest distance between two of the positions; 0: fewer than two. Time: quadratic. RT: no.
double largest_distance(std::span<const Vec3> positions);

// zero_delay: positions of the same run with method `local`; null: no path error. Error: as run_prescribed, or the hand has no stiffness.
Result<ClosedLoopTouch> run_closed_loop(const RemoteScene& scene, const SlidePath& path, const RemoteDevice& device,
                                        const RemoteCase& which, const std::vector<Vec3>* zero_delay);

// The largest stiffness of a flat wall (a mesh) at which a press of 1 N comes to rest within a second: with a limit cycle of at most two
// encoder steps or 1 % of the depth, and at least 0.5 N held. 0: at no stiffness. Searches upwards to most_n_per_m. Pre: the
// hand has a stiffness above zero. Error: as run_prescribed.
Result<double> find_rest_stiffness_of(const RemoteDevice& device, const RemoteCase& which, double most_n_per_m);

}  // namespace hapton
