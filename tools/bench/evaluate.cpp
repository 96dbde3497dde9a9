#include "tools/bench/evaluate.h"

#include <algorithm>
#include <atomic>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <thread>

#include "core/force/reference/reference_method.h"
#include "core/geometry/mesh_measures.h"
#include "runtime/start_thread.h"

namespace hapton {
namespace {

using Json = nlohmann::ordered_json;

void run_segment(ForceMethod& method, const TouchTrajectory& trajectory, std::size_t from, std::size_t to,
                 std::vector<ForceSample>& samples) {
  const auto* const reference = dynamic_cast<const ReferenceMethod*>(&method);
  method.reset(trajectory.p_SD[from]);
  for (std::size_t i = from; i < to; ++i) {
    const MethodOutput output = method.step({.p_SD = trajectory.p_SD[i]});
    samples[i] = {trajectory.p_SD[i], output.p_SP, output.force_n, reference == nullptr || reference->last_step().settled};
  }
}

Json spread_json(const ErrorSpread& spread) {
  return {{"n", spread.count}, {"rms", spread.rms}, {"p50", spread.p50}, {"p99", spread.p99}, {"max", spread.most}};
}

std::string percent(const ErrorSpread& spread) {
  return fmt::format("RMS {:.4g} %  p50 {:.4g} %  p99 {:.4g} %  max {:.4g} %  (n {})", 100.0 * spread.rms, 100.0 * spread.p50,
                     100.0 * spread.p99, 100.0 * spread.most, spread.count);
}

}  // namespace

Result<std::vector<ForceSample>> run_method(const MethodSettings& settings, const TouchScene& scene, const TouchTrajectory& trajectory,
                                            unsigned threads) {
  const std::size_t rows = trajectory.p_SD.size();
  const std::size_t segment = trajectory.reset_every == 0 ? std::max<std::size_t>(1, rows) : trajectory.reset_every;
  const std::size_t segments = (rows + segment - 1) / segment;
  const auto workers = static_cast<unsigned>(std::min<std::size_t>(std::max(1U, threads), segments));
  std::vector<std::unique_ptr<ForceMethod>> methods;
  for (unsigned i = 0; i < workers; ++i) {
    auto method = make_method(settings, scene);
    if (!method) return tl::unexpected(method.error());
    methods.push_back(std::move(*method));
  }
  std::vector<ForceSample> samples(rows);
  std::atomic<std::size_t> next{0};
  auto work = [&](ForceMethod& method) {
    for (std::size_t i = next++; i < segments; i = next++)
      run_segment(method, trajectory, i * segment, std::min(rows, (i + 1) * segment), samples);
  };
  std::vector<std::thread> pool;
  for (unsigned i = 1; i < workers; ++i) pool.push_back(start_thread([&, i] { work(*methods[i]); }));
  if (workers > 0) work(*methods[0]);
  for (std::thread& thread : pool) thread.join();
  return samples;
}

Result<Evaluation> evaluate_method(const EvaluationSettings& settings, const TouchScene& scene, const TouchTrajectory& trajectory) {
  Evaluation evaluation;
  if (settings.method.name == "proxy") evaluation.shading = settings.method.shading;
  auto run = [&](const MethodSettings& method, std::vector<ForceSample>& samples) -> Result<void> {
    auto done = run_method(method, scene, trajectory, settings.threads);
    if (!done) return tl::unexpected(done.error());
    samples = std::move(*done);
    return {};
  };
  MethodSettings reference = settings.method;
  reference.name = "reference";
  reference.reference_substeps = settings.substeps;
  reference.reference_substep_limit = settings.substep_limit;
  if (auto done = run(settings.method, evaluation.method); !done) return tl::unexpected(done.error());
  if (auto done = run(reference, evaluation.reference); !done) return tl::unexpected(done.error());
  ForceErrorSettings error;
  error.stiffness_n_per_m = scene.objects.front().material.stiffness_n_per_m;
  error.extent_m = 0.0;
  for (const TouchObject& object : scene.objects) error.extent_m = std::max(error.extent_m, compute_bounds(*object.mesh).extent());
  error.reset_every = trajectory.reset_every;
  evaluation.error = compare_forces(evaluation.method, evaluation.reference, error);
  return evaluation;
}

std::string to_text(const Evaluation& evaluation) {
  const ForceError& error = evaluation.error;
  std::string text;
  if (evaluation.shading > 0.0) {
    text += fmt::format("force shading {:g}: the shaded force against the unshaded reference\n", evaluation.shading);
  }
  text += fmt::format("steps {}, contact {}, reference not settled {}, not finite {}\n", error.steps, error.contact_steps,
                      error.unsettled_steps, error.not_finite);
  text += fmt::format("force error, all contact steps:   {}\n", percent(error.error));
  const double degrees = 180.0 / std::numbers::pi;
  text += fmt::format("direction:                        p50 {:.4g} deg  p99 {:.4g} deg  max {:.4g} deg\n",
                      degrees * error.direction_rad.p50, degrees * error.direction_rad.p99, degrees * error.direction_rad.most);
  text +=
      fmt::format("branch switches {}, steps in them {} (their errors are included above)\n", error.branch_switches, error.switched_steps);
  text += fmt::format("fall-throughs {}, false contacts {}, stuck steps {}, force discontinuities {} (worst {:.4g} N above the bound)\n",
                      error.fall_throughs, error.false_contacts, error.stuck_steps, error.discontinuities, error.worst_discontinuity_n);
  return text;
}

std::string to_json(const Evaluation& evaluation) {
  const ForceError& error = evaluation.error;
  const Json json{{"schema", "hapton.evaluation/2"},
                  {"shading", evaluation.shading},
                  {"reference_shading", 0.0},
                  {"steps", error.steps},
                  {"contact_steps", error.contact_steps},
                  {"unsettled_steps", error.unsettled_steps},
                  {"force_error", spread_json(error.error)},
                  {"direction_rad", spread_json(error.direction_rad)},
                  {"branch_switches", error.branch_switches},
                  {"switched_steps", error.switched_steps},
                  {"fall_throughs", error.fall_throughs},
                  {"false_contacts", error.false_contacts},
                  {"stuck_steps", error.stuck_steps},
                  {"force_discontinuities", error.discontinuities},
                  {"worst_discontinuity_n", error.worst_discontinuity_n},
                  {"not_finite", error.not_finite},
                  {"worst_step", error.worst_step}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace hapton
