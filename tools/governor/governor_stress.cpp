#include "tools/governor/governor_stress.h"

#include <algorithm>
#include <numeric>

namespace hapton {
namespace {

void add_to(GovernorCounters& sum, const GovernorCounters& more) {
  sum.accepted += more.accepted;
  sum.not_finite += more.not_finite;
  sum.rejected_old += more.rejected_old;
  sum.rejected_future += more.rejected_future;
  sum.command_timeouts += more.command_timeouts;
  sum.clamped += more.clamped;
  sum.rate_limited += more.rate_limited;
  sum.bad_samples += more.bad_samples;
  sum.workspace_limited += more.workspace_limited;
  sum.speed_limited += more.speed_limited;
  sum.damped += more.damped;
  sum.kept_passive += more.kept_passive;
  sum.thermal_limited += more.thermal_limited;
  sum.releases += more.releases;
  sum.latched += more.latched;
  sum.resets += more.resets;
  sum.resets_rejected += more.resets_rejected;
  for (std::size_t fault = 0; fault < sum.faults.size(); ++fault) sum.faults[fault] += more.faults[fault];
}

void keep_maxima(GovernorWorst& worst, const GovernorWorst& other) {
  worst.force = std::max(worst.force, other.force);
  worst.torque = std::max(worst.torque, other.torque);
  worst.force_slew = std::max(worst.force_slew, other.force_slew);
  worst.torque_slew = std::max(worst.torque_slew, other.torque_slew);
  worst.heat = std::max(worst.heat, other.heat);
  worst.energy = std::max(worst.energy, other.energy);
  worst.release_ms = std::max(worst.release_ms, other.release_ms);
}

}  // namespace

std::uint64_t GovernorStressCount::total_breaches() const noexcept {
  return std::accumulate(breaches.begin(), breaches.end(), std::uint64_t{0});
}

void GovernorStressCount::add(const GovernorStressCount& other) noexcept {
  turns += other.turns;
  programs += other.programs;
  turns_with_force += other.turns_with_force;
  for (std::size_t n = 0; n < breaches.size(); ++n) {
    if (breaches[n] == 0) findings[n] = other.findings[n];
    breaches[n] += other.breaches[n];
  }
  add_to(governors, other.governors);
  keep_maxima(worst, other.worst);
}

std::uint64_t GovernorStress::program_seed(std::uint64_t program) const noexcept {
  return SplitMix(SplitMix(seed_).bits() + program).bits();
}

void GovernorStress::run(std::uint64_t program_seed, GovernorStressCount& count) noexcept {
  HostileProgram program(program_seed);
  SafetyGovernor governor(program.device());
  GovernorEvaluator evaluator(program, governor);
  run(program_seed, program, governor, evaluator, count);
}

void GovernorStress::run(std::uint64_t program_seed, HostileProgram& program, SafetyGovernor& governor, GovernorEvaluator& evaluator,
                         GovernorStressCount& count) noexcept {
  governor.require_button(program.button());
  auto breaches = evaluator.breaches();
  Wrench out;
  for (int turn = 0; turn < program.turns(); ++turn) {
    const HostileStep& step = program.turn(out);
    if (step.tighter_limits) governor.tighten(*step.tighter_limits);
    const bool was_reset = step.resets_faults && governor.reset_faults();
    if (step.temperature >= 0.0) governor.observe_temperature(step.temperature);
    governor.observe(step.sample, step.status);
    out = governor.step(step.command, step.now_ns);
    evaluator.evaluate(step, was_reset, out);
    count.turns_with_force += out.force_n != Vec3::Zero() ? 1 : 0;
    if (evaluator.breaches() == breaches) continue;
    for (std::size_t n = 0; n < breaches.size(); ++n) {
      if (evaluator.breaches()[n] > breaches[n] && count.breaches[n] + breaches[n] == 0) count.findings[n] = {program_seed, turn};
    }
    breaches = evaluator.breaches();
  }
  for (std::size_t n = 0; n < breaches.size(); ++n) count.breaches[n] += breaches[n];
  count.turns += static_cast<std::uint64_t>(program.turns());
  ++count.programs;
  add_to(count.governors, governor.counters());
  keep_maxima(count.worst, evaluator.worst());
}

}  // namespace hapton
