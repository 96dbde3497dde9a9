#include "closed_loop/prescribed_motion.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/math/dense_matrix.h"

namespace hapton {
namespace {

constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();

// Goes from event to event: samples, forces that arrive, and events of the motion (next_ns). Calls on_piece(from_ns, to_ns, force_n) for
// each piece of constant force.
template <class Position, class Next, class OnPiece>
void visit_pieces(ForceChain& chain, std::int64_t period_ns, std::int64_t end_ns, Position position_m, Next next_ns, OnPiece on_piece) {
  for (std::int64_t now_ns = 0, tick_ns = 0; now_ns < end_ns;) {
    if (now_ns == tick_ns) {
      chain.sample({position_m(now_ns), 0.0, 0.0}, now_ns);
      tick_ns += period_ns;
    }
    const std::int64_t until_ns = std::min({end_ns, tick_ns, chain.next_ns().value_or(kNever), next_ns(now_ns)});
    on_piece(now_ns, until_ns, chain.force_n().x());
    now_ns = until_ns;
    chain.receive(now_ns);
  }
}

double to_seconds(std::int64_t ns) { return 1e-9 * static_cast<double>(ns); }

// The unit eigenvector of the larger eigenvalue. Pre: a is Hermitian.
Eigen::Vector2cd find_largest_eigenvector(const Eigen::Matrix2cd& a) {
  const double half_gap = 0.5 * (a(0, 0).real() - a(1, 1).real());
  const double radius = std::hypot(half_gap, std::abs(a(0, 1)));
  // Orthogonal to that row of a - eigenvalue * I in which nothing cancels.
  const Eigen::Vector2cd v = half_gap >= 0.0 ? Eigen::Vector2cd(half_gap + radius, a(1, 0)) : Eigen::Vector2cd(a(0, 1), radius - half_gap);
  return v.norm() > 0.0 ? Eigen::Vector2cd(v.normalized()) : Eigen::Vector2cd(0.0, 1.0);
}

HandPath::Point make_point(std::int64_t time_ns, double x_m) { return {.time_ns = time_ns, .p_WH = {x_m, 0.0, 0.0}}; }

// Tries motions of a hand on one device, at one rate and delay, and keeps the least stiffness at which one of them gains energy.
class OnsetSearch {
 public:
  OnsetSearch(const DeviceModel& device, std::int64_t period_ns, std::int64_t delay_ns)
      : device_(device), period_ns_(period_ns), delay_ns_(delay_ns) {}

  EnergyOnset run() {
    press_and_release();
    swing_between_samples();
    if (device_.encoder_step_m > 0.0) oscillate_at_an_encoder_edge();
    return onset_;
  }

 private:
  // A motion so long that the changes of speed at its ends are negligible, and so fast that friction is negligible beside damping.
  void press_and_release() {
    constexpr std::int64_t kDelaysPerPress = 100;  // duration of the press, in multiples of the period plus the delay
    const std::int64_t press_ns = kDelaysPerPress * (period_ns_ + delay_ns_);
    const double damping = std::max(device_.damping_ns_per_m, 1e-9);
    const double speed = std::max(0.05, 1e4 * device_.friction_n / damping);
    const double depth_m = speed * to_seconds(press_ns);
    try_motion(HandPath({make_point(0, 0.0), make_point(press_ns, -depth_m), make_point(2 * press_ns, 0.0)}), "press and release");
  }

  // The worst motion at one frequency and its aliases: two speeds in each period, before and after the force changes. The speeds are the
  // eigenvector with the most work for the same heat; their phases advance by the frequency from period to period.
  void swing_between_samples() {
    constexpr int kFrequencies = 24;          // from 0.1 rad over the delay to nearly Nyquist
    constexpr std::int64_t kMaxPeriods = 20;  // whole periods of delay; beyond them press_and_release() finds the least stiffness
    const std::int64_t whole_periods = delay_ns_ / period_ns_;
    const std::int64_t remainder_ns = delay_ns_ % period_ns_;
    if (whole_periods > kMaxPeriods || remainder_ns == 0) return;
    const double lowest = 0.1 / static_cast<double>(whole_periods + 1);
    for (int i = 0; i < kFrequencies; ++i) {
      const double angle = lowest * std::pow(0.98 * std::numbers::pi / lowest, i / (kFrequencies - 1.0));
      try_motion(swing(angle, whole_periods, remainder_ns),
                 fmt::format("swing between samples, {:.4g} Hz", angle / (2.0 * std::numbers::pi * to_seconds(period_ns_))));
    }
  }

  HandPath swing(double angle, std::int64_t whole_periods, std::int64_t remainder_ns) const {
    constexpr double kCycles = 60.0;  // enough to outweigh the beginning; any speed will do, because the system is linear
    constexpr double kSpeed = 1.0;
    // Square roots of the durations of the two parts of a period: speeds y / root_duration dissipate a heat proportional to |y|^2.
    const Eigen::Vector2d root_duration(std::sqrt(to_seconds(remainder_ns)), std::sqrt(to_seconds(period_ns_ - remainder_ns)));
    const Complex turn = std::polar(1.0, angle);
    // The position read is read_position^T y; the force on each part of a period is that of an older sample.
    const Eigen::Vector2cd read_position = root_duration.cast<Complex>() / (turn - 1.0);
    const Eigen::Vector2cd force(-root_duration[0] * std::pow(turn, -static_cast<double>(whole_periods + 1)),
                                 -root_duration[1] * std::pow(turn, -static_cast<double>(whole_periods)));
    const Eigen::Matrix2cd work = 0.5 * (force * read_position.transpose() + read_position.conjugate() * force.adjoint());
    const Eigen::Vector2cd speed = kSpeed * find_largest_eigenvector(work).cwiseQuotient(root_duration.cast<Complex>());
    std::vector<HandPath::Point> points;
    double x_m = 0.0;
    const auto periods = static_cast<std::int64_t>(kCycles * 2.0 * std::numbers::pi / angle);
    for (std::int64_t k = 0; k < periods; ++k) {
      const Complex phase = std::polar(1.0, std::remainder(angle * static_cast<double>(k), 2.0 * std::numbers::pi));
      points.push_back(make_point(k * period_ns_, x_m));
      x_m += to_seconds(remainder_ns) * std::real(speed[0] * phase);
      points.push_back(make_point(k * period_ns_ + remainder_ns, x_m));
      x_m += to_seconds(period_ns_ - remainder_ns) * std::real(speed[1] * phase);
    }
    return HandPath(std::move(points));
  }

  // Moves back and forth across an encoder edge by a small part of a step: the position read changes by a whole step each time.
  void oscillate_at_an_encoder_edge() {
    constexpr int kCycles = 50;
    for (std::int64_t half_ns = period_ns_; half_ns <= 4 * (period_ns_ + delay_ns_); half_ns += period_ns_) {
      for (const std::int64_t begin_ns : {std::int64_t{0}, period_ns_ / 2}) {
        const double edge_m = -1.5 * device_.encoder_step_m;
        const double swing_m = 1e-5 * device_.encoder_step_m;
        std::vector<HandPath::Point> points;
        for (int i = 0; i <= 2 * kCycles; ++i)
          points.push_back(make_point(begin_ns + i * half_ns, edge_m + (i % 2 == 0 ? swing_m : -swing_m)));
        try_motion(HandPath(std::move(points)), fmt::format("oscillation at an encoder edge, {:g} Hz", 0.5 / to_seconds(half_ns)));
      }
    }
  }

  void try_motion(const HandPath& path, const std::string& name) {
    WallLaw unit_wall({.stiffness_n_per_m = 1.0, .two_sided = true});
    ForceChain::Options link{.encoder_step_m = device_.encoder_step_m};
    link.to_law.delay_ns = delay_ns_;
    ForceChain chain(unit_wall, link);
    const EnergyOfMotion energy = measure_energy(chain, device_, path, period_ns_, period_ns_ + delay_ns_);
    if (!(energy.motor_j > 0.0)) return;
    const double stiffness = energy.lost_j / energy.motor_j;
    if (stiffness < onset_.stiffness_n_per_m) onset_ = {stiffness, name};
  }

  const DeviceModel& device_;
  std::int64_t period_ns_;
  std::int64_t delay_ns_;
  EnergyOnset onset_{std::numeric_limits<double>::infinity(), "none"};
};

}  // namespace

EnergyOfMotion measure_energy(ForceChain& chain, const DeviceModel& device, const HandPath& path, std::int64_t period_ns,
                              std::int64_t after_ns) {
  EnergyOfMotion energy;
  const auto position_m = [&](std::int64_t now_ns) { return path.position_m(now_ns).x(); };
  visit_pieces(
      chain, period_ns, path.end_ns() + after_ns, position_m, [&](std::int64_t now_ns) { return path.next_ns(now_ns); },
      [&](std::int64_t from_ns, std::int64_t to_ns, double force_n) {
        const double speed = path.velocity_m_per_s(from_ns).x();
        const double moved_m = speed * to_seconds(to_ns - from_ns);
        energy.motor_j += force_n * moved_m;
        energy.lost_j += device.damping_ns_per_m * speed * moved_m + device.friction_n * std::fabs(moved_m);
      });
  return energy;
}

EnergyOnset find_energy_onset(const DeviceModel& device, std::int64_t period_ns, std::int64_t delay_ns) {
  return OnsetSearch(device, period_ns, delay_ns).run();
}

std::complex<double> measure_rendered_stiffness(ForceChain& chain, std::int64_t period_ns, double frequency_hz, double bias_m,
                                                double amplitude_m, std::int64_t settle_ns, int cycles) {
  const double omega = 2.0 * std::numbers::pi * frequency_hz;
  const double settling = std::max(1.0, std::ceil(frequency_hz * to_seconds(settle_ns)));
  const auto begin_ns = static_cast<std::int64_t>(std::llround(1e9 / frequency_hz * settling));
  const auto end_ns = static_cast<std::int64_t>(std::llround(1e9 / frequency_hz * (settling + cycles)));
  Complex force;
  const auto turned = [&](std::int64_t ns) { return std::polar(1.0, -omega * to_seconds(ns)); };
  visit_pieces(
      chain, period_ns, end_ns, [&](std::int64_t ns) { return bias_m + amplitude_m * std::sin(omega * to_seconds(ns)); },
      [](std::int64_t) { return kNever; },
      [&](std::int64_t from_ns, std::int64_t to_ns, double force_n) {
        from_ns = std::max(from_ns, begin_ns);
        // The integral of the constant force times e^(-j omega t).
        if (to_ns > from_ns) force += force_n * (turned(from_ns) - turned(to_ns)) / Complex(0.0, omega);
      });
  // amplitude * sin(omega t) has the coefficient amplitude / 2j.
  const Complex position = Complex(0.0, -0.5) * amplitude_m * to_seconds(end_ns - begin_ns);
  return -force / position;
}

}  // namespace hapton
