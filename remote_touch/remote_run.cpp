#include "remote_touch/remote_run.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <utility>

#include "closed_loop/largest_value.h"
#include "closed_loop/loop_simulation.h"
#include "closed_loop/passivity_stage.h"
#include "closed_loop/press.h"
#include "closed_loop/touch_wall.h"
#include "remote_touch/machine_stalls.h"
#include "remote_touch/remote_law.h"
#include "remote_touch/whole_scene.h"
#include "safety/vector_limit.h"

namespace hapton {
namespace {

constexpr auto kPeriodNs = static_cast<std::int64_t>(1e9 * kRemotePeriodS);
constexpr double kMinWaitS = 0.5;            // the hand waits this long and two round trips before it begins, also if nothing is to be sent
constexpr double kMaxWaitS = 120.0;          // about ten times what the parts of a scene take at 1 Mbit/s (docs/remote.md)
constexpr double kHelloHz = 10.0;            // HubClient::kHelloPeriodNs
constexpr double kHelloBytes = 110.0;        // about the size of the IP packet of a Hello or a Welcome
constexpr double kSearchedTrips = 1.5;       // round trips: a force is late by one of them, and with jitter by more
constexpr double kMinSearchedDelayS = 0.03;  // above the 20 ms for which io_node uses a force

// A method as a force law, in the chain from position to motors. A passive method without a governor gets the passivity controller here.
class MethodChain {
 public:
  enum class Encoder : std::uint8_t { exact, rounding };  // whether positions are rounded to the steps of the device's encoder

  MethodChain(const RemoteScene& scene, const RemoteDevice& device, const RemoteCase& remote_case, Encoder encoder)
      : law_(*remote_case.method, make_remote_touch(*remote_case.method, scene, remote_case.network, remote_case.settings),
             {.limits = device.limits, .mechanics = mechanics_of(device.model)}, kPeriodNs),
        stage_({.device = mechanics_of(device.model),
                .most_damping_ns_per_m = PassivityStage::renderable_damping_ns_per_m(device.model.mass_kg, 1.0 / kRemotePeriodS),
                .max_force_n = device.model.max_force_n}),
        chain_(law_, {.encoder_step_m = encoder == Encoder::exact ? 0.0 : device.model.encoder_step_m,
                      .max_force_n = device.model.max_force_n,
                      .stage = remote_case.method->is_passive && !remote_case.method->has_governor ? &stage_ : nullptr}) {}

  RemoteLaw& law() { return law_; }
  ForceChain& chain() { return chain_; }

 private:
  static PassivityController::Mechanics mechanics_of(const DeviceModel& model) {
    return {.mass_kg = model.mass_kg, .position_step_m = model.encoder_step_m};
  }

  RemoteLaw law_;
  PassivityStage stage_;
  ForceChain chain_;
};

RemoteRates rates_of(const RemoteTraffic& traffic, double seconds) {
  const auto per_s = [&](std::uint64_t count) { return static_cast<double>(count) / seconds; };
  return {.packets_up = per_s(traffic.up.packets) + kHelloHz,
          .packets_down = per_s(traffic.down.packets) + kHelloHz,
          .bytes_up = per_s(traffic.up.bytes) + kHelloHz * kHelloBytes,
          .bytes_down = per_s(traffic.down.bytes) + kHelloHz * kHelloBytes};
}

Result<double> wait_for_scene(RemoteLaw& law, const RemoteMethod& method, const Vec3& p_WD, double round_trip_s) {
  const auto ready_s = law.wait(p_WD, kMinWaitS + 2.0 * round_trip_s, kMaxWaitS);
  if (!ready_s) return fail("{}: the scene around the hand had not arrived after {:g} s", method.name, kMaxWaitS);
  return *ready_s;
}

// RMS distance while the hand slides and rests, as far as both have positions.
double path_error_of(const std::vector<Vec3>& p_WD, const std::vector<Vec3>& zero_delay, const SlidePath& path) {
  double sum = 0.0;
  const std::size_t end = std::min({p_WD.size(), zero_delay.size(), path.first_leaving_row});
  if (end <= path.first_sliding_row) return 0.0;
  for (std::size_t i = path.first_sliding_row; i < end; ++i) sum += (p_WD[i] - zero_delay[i]).squaredNorm();
  return std::sqrt(sum / static_cast<double>(end - path.first_sliding_row));
}

}  // namespace

double searched_delay_s(double round_trip_s) noexcept { return std::max(kSearchedTrips * round_trip_s, kMinSearchedDelayS); }

double largest_distance(std::span<const Vec3> positions) {
  double most_squared = 0.0;
  // All pairs: the farthest two need not include the one that is farthest from the first.
  for (std::size_t i = 0; i < positions.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) most_squared = std::max(most_squared, (positions[i] - positions[j]).squaredNorm());
  }
  return std::sqrt(most_squared);
}

Result<PrescribedTouch> run_prescribed(const RemoteScene& scene, const SlidePath& path, const RemoteDevice& device,
                                       const RemoteCase& remote_case) {
  MethodChain method(scene, device, remote_case, MethodChain::Encoder::exact);
  const Vec3 start = path.rows.front().device_m();
  const auto ready_s = wait_for_scene(method.law(), *remote_case.method, start, remote_case.round_trip_s);
  if (!ready_s) return tl::unexpected(ready_s.error());
  WholeScene zero_delay(scene.zero_delay_method);
  (void)zero_delay.step(start, 0);  // puts its proxy at the start of the path
  PrescribedTouch touch;
  touch.ready_s = *ready_s;
  MachineStalls stalls(remote_case.stall_s, kRemotePeriodS, remote_case.network.seed);
  std::optional<RemoteTraffic> traffic_before;
  std::optional<RemoteTraffic> traffic_after;
  for (std::size_t i = 0; i < path.rows.size(); ++i) {
    // The hand moves on during a stall. The last row is never missed.
    const std::size_t missed_periods = std::min(stalls.missed_before(i), path.rows.size() - 1 - i);
    i += missed_periods;
    touch.missed_periods += missed_periods;
    method.law().skip(missed_periods);
    const auto now_ns = static_cast<std::int64_t>(i + 1) * kPeriodNs;
    const Vec3 p_WD = path.rows[i].device_m();
    if (i >= path.first_sliding_row && !traffic_before) traffic_before = method.law().touch().traffic();
    if (i >= path.first_leaving_row && !traffic_after) traffic_after = method.law().touch().traffic();
    method.chain().sample(p_WD, now_ns);
    (void)zero_delay.step(p_WD, now_ns);
    const Vec3 zero_delay_n = shortened(zero_delay.last().force_n, device.model.max_force_n);
    touch.rows.push_back({p_WD, method.chain().force_n(), zero_delay_n, zero_delay.last().visual_offset_m.norm()});
  }
  if (traffic_before && traffic_after)
    touch.rates =
        rates_of(*traffic_after - *traffic_before, kRemotePeriodS * static_cast<double>(path.first_leaving_row - path.first_sliding_row));
  touch.scene_kb = 1e-3 * static_cast<double>(method.law().touch().traffic().scene.bytes);
  touch.force = compare_forces(touch.rows, kRemotePeriodS, searched_delay_s(remote_case.round_trip_s));
  return touch;
}

Result<ClosedLoopTouch> run_closed_loop(const RemoteScene& scene, const SlidePath& path, const RemoteDevice& device,
                                        const RemoteCase& remote_case, const std::vector<Vec3>* zero_delay) {
  if (!(device.hand.stiffness_n_per_m > 0.0)) return fail("a hand without a spring cannot follow a path");
  MethodChain method(scene, device, remote_case, MethodChain::Encoder::rounding);
  const Vec3 start = path.rows.front().device_m();
  if (const auto ready_s = wait_for_scene(method.law(), *remote_case.method, start, remote_case.round_trip_s); !ready_s)
    return tl::unexpected(ready_s.error());
  LoopSimulation simulation(method.chain(),
                            {.device = device.model,
                             .hand = device.hand,
                             .axes = 3,
                             .period_ns = kPeriodNs,
                             .path = path.make_hand_path(device.hand.stiffness_n_per_m, scene.stiffness_n_per_m, kRemotePeriodS),
                             .start_m = start});
  std::vector<LoopRow> rows;
  ClosedLoopTouch touch;
  touch.is_bounded = simulation.run_until(static_cast<std::int64_t>(path.rows.size()) * kPeriodNs, &rows);
  for (const LoopRow& row : rows) {
    touch.generated_j = std::max(touch.generated_j, row.motor_j - row.lost_j);
    touch.most_force_n = std::max(touch.most_force_n, row.force_n.norm());
    touch.p_WD.push_back(row.p_WD);
  }
  const std::size_t middle = (path.first_resting_row + path.first_leaving_row) / 2;
  if (touch.p_WD.size() >= path.first_leaving_row) {
    touch.limit_cycle_m = 0.5 * largest_distance(std::span(touch.p_WD).subspan(middle, path.first_leaving_row - middle));
  }
  if (zero_delay != nullptr) touch.path_error_m = path_error_of(touch.p_WD, *zero_delay, path);
  return touch;
}

namespace {

constexpr double kMinHeldN = 0.5;  // half of PressPlan::press_n: without a force, or behind the wall, the device would rest as well

double mean_force_n(std::span<const LoopRow> rows) {
  double sum = 0.0;
  for (const LoopRow& row : rows) sum += row.force_n.x();
  return sum / static_cast<double>(rows.size());
}

// Whether a press comes to rest as in find_rest_stiffness (closed_loop/press.h), and on the wall: it holds kMinHeldN or more in the last
// eighth of the press.
Result<bool> comes_to_rest(const RemoteDevice& device, const RemoteCase& remote_case, double stiffness_n_per_m) {
  const auto scene = make_remote_scene(make_wall_mesh(), {.stiffness_n_per_m = stiffness_n_per_m, .two_sided = false});
  if (!scene) return tl::unexpected(scene.error());
  MethodChain method(*scene, device, remote_case, MethodChain::Encoder::rounding);
  const PressPath path = make_press_path(device.hand, {.wall_n_per_m = stiffness_n_per_m});
  if (const auto ready_s = wait_for_scene(method.law(), *remote_case.method, path.start_m, remote_case.round_trip_s); !ready_s)
    return tl::unexpected(ready_s.error());
  LoopSimulation simulation(
      method.chain(), {.device = device.model, .hand = device.hand, .period_ns = kPeriodNs, .path = path.path, .start_m = path.start_m});
  std::vector<LoopRow> rows;
  if (!simulation.run_until(path.release_ns, &rows)) return false;
  const PressMeasures measures = measure_press(rows, path, kPeriodNs, device.model.encoder_step_m, true);
  return measures.is_still(device.model.encoder_step_m) && mean_force_n(std::span(rows).last(rows.size() / 8)) >= kMinHeldN;
}

}  // namespace

Result<double> find_rest_stiffness_of(const RemoteDevice& device, const RemoteCase& remote_case, double most_n_per_m) {
  const ValueRange range = {.first = 10.0, .ratio = 1.3, .most = most_n_per_m};  // N/m
  constexpr double kSearchWidth = 0.02;                                          // relative width at which the search ends
  std::optional<Error> error;
  const auto rests = [&](double stiffness_n_per_m) {
    const auto found = comes_to_rest(device, remote_case, stiffness_n_per_m);
    if (!found) error = found.error();
    return found.value_or(false);
  };
  const double largest = find_largest_value(range, kSearchWidth, rests);
  if (error) return tl::unexpected(*error);
  return largest;
}

}  // namespace hapton
