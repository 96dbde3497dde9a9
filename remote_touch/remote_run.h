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

// Servo period of all runs, s.
constexpr double kRemotePeriodS = 1e-3;

// The device and the hand that holds it, as in closed_loop/.
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

// Datagrams, and bytes of their IP packets, per second. They include the nodes' Hello and Welcome: ten per second each way.
struct RemoteRates {
  double packets_up = 0.0;
  double packets_down = 0.0;
  double bytes_up = 0.0;
  double bytes_down = 0.0;
};

// The hand follows the path, whatever the force.
struct PrescribedTouch {
  ForceComparison force;
  RemoteRates rates;      // while the hand slides and rests
  double scene_kb = 0.0;  // size of all parts of the scene that were sent
  // Time until the scene around the hand had arrived; at least the half second and the two round trips for which the hand waits.
  double ready_s = 0.0;
  std::size_t missed_periods = 0;  // periods in which the machine was stalled; they have no row
  std::vector<ForceRow> rows;
};
// Error: what the method needs around the hand has not arrived after two minutes.
Result<PrescribedTouch> run_prescribed(const RemoteScene& scene, const SlidePath& path, const RemoteDevice& device,
                                       const RemoteCase& remote_case);

// Hand and device in closed loop: the hand aims along the path. Measures as in closed_loop/press.h.
struct ClosedLoopTouch {
  bool is_bounded = true;
  double limit_cycle_m = 0.0;  // half of the largest distance between two positions, while the hand rests, in the second half of that time
  double generated_j = 0.0;    // the largest net energy that the hand had received at any time, less the heat in the device
  double path_error_m = 0.0;   // RMS distance from where the device is with zero delay, sliding and resting
  double most_force_n = 0.0;
  std::vector<Vec3> p_WD;  // in each period
};

// The largest distance between two of the positions; 0: fewer than two. Time: quadratic. RT: no.
double largest_distance(std::span<const Vec3> positions);

// zero_delay: positions of the same run with method `local`; null: no path error. Error: as run_prescribed, or the hand has no stiffness.
Result<ClosedLoopTouch> run_closed_loop(const RemoteScene& scene, const SlidePath& path, const RemoteDevice& device,
                                        const RemoteCase& remote_case, const std::vector<Vec3>* zero_delay);

// The largest delay of a force that a comparison searches (ForceComparison::time_offset_s) on a network with this round trip.
double searched_delay_s(double round_trip_s) noexcept;

// The largest stiffness of a flat wall (a mesh) at which a press of 1 N comes to rest within a second: it is still
// (PressMeasures::is_still), and the wall holds at least 0.5 N. 0: it does not even rest at the lowest stiffness tried, 10 N/m. Searched
// upwards in equal ratios up to most_n_per_m, then by bisection to 2 %. Pre: the hand has a stiffness above zero. Error: as run_prescribed.
Result<double> find_rest_stiffness_of(const RemoteDevice& device, const RemoteCase& remote_case, double most_n_per_m);

}  // namespace hapton
