#include "closed_loop/press.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <span>

#include <unsupported/Eigen/FFT>

#include "closed_loop/largest_value.h"

namespace hapton {
namespace {

constexpr double kClearanceM = 0.005;   // before the surface, where a press begins
constexpr double kSettledShare = 0.05;  // share of the depth
constexpr double kStillShare = 0.01;    // share of the depth
constexpr double kEncoderSteps = 2.0;   // a motion of so many steps always counts as settled and still: the encoder may cause it by itself
constexpr double kLowestBuzzHz = 5.0;   // a hand follows slower oscillations

std::int64_t to_ns(double seconds) { return static_cast<std::int64_t>(1e9 * seconds); }

using Rows = std::span<const LoopRow>;

double mean_x(Rows rows) {
  double sum = 0.0;
  for (const LoopRow& row : rows) sum += row.p_WD.x();
  return rows.empty() ? 0.0 : sum / static_cast<double>(rows.size());
}

Rows between(const std::vector<LoopRow>& rows, std::int64_t from_ns, std::int64_t to_ns) {
  const auto by_time = [](const LoopRow& row, std::int64_t time_ns) { return row.time_ns < time_ns; };
  const auto first = std::lower_bound(rows.begin(), rows.end(), from_ns, by_time);
  const auto last = std::lower_bound(first, rows.end(), to_ns, by_time);
  return {first, last};
}

void measure_hold(Rows hold, double encoder_step_m, PressMeasures& press) {
  const Rows last = hold.last(hold.size() / 4);
  press.depth_m = -mean_x(last);
  double low = HUGE_VAL;
  double high = -HUGE_VAL;
  for (const LoopRow& row : last) {
    low = std::min(low, row.p_WD.x());
    high = std::max(high, row.p_WD.x());
  }
  press.limit_cycle_m = last.empty() ? 0.0 : 0.5 * (high - low);
  const double band_m = std::max(kSettledShare * std::fabs(press.depth_m), kEncoderSteps * encoder_step_m);
  double deepest_m = 0.0;
  press.settling_s = 0.0;
  bool is_settled = true;
  for (const LoopRow& row : hold) {
    deepest_m = std::max(deepest_m, -row.p_WD.x());
    is_settled = std::fabs(row.p_WD.x() + press.depth_m) <= band_m;
    if (!is_settled) press.settling_s = 1e-9 * static_cast<double>(row.time_ns) - press.contact_s;
  }
  if (!is_settled || press.limit_cycle_m > band_m) press.settling_s = std::numeric_limits<double>::infinity();
  if (press.depth_m > 0.0) press.overshoot = std::max(0.0, deepest_m / press.depth_m - 1.0);
}

// The time of the first force, or of the release if there is no force.
std::int64_t find_contact_ns(const std::vector<LoopRow>& rows, const PressPath& path) {
  const auto contact = std::find_if(rows.begin(), rows.end(), [](const LoopRow& row) { return row.force_n.x() != 0.0; });
  return contact == rows.end() ? path.release_ns : contact->time_ns;
}

void measure_energy(const std::vector<LoopRow>& rows, PressMeasures& press) {
  press.wall_j = rows.back().motor_j;
  press.generated_j = rows.back().motor_j - rows.back().lost_j;
  press.most_generated_j = 0.0;
  for (const LoopRow& row : rows) press.most_generated_j = std::max(press.most_generated_j, row.motor_j - row.lost_j);
}

}  // namespace

double compute_press_depth_m(const HandModel& hand, const PressPlan& plan) {
  return hand.stiffness_n_per_m > 0.0 ? plan.press_n * (1.0 / hand.stiffness_n_per_m + 1.0 / plan.wall_n_per_m) : 0.0;
}

PressPath make_press_path(const HandModel& hand, const PressPlan& plan) {
  PressPath press;
  press.start_m = {kClearanceM, 0.0, 0.0};
  if (!(hand.stiffness_n_per_m > 0.0)) {
    press.release_ns = to_ns(plan.hold_s);
    press.end_ns = press.release_ns + to_ns(plan.after_s);
    const Vec3 push_n(-plan.press_n, 0.0, 0.0);
    press.path = HandPath({{.time_ns = 0, .push_n = push_n}, {.time_ns = press.release_ns, .push_n = -push_n}, {.time_ns = press.end_ns}});
    return press;
  }
  const double goal_m = -compute_press_depth_m(hand, plan);
  const std::int64_t travel_ns = to_ns((kClearanceM - goal_m) / plan.speed_m_per_s);
  press.release_ns = travel_ns + to_ns(plan.hold_s);
  press.end_ns = press.release_ns + travel_ns + to_ns(plan.after_s);
  const Vec3 goal(goal_m, 0.0, 0.0);
  press.path = HandPath({{.time_ns = 0, .p_WH = press.start_m},
                         {.time_ns = travel_ns, .p_WH = goal},
                         {.time_ns = press.release_ns, .p_WH = goal},
                         {.time_ns = press.release_ns + travel_ns, .p_WH = press.start_m}});
  return press;
}

bool PressMeasures::is_still(double encoder_step_m) const noexcept {
  return limit_cycle_m <= std::max(kEncoderSteps * encoder_step_m, kStillShare * std::fabs(depth_m));
}

PressMeasures measure_press(const std::vector<LoopRow>& rows, const PressPath& path, std::int64_t period_ns, double encoder_step_m,
                            bool is_bounded) {
  PressMeasures press;
  press.is_bounded = is_bounded;
  if (rows.empty()) return press;
  const std::int64_t contact_ns = find_contact_ns(rows, path);
  press.contact_s = 1e-9 * static_cast<double>(contact_ns);
  press.has_contact = contact_ns < path.release_ns;
  measure_energy(rows, press);
  press.settling_s = std::numeric_limits<double>::infinity();
  if (!press.has_contact) return press;
  const Rows hold = between(rows, contact_ns, path.release_ns);
  measure_hold(hold, encoder_step_m, press);
  const SpectrumPeak buzz = find_spectrum_peak(compute_buzz_spectrum(rows, path, period_ns), kLowestBuzzHz);
  press.buzz_hz = buzz.frequency_hz;
  press.buzz_n = buzz.amplitude;
  return press;
}

namespace {

bool comes_to_rest(const PressCase& press, double stiffness_n_per_m) {
  WallLaw wall({.stiffness_n_per_m = stiffness_n_per_m, .damping_ns_per_m = press.wall_damping_ns_per_m});
  ForceChain chain(wall, {.encoder_step_m = press.device.encoder_step_m,
                          .max_force_n = press.device.max_force_n,
                          .to_law = press.to_law,
                          .from_law = press.from_law,
                          .seed = press.seed});
  const PressPath path = make_press_path(press.hand, {.wall_n_per_m = stiffness_n_per_m});
  LoopSimulation simulation(
      chain, {.device = press.device, .hand = press.hand, .period_ns = press.period_ns, .path = path.path, .start_m = path.start_m});
  std::vector<LoopRow> rows;
  if (!simulation.run_until(path.release_ns, &rows)) return false;
  const PressMeasures measures = measure_press(rows, path, press.period_ns, press.device.encoder_step_m, true);
  return measures.has_contact && measures.is_still(press.device.encoder_step_m);
}

}  // namespace

double find_rest_stiffness(const PressCase& press, double most_n_per_m) {
  const ValueRange range = {.first = 10.0, .ratio = 1.3, .least = 0.01, .most = most_n_per_m};
  constexpr double kFine = 0.01;  // relative width at which the search ends
  return find_largest_value(range, kFine, [&](double stiffness_n_per_m) { return comes_to_rest(press, stiffness_n_per_m); });
}

std::vector<SpectrumPeak> compute_spectrum(const std::vector<double>& signal, double rate_hz) {
  const std::size_t count = signal.size();
  if (count < 8) return {};
  double mean = 0.0;
  for (const double value : signal) mean += value / static_cast<double>(count);
  std::vector<double> windowed(count);
  for (std::size_t i = 0; i < count; ++i) {
    // The sum of the window is half of the count; the amplitude is divided by this sum.
    const double window = 0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(count));
    windowed[i] = window * (signal[i] - mean);
  }
  std::vector<std::complex<double>> lines;
  Eigen::FFT<double> fft;
  fft.fwd(lines, windowed);
  std::vector<SpectrumPeak> spectrum;
  for (std::size_t i = 1; i <= count / 2; ++i) {
    spectrum.push_back(
        {static_cast<double>(i) * rate_hz / static_cast<double>(count), 4.0 / static_cast<double>(count) * std::abs(lines[i])});
  }
  return spectrum;
}

SpectrumPeak find_spectrum_peak(const std::vector<SpectrumPeak>& spectrum, double lowest_hz) {
  SpectrumPeak peak;
  for (const SpectrumPeak& line : spectrum) {
    if (line.frequency_hz >= lowest_hz && line.amplitude > peak.amplitude) peak = line;
  }
  return peak;
}

std::vector<SpectrumPeak> compute_buzz_spectrum(const std::vector<LoopRow>& rows, const PressPath& path, std::int64_t period_ns) {
  const Rows hold = between(rows, find_contact_ns(rows, path), path.release_ns);
  std::vector<double> force_n;
  for (const LoopRow& row : hold.last(hold.size() / 2)) force_n.push_back(row.force_n.x());
  return compute_spectrum(force_n, 1e9 / static_cast<double>(period_ns));
}

}  // namespace hapton
