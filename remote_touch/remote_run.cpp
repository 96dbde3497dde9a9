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

constexpr std::int64_t kPeriodNs = 1'000'000;
constexpr double kPeriodS = 1e-3;
constexpr double kMinWaitS = 0.5;  // shortest time that the hand waits for the scene to arrive before it begins
constexpr double kMaxWaitS = 120.0;
constexpr double kGreetingsHz = 10.0;     // HubClient::kHelloPeriodNs
constexpr double kGreetingBytes = 110.0;  // about the size of the IP packet of a Hello or a Welcome
constexpr double kLateShare = 1.5;        // largest delay of a force that the comparison considers, as a share of the round trip
constexpr double kMinLateS = 0.03;        // the largest delay considered is at least this, for short round trips

// A method as a force law, in the chain from position to motors. A passive method without a governor gets the passivity controller here.
class Rig {
 public:
  // is_ideal: positions are not rounded to encoder steps.
  Rig(const RemoteScene& scene, const RemoteDevice& device, const RemoteCase& remote_case, bool is_ideal)
      : law_(*remote_case.method, make_remote_touch(*remote_case.method, scene, remote_case.network, remote_case.settings),
             {.limits = device.limits, .mechanics = mechanics_of(device.model)}, kPeriodNs),
        stage_({.device = mechanics_of(device.model),
                .most_damping_ns_per_m = 250.0 * device.model.mass_kg,
                .max_force_n = device.model.max_force_n}),
        chain_(law_, {.encoder_step_m = is_ideal ? 0.0 : device.model.encoder_step_m,
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
  return {.packets_up = per_s(traffic.up.packets) + kGreetingsHz,
          .packets_down = per_s(traffic.down.packets) + kGreetingsHz,
          .bytes_up = per_s(traffic.up.bytes) + kGreetingsHz * kGreetingBytes,
          .bytes_down = per_s(traffic.down.bytes) + kGreetingsHz * kGreetingBytes};
}

Result<double> wait_for_scene(RemoteLaw& law, const RemoteMethod& method, const Vec3& p_WD, double round_trip_s) {
  const auto ready_s = law.wait(p_WD, kMinWaitS + 2.0 * round_trip_s, kMaxWaitS);
  if (!ready_s) return fail("{}: the scene around the hand had not arrived after {:g} s", method.name, kMaxWaitS);
  return *ready_s;
}

double path_error_of(const std::vector<Vec3>& p_WD, const std::vector<Vec3>& zero_delay, const SlidePath& path) {
  double sum = 0.0;
  const std::size_t end = std::min({p_WD.size(), zero_delay.size(), path.leaving});
  if (end <= path.sliding) return 0.0;
  for (std::size_t i = path.sliding; i < end; ++i) sum += (p_WD[i] - zero_delay[i]).squaredNorm();
  return std::sqrt(sum / static_cast<double>(end - path.sliding));
}

}  // namespace

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
  Rig rig(scene, device, remote_case, true);
  const Vec3 start = path.rows.front().device_m();
  const auto ready_s = wait_for_scene(rig.law(), *remote_case.method, start, remote_case.round_trip_s);
  if (!ready_s) return tl::unexpected(ready_s.error());
  WholeScene whole_scene(scene.near);
  (void)whole_scene.step(start, 0);
  PrescribedTouch touch;
  touch.ready_s = *ready_s;
  MachineStalls stalls(remote_case.stall_s, kPeriodS, remote_case.network.seed);
  std::optional<RemoteTraffic> traffic_before;
  std::optional<RemoteTraffic> traffic_after;
  for (std::size_t i = 0; i < path.rows.size(); ++i) {
    const std::size_t missed = std::min(stalls.missed_before(i), path.rows.size() - 1 - i);
    i += missed;
    touch.missed += missed;
    rig.law().skip(missed);
    const auto now_ns = static_cast<std::int64_t>(i + 1) * kPeriodNs;
    const Vec3 p_WD = path.rows[i].device_m();
    if (i >= path.sliding && !traffic_before) traffic_before = rig.law().touch().traffic();
    if (i >= path.leaving && !traffic_after) traffic_after = rig.law().touch().traffic();
    rig.chain().sample(p_WD, now_ns);
    (void)whole_scene.step(p_WD, now_ns);
    const Vec3 zero_delay_n = shortened(whole_scene.last().force_n, device.model.max_force_n);
    touch.rows.push_back({p_WD, rig.chain().force_n(), zero_delay_n, whole_scene.last().visual_offset_m.norm()});
  }
  if (traffic_before && traffic_after)
    touch.rates = rates_of(*traffic_after - *traffic_before, kPeriodS * static_cast<double>(path.leaving - path.sliding));
  touch.scene_kb = 1e-3 * static_cast<double>(rig.law().touch().traffic().scene.bytes);
  touch.force = compare_forces(touch.rows, kPeriodS, std::max(kLateShare * remote_case.round_trip_s, kMinLateS));
  return touch;
}

Result<ClosedLoopTouch> run_closed_loop(const RemoteScene& scene, const SlidePath& path, const RemoteDevice& device,
                                        const RemoteCase& remote_case, const std::vector<Vec3>* zero_delay) {
  if (!(device.hand.stiffness_n_per_m > 0.0)) return fail("a hand without a spring cannot follow a path");
  Rig rig(scene, device, remote_case, false);
  const Vec3 start = path.rows.front().device_m();
  if (const auto ready_s = wait_for_scene(rig.law(), *remote_case.method, start, remote_case.round_trip_s); !ready_s)
    return tl::unexpected(ready_s.error());
  LoopSimulation simulation(rig.chain(), {.device = device.model,
                                          .hand = device.hand,
                                          .axes = 3,
                                          .period_ns = kPeriodNs,
                                          .path = path.make_hand_path(device.hand.stiffness_n_per_m, scene.stiffness_n_per_m, kPeriodS),
                                          .start_m = start});
  std::vector<LoopRow> rows;
  ClosedLoopTouch touch;
  touch.is_bounded = simulation.run_until(static_cast<std::int64_t>(path.rows.size()) * kPeriodNs, &rows);
  for (const LoopRow& row : rows) {
    touch.generated_j = std::max(touch.generated_j, row.motor_j - row.lost_j);
    touch.most_force_n = std::max(touch.most_force_n, row.force_n.norm());
    touch.p_WD.push_back(row.p_WD);
  }
  const std::size_t middle = (path.resting + path.leaving) / 2;
  if (touch.p_WD.size() >= path.leaving) {
    touch.limit_cycle_m = 0.5 * largest_distance(std::span(touch.p_WD).subspan(middle, path.leaving - middle));
  }
  if (zero_delay != nullptr) touch.path_error_m = path_error_of(touch.p_WD, *zero_delay, path);
  return touch;
}

namespace {

constexpr double kMinHeldN = 0.5;  // force that the wall has to hold at least; the hand presses with 1 N

double mean_force_n(std::span<const LoopRow> rows) {
  double sum = 0.0;
  for (const LoopRow& row : rows) sum += row.force_n.x();
  return sum / static_cast<double>(rows.size());
}

// Whether a press comes to rest as in find_rest_stiffness (closed_loop/press.h), and on the wall: it holds kMinHeldN or more.
Result<bool> comes_to_rest(const RemoteDevice& device, const RemoteCase& remote_case, double stiffness_n_per_m) {
  const auto scene = make_remote_scene(make_wall_mesh(), {.stiffness_n_per_m = stiffness_n_per_m, .two_sided = false});
  if (!scene) return tl::unexpected(scene.error());
  Rig rig(*scene, device, remote_case, false);
  const PressPath path = make_press_path(device.hand, {.wall_n_per_m = stiffness_n_per_m});
  if (const auto ready_s = wait_for_scene(rig.law(), *remote_case.method, path.start_m, remote_case.round_trip_s); !ready_s)
    return tl::unexpected(ready_s.error());
  LoopSimulation simulation(
      rig.chain(), {.device = device.model, .hand = device.hand, .period_ns = kPeriodNs, .path = path.path, .start_m = path.start_m});
  std::vector<LoopRow> rows;
  if (!simulation.run_until(path.release_ns, &rows)) return false;
  const PressMeasures measures = measure_press(rows, path, kPeriodNs, device.model.encoder_step_m, true);
  constexpr double kStill = 0.01;  // largest limit cycle as a share of the depth, as in closed_loop/press.cpp
  const bool is_still = measures.limit_cycle_m <= std::max(2.0 * device.model.encoder_step_m, kStill * std::fabs(measures.depth_m));
  return is_still && mean_force_n(std::span(rows).last(rows.size() / 8)) >= kMinHeldN;
}

}  // namespace

Result<double> find_rest_stiffness_of(const RemoteDevice& device, const RemoteCase& remote_case, double most_n_per_m) {
  const ValueRange range = {.first = 10.0, .stride = 1.3, .most = most_n_per_m};
  constexpr double kSearchWidth = 0.02;  // relative width at which the search ends
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
