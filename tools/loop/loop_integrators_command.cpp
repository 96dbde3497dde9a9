#include <fmt/core.h>

#include <algorithm>
#include <cstdio>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "closed_loop/integrators.h"
#include "runtime/clock.h"
#include "tools/commands.h"
#include "tools/loop/loop_flags.h"

namespace hapton {
namespace {

struct IntegratorOptions {
  LoopFlags loop;
  double stiffness_n_per_m = 1000.0;
  int repeat = 5;
  bool json = false;
};

struct Row {
  Integrator integrator;
  std::int64_t step_ns;
  double worst_error_m;
  double us_per_s;  // computing time for each simulated second, the least of the repetitions
};

constexpr std::int64_t kStepsNs[] = {1'000'000, 500'000, 200'000, 100'000, 50'000, 20'000, 10'000, 5'000, 2'000};  // from 1 ms to 2 us
// All results are compared with Runge-Kutta, which is independent of the exact method, at this step, 20 times finer than the finest one.
constexpr std::int64_t kReferenceNs = 100;

class Comparison {
 public:
  Comparison(const IntegratorCase& press, int repeat)
      : press_(press), repeat_(repeat), reference_(run_press(press, Integrator::runge_kutta, kReferenceNs)) {}

  Row measure(Integrator integrator, std::int64_t step_ns) const {
    const SteadyClock clock;
    Row row{integrator, step_ns, 0.0, std::numeric_limits<double>::infinity()};
    for (int i = 0; i < repeat_; ++i) {
      const std::int64_t begin_ns = clock.now_ns();
      const std::vector<double> run = run_press(press_, integrator, step_ns);
      row.us_per_s = std::min(row.us_per_s, 1e-3 * static_cast<double>(clock.now_ns() - begin_ns) / press_.seconds);
      row.worst_error_m = worst_difference(run, reference_);
    }
    return row;
  }

 private:
  IntegratorCase press_;
  int repeat_;
  std::vector<double> reference_;
};

Result<void> run(const IntegratorOptions& options) {
  const auto loops = loops_of(options.loop);
  if (!loops) return tl::unexpected(loops.error());
  const NamedLoop& loop = loops->front();
  const Comparison comparison({.device = loop.device_model, .hand = loop.hand_model, .wall_n_per_m = options.stiffness_n_per_m},
                              options.repeat);
  std::vector<Row> rows = {comparison.measure(Integrator::exact, 1)};
  for (const Integrator integrator : {Integrator::runge_kutta, Integrator::semi_implicit_euler}) {
    for (const std::int64_t step_ns : kStepsNs) rows.push_back(comparison.measure(integrator, step_ns));
  }
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  if (!options.json) fmt::print("{:20} {:>10} {:>14} {:>18}\n", "integrator", "step us", "worst error m", "us a simulated s");
  for (const Row& row : rows) {
    const double step_us = 1e-3 * static_cast<double>(row.step_ns);
    if (options.json) {
      const bool is_finite = row.worst_error_m < std::numeric_limits<double>::infinity();
      list.push_back({{"integrator", to_string(row.integrator)},
                      {"step_us", step_us},
                      {"worst_error_m", is_finite ? nlohmann::ordered_json(row.worst_error_m) : nlohmann::ordered_json()},
                      {"us_per_simulated_s", row.us_per_s}});
    } else {
      fmt::print("{:20} {:>10g} {:>14.3g} {:>18.1f}\n", to_string(row.integrator), step_us, row.worst_error_m, row.us_per_s);
    }
  }
  if (options.json) {
    const nlohmann::ordered_json json = {{"schema", "hapton.loop.integrators/1"},
                                         {"device", loop.device},
                                         {"hand", loop.hand},
                                         {"stiffness_n_per_m", options.stiffness_n_per_m},
                                         {"reference", "runge_kutta_4 at 0.1 us"},
                                         {"rows", list}};
    fmt::print("{}\n", json.dump(2));
  } else {
    fmt::print("error: of the position at the samples of a press of {:g} N/m at 1 kHz, against runge_kutta_4 at 0.1 us\n",
               options.stiffness_n_per_m);
  }
  return {};
}

}  // namespace

void add_loop_integrators_command(CommandLine loop, int& exit_code) {
  auto options = std::make_shared<IntegratorOptions>();
  const CommandLine command =
      loop.add_subcommand("integrators", "Run time against error of this command's integrator and of two usual ones");
  add_loop_flags(command, options->loop, false);
  command.add_option("--stiffness", options->stiffness_n_per_m, "Stiffness of the wall, N/m")
      .positive("N/m")
      .between(0.0, 1e9)
      .shows_default();
  command.add_option("--repeat", options->repeat, "Number of runs; the fastest counts").between(1, 1000).shows_default();
  command.add_flag("--json", options->json, "Print JSON");
  command.on_run([options, &exit_code] {
    const auto done = run(*options);
    if (!done) fmt::print(stderr, "hapton loop integrators: {}\n", done.error().what);
    exit_code = done ? 0 : 1;
  });
}

}  // namespace hapton
