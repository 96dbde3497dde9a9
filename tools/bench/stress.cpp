#include "tools/bench/stress.h"

#include <algorithm>
#include <atomic>
#include <iterator>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "runtime/report.h"
#include "runtime/start_thread.h"
#include "tools/bench/patch_method.h"

namespace hapton {
namespace {

using Json = nlohmann::ordered_json;

// A variant gets walks of 20,000 steps in addition: one if it has at least 10,000 steps, and one more for every further 40,000, so that in
// a long test about a third of all steps are in walks.
constexpr std::uint64_t kStepsForFirstWalk = 10000;
constexpr std::uint64_t kStepsPerFurtherWalk = 40000;

constexpr auto kFaultCount = static_cast<std::size_t>(StressFault::count);

StressSettings settings_of(const StressPlan& plan, const StressVariant& variant) {
  StressSettings settings;
  settings.seed = plan.seed;
  settings.scale = variant.scale;
  settings.offset_extents = variant.offset_extents;
  settings.material.friction_static = variant.friction_static;
  settings.material.friction_dynamic = variant.friction_dynamic;
  settings.compare_every = plan.compare_every;
  return settings;
}

StressBody as_planned(StressBody body, const StressPlan& plan) {
  if (plan.probe_share > 0.0) body.probe_share = plan.probe_share;
  return plan.by_patches || plan.on_grid ? on_patch_grid(std::move(body)) : body;
}

Result<StressRun> make_run(const StressBody& body, const StressPlan& plan, const StressVariant& variant) {
  const StressBody planned = as_planned(body, plan);
  const StressSettings settings = settings_of(plan, variant);
  if (!plan.by_patches) return StressRun::make(planned, settings, plan.method);
  const auto make_by_patches = [](const MethodSettings& method, const TouchScene& scene) -> Result<std::unique_ptr<ForceMethod>> {
    return std::make_unique<PatchMethod>(method, scene);
  };
  return StressRun::make(planned, settings, plan.method, make_by_patches);
}

Result<StressCount> run_one(const StressBody& body, const StressPlan& plan, const StressVariant& variant, std::uint64_t steps) {
  auto run = make_run(body, plan, variant);
  if (!run) return tl::unexpected(run.error());
  StressCount count;
  // Some episodes find no free position and take no step, so the number of episodes is limited, too.
  for (std::uint64_t episode = 0; count.steps < steps && episode < 16 + steps; ++episode) run->run_episode(episode, count);
  const std::uint64_t walks = (steps + kStepsPerFurtherWalk - kStepsForFirstWalk) / kStepsPerFurtherWalk;
  for (std::uint64_t walk = 0; walk < walks; ++walk) run->run_episode(kFirstLongWalk + walk, count);
  return count;
}

std::string reproducing_arguments(const StressResult& result, const StressFinding& finding, const StressPlan& plan) {
  const std::string place_flags =
      plan.by_patches ? " --patches" : fmt::format(" --scale {:g} --offset {:g}", result.variant.scale, result.variant.offset_extents);
  return fmt::format("--method {} --body {} --seed {}{} --friction-static {:g} --friction-dynamic {:g} --episode {}", plan.method.name,
                     result.body, plan.seed, place_flags, result.variant.friction_static, result.variant.friction_dynamic,
                     finding.episode) +
         (plan.method.smooth_layer > 0.0 ? fmt::format(" --layer {:g}", plan.method.smooth_layer) : "") +
         (plan.probe_share > 0.0 ? fmt::format(" --probe-share {:g}", plan.probe_share) : "") + (plan.no_seal ? " --no-seal" : "") +
         (plan.on_grid ? " --on-grid" : "");
}

// A dash for a fault that was not checked: 0 would say that there was none.
std::string cell_of(const StressCount& count, std::size_t fault) {
  return count.covered[fault] ? std::to_string(count.faults[fault]) : "-";
}

std::string legend() {
  std::string text = "Numbers of steps; -: not checked there.\n";
  for (std::size_t i = 0; i < kFaultCount; ++i) {
    const auto fault = static_cast<StressFault>(i);
    text += fmt::format("  {:<15} {}\n", name_of(fault), meaning_of(fault));
  }
  return text;
}

}  // namespace

Result<std::vector<StressResult>> run_episode(const std::vector<StressBody>& bodies, const StressPlan& plan, std::uint64_t episode) {
  std::vector<StressResult> results;
  for (const StressBody& body : bodies) {
    for (const StressVariant& variant : plan.variants) {
      auto run = make_run(body, plan, variant);
      if (!run) return tl::unexpected(run.error());
      StressResult result{body.name, variant, {}};
      run->run_episode(episode, result.count);
      results.push_back(std::move(result));
    }
  }
  return results;
}

std::vector<StressVariant> standard_variants() {
  std::vector<StressVariant> variants;
  for (const double scale : {1.0, 1e-6, 1e-3, 1e3, 1e6}) variants.push_back({.scale = scale});
  for (const double offset : {10.0, 1e3, 1e6}) variants.push_back({.offset_extents = offset});
  variants.push_back({.friction_static = 0.5, .friction_dynamic = 0.4});
  return variants;
}

std::vector<StressVariant> patch_variants() { return {{}, {.friction_static = 0.5, .friction_dynamic = 0.4}}; }

Result<std::vector<StressResult>> run_stress(const std::vector<StressBody>& bodies, const StressPlan& plan,
                                             const std::function<void(const StressResult&)>& progress) {
  const std::size_t jobs = bodies.size() * plan.variants.size();
  std::vector<StressResult> results(jobs);
  const std::uint64_t steps = std::max<std::uint64_t>(1, plan.steps / std::max<std::size_t>(1, plan.variants.size()));
  std::atomic<std::size_t> next{0};
  std::mutex mutex;
  std::optional<Error> run_error;
  auto work = [&] {
    for (std::size_t i = next++; i < jobs; i = next++) {
      const StressBody& body = bodies[i / plan.variants.size()];
      const StressVariant& variant = plan.variants[i % plan.variants.size()];
      auto count = run_one(body, plan, variant, steps);
      const std::scoped_lock lock(mutex);
      if (!count) {
        run_error = count.error();
        return;
      }
      results[i] = {body.name, variant, std::move(*count)};
      progress(results[i]);
    }
  };
  std::vector<std::thread> pool;
  for (unsigned i = 1; i < plan.threads; ++i) pool.push_back(start_thread(work));
  work();
  for (std::thread& thread : pool) thread.join();
  if (run_error) return tl::unexpected(*run_error);
  return results;
}

StressCount sum_of(const std::vector<StressResult>& results) {
  StressCount sum;
  for (const StressResult& result : results) sum.add(result.count);
  return sum;
}

std::string to_text(const std::vector<StressResult>& results, const StressPlan& plan) {
  std::string text = fmt::format("{:<20}{:>12}{:>12}{:>10}{:>9}", "body", "steps", "contact", "compared", "carried");
  for (std::size_t fault = 0; fault < kFaultCount; ++fault) text += fmt::format("{:>15}", name_of(static_cast<StressFault>(fault)));
  text += '\n';
  auto line = [&](const std::string& name, const StressCount& count) {
    text += fmt::format("{:<20}{:>12}{:>12}{:>10}{:>9}", name, count.steps, count.contact_steps, count.compared_steps, count.carried_steps);
    for (std::size_t fault = 0; fault < kFaultCount; ++fault) text += fmt::format("{:>15}", cell_of(count, fault));
    text += '\n';
  };
  std::vector<std::string> order;
  std::map<std::string, StressCount> sums;
  for (const StressResult& result : results) {
    if (!sums.contains(result.body)) order.push_back(result.body);
    sums[result.body].add(result.count);
  }
  for (const std::string& body : order) line(body, sums[body]);
  line("all", sum_of(results));
  text += legend();
  for (const StressResult& result : results) {
    for (const StressFinding& finding : result.count.findings) {
      text += fmt::format("{} in {} at step {} ({:.3g} extents): hapton stress {}\n", name_of(finding.fault), name_of(finding.motion),
                          finding.step, finding.size, reproducing_arguments(result, finding, plan));
    }
  }
  return text;
}

std::string to_json(const std::vector<StressResult>& results, const StressPlan& plan) {
  const MachineInfo machine = read_machine_info();
  Json json{{"schema", "hapton.stress/2"},
            {"method", plan.method.name},
            {"smooth_layer", plan.method.smooth_layer},
            {"by_patches", plan.by_patches},
            {"on_grid", plan.on_grid},
            {"seed", plan.seed},
            {"machine",
             {{"host", machine.host},
              {"cpu", machine.cpu},
              {"cpu_count", machine.cpu_count},
              {"compiler", machine.compiler},
              {"build", machine.build}}},
            {"faults", sum_of(results).total_faults()},
            {"results", Json::array()}};
  for (const StressResult& result : results) {
    Json entry{{"body", result.body},
               {"scale", result.variant.scale},
               {"offset_extents", result.variant.offset_extents},
               {"friction_static", result.variant.friction_static},
               {"friction_dynamic", result.variant.friction_dynamic},
               {"steps", result.count.steps},
               {"contact_steps", result.count.contact_steps},
               {"episodes", result.count.episodes},
               {"compared_steps", result.count.compared_steps},
               {"carried_steps", result.count.carried_steps}};
    for (std::size_t fault = 0; fault < kFaultCount; ++fault)
      entry[std::string(name_of(static_cast<StressFault>(fault)))] =
          result.count.covered[fault] ? Json(result.count.faults[fault]) : Json(nullptr);
    entry["findings"] = Json::array();
    for (const StressFinding& finding : result.count.findings) {
      entry["findings"].push_back({{"fault", name_of(finding.fault)},
                                   {"motion", name_of(finding.motion)},
                                   {"episode", finding.episode},
                                   {"step", finding.step},
                                   {"size_extents", finding.size},
                                   {"again", "hapton stress " + reproducing_arguments(result, finding, plan)}});
    }
    json["results"].push_back(std::move(entry));
  }
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace hapton
