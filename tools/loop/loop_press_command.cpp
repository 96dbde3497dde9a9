#include <fmt/core.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <vector>

#include "closed_loop/passivity_stage.h"
#include "closed_loop/prescribed_motion.h"
#include "closed_loop/press.h"
#include "closed_loop/touch_wall.h"
#include "runtime/atomic_file.h"
#include "runtime/writable_path.h"
#include "tools/commands.h"
#include "tools/loop/loop_flags.h"
#include "tools/milliseconds.h"

namespace hapton {
namespace {

struct PressOptions {
  LoopFlags loop;
  double rate_hz = 1000.0;
  double delay_ms = 0.0;
  double jitter_ms = 0.0;
  LinkFaults link;  // loss and reorder, the same in both directions
  double stiffness_n_per_m = 1000.0;
  double damping_ns_per_m = 0.0;
  PressPlan plan;
  std::string gate = "newest";
  std::uint64_t seed = 1;
  bool is_passive = false;
  bool is_mesh = false;
  bool json = false;
  bool impedance = false;
  std::filesystem::path csv;
  std::filesystem::path spectrum;
};

constexpr double kImpedanceHz[] = {1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0};
constexpr int kImpedancePeriods = 40;  // of each frequency; more average more jitter and loss, and take longer

// The force law, the settings of everything between it and the motors, and the servo period.
struct PressSetup {
  std::unique_ptr<ForceLaw> law;
  ForceChain::Options chain;
  std::int64_t period_ns = 0;
};

Result<PressSetup> make_press_setup(const PressOptions& options, const NamedLoop& loop) {
  PressSetup setup;
  setup.period_ns = ms_to_ns(1e3 / options.rate_hz);
  if (options.is_mesh) {
    auto wall = make_touch_wall(options.stiffness_n_per_m, options.damping_ns_per_m);
    if (!wall) return tl::unexpected(wall.error());
    setup.law = std::move(*wall);
  } else {
    setup.law = std::make_unique<WallLaw>(
        WallLaw::Wall{.stiffness_n_per_m = options.stiffness_n_per_m, .damping_ns_per_m = options.damping_ns_per_m});
  }
  setup.chain = {.encoder_step_m = loop.device_model.encoder_step_m, .max_force_n = loop.device_model.max_force_n, .seed = options.seed};
  setup.chain.to_law = options.link;
  setup.chain.to_law.jitter_ns = ms_to_ns(options.jitter_ms);
  setup.chain.from_law = setup.chain.to_law;
  setup.chain.to_law.delay_ns = ms_to_ns(0.5 * options.delay_ms);
  setup.chain.from_law.delay_ns = ms_to_ns(options.delay_ms) - setup.chain.to_law.delay_ns;
  setup.chain.limits = loop.limits;
  if (options.gate == "filter") setup.chain.gate = ForceChain::Gate::filter;
  if (options.gate == "governor") setup.chain.gate = ForceChain::Gate::governor;
  if (options.gate == "governor" && !(loop.limits.max_force_n > 0.0))
    return fail("--gate governor needs a device with limits; give --device");
  return setup;
}

PassivityStage::Options passivity_options(const DeviceModel& device, double rate_hz) {
  return {.device = {.mass_kg = device.mass_kg, .position_step_m = device.encoder_step_m},
          .most_damping_ns_per_m = PassivityStage::renderable_damping_ns_per_m(device.mass_kg, rate_hz),
          .max_force_n = device.max_force_n};
}

std::string to_csv(const std::vector<LoopRow>& rows) {
  std::string csv = "t_s,x_m,force_n,motor_j,lost_j\n";
  for (const LoopRow& row : rows) {
    csv += fmt::format("{:.9f},{},{},{},{}\n", 1e-9 * static_cast<double>(row.time_ns), row.p_WD.x(), row.force_n.x(), row.motor_j,
                       row.lost_j);
  }
  return csv;
}

std::string to_csv(const std::vector<SpectrumPeak>& spectrum) {
  std::string csv = "frequency_hz,force_n\n";
  for (const SpectrumPeak& line : spectrum) csv += fmt::format("{},{}\n", line.frequency_hz, line.amplitude);
  return csv;
}

nlohmann::ordered_json number(double value) { return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(); }

// How long it takes until forces arrive, whichever datagrams are lost.
std::int64_t find_settle_ns(const PressOptions& options) {
  constexpr double kSamples = 50.0;  // beside the delays, for replies that are lost in a row; a free choice
  return ms_to_ns(options.delay_ms + 2.0 * options.jitter_ms + 1e3 * kSamples / options.rate_hz);
}

// Measures the rendered impedance with a motion about the pressed depth, by a fifth of that depth, so that contact is never lost.
Result<nlohmann::ordered_json> measure_impedance(const PressOptions& options, const NamedLoop& loop) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  const double depth_m = options.plan.press_n / options.stiffness_n_per_m;
  for (const double frequency_hz : kImpedanceHz) {
    if (frequency_hz > 0.4 * options.rate_hz) break;  // too near half the servo rate
    auto setup = make_press_setup(options, loop);
    if (!setup) return tl::unexpected(setup.error());
    setup->chain.gate = ForceChain::Gate::newest;
    ForceChain chain(*setup->law, setup->chain);
    const auto stiffness = measure_rendered_stiffness(chain, setup->period_ns, frequency_hz, -depth_m, 0.2 * depth_m,
                                                      find_settle_ns(options), kImpedancePeriods);
    list.push_back({{"frequency_hz", frequency_hz},
                    {"stiffness_n_per_m", stiffness.real()},
                    {"damping_ns_per_m", stiffness.imag() / (2.0 * std::numbers::pi * frequency_hz)}});
  }
  return list;
}

nlohmann::ordered_json to_json(const PressOptions& options, const NamedLoop& loop, const PressMeasures& press, const ForceChain& chain) {
  return {{"schema", "hapton.loop.press/1"},
          {"inputs",
           {{"device", loop.device},
            {"hand", loop.hand},
            {"rate_hz", options.rate_hz},
            {"delay_ms", options.delay_ms},
            {"jitter_ms", options.jitter_ms},
            {"loss", options.link.loss},
            {"reorder", options.link.reorder},
            {"stiffness_n_per_m", options.stiffness_n_per_m},
            {"damping_ns_per_m", options.damping_ns_per_m},
            {"press_n", options.plan.press_n},
            {"gate", options.gate},
            {"passivity", options.is_passive},
            {"wall", options.is_mesh ? "mesh" : "plane"},
            {"seed", options.seed}}},
          {"bounded", press.is_bounded},
          {"contact", press.has_contact},
          {"depth_m", press.depth_m},
          {"overshoot", press.overshoot},
          {"settling_s", number(press.settling_s)},
          {"limit_cycle_m", press.limit_cycle_m},
          {"buzz_hz", press.buzz_hz},
          {"buzz_n", press.buzz_n},
          {"wall_j", press.wall_j},
          {"generated_j", press.generated_j},
          {"most_generated_j", press.most_generated_j},
          {"samples", chain.counters().samples},
          {"lost", chain.counters().lost},
          {"overtaken", chain.counters().overtaken}};
}

constexpr double kMinBuzzN = 1e-9;  // rounding gives spectral lines of 1e-27 N; no hand feels a millionth of a millinewton

void print_text(const NamedLoop& loop, const PressMeasures& press, const nlohmann::ordered_json& impedance) {
  fmt::print("{}: motion {}\n", loop.title(), press.is_bounded ? "bounded" : "DIVERGED");
  const std::string settling =
      std::isfinite(press.settling_s) ? fmt::format("settled after {:.4g} ms", 1e3 * press.settling_s) : "never settled";
  if (!press.has_contact) fmt::print("no force acted before the release\n");
  fmt::print("depth {:.4g} mm, overshoot {:.3g} %, {}, limit cycle {:.4g} um\n", 1e3 * press.depth_m, 100.0 * press.overshoot, settling,
             1e6 * press.limit_cycle_m);
  if (press.buzz_n < kMinBuzzN) {
    fmt::print("no buzz\n");
  } else {
    fmt::print("buzz {:.4g} N at {:.4g} Hz\n", press.buzz_n, press.buzz_hz);
  }
  fmt::print("energy over press and release: from the wall {:.4g} mJ, after the device's losses {:.4g} mJ (above zero: generated)\n",
             1e3 * press.wall_j, 1e3 * press.generated_j);
  for (const auto& point : impedance) {
    fmt::print("rendered at {:5g} Hz: {:9.4g} N/m, {:9.4g} Ns/m\n", point["frequency_hz"].get<double>(),
               point["stiffness_n_per_m"].get<double>(), point["damping_ns_per_m"].get<double>());
  }
}

constexpr double kDeepestM = 10.0;  // a deeper press is a mistake in its arguments; a free choice

Result<void> run(const PressOptions& options) {
  const auto differ = check_different_outputs({{"--csv", options.csv}, {"--spectrum", options.spectrum}});
  if (!differ) return differ;
  const auto loops = loops_of(options.loop);
  if (!loops) return tl::unexpected(loops.error());
  if (loops->size() != 1) return fail("a press is of one device and one hand, not of {} pairs; name one of each", loops->size());
  const NamedLoop& loop = loops->front();
  auto setup = make_press_setup(options, loop);
  if (!setup) return tl::unexpected(setup.error());
  PassivityStage passivity(passivity_options(loop.device_model, options.rate_hz));
  if (options.is_passive) setup->chain.stage = &passivity;
  ForceChain chain(*setup->law, setup->chain);
  PressPlan plan = options.plan;
  plan.wall_n_per_m = options.stiffness_n_per_m;
  plan.after_s += 1e-3 * (options.delay_ms + 2.0 * options.jitter_ms);
  const double depth_m = compute_press_depth_m(loop.hand_model, plan);
  if (!(depth_m <= kDeepestM)) {
    return fail("to press with {:g} N the hand would move by {:g} m, more than {:g} m; give less force, or a stiffer hand or wall",
                plan.press_n, depth_m, kDeepestM);
  }
  const PressPath path = make_press_path(loop.hand_model, plan);
  LoopSimulation simulation(chain, {.device = loop.device_model,
                                    .hand = loop.hand_model,
                                    .axes = options.is_mesh ? 3 : 1,
                                    .period_ns = setup->period_ns,
                                    .path = path.path,
                                    .start_m = path.start_m});
  std::vector<LoopRow> rows;
  const bool is_bounded = simulation.run_until(path.end_ns, &rows);
  const PressMeasures press = measure_press(rows, path, setup->period_ns, loop.device_model.encoder_step_m, is_bounded);
  nlohmann::ordered_json impedance = nlohmann::ordered_json::array();
  if (options.impedance) {
    auto measured = measure_impedance(options, loop);
    if (!measured) return tl::unexpected(measured.error());
    impedance = *measured;
  }
  if (options.json) {
    nlohmann::ordered_json json = to_json(options, loop, press, chain);
    if (options.impedance) json["rendered"] = impedance;
    if (options.is_passive) {
      json["passivity"] = {{"acted", passivity.acted()}, {"worst_debt_j", passivity.worst_debt_j()}};
    }
    fmt::print("{}\n", json.dump(2));
  } else {
    print_text(loop, press, impedance);
  }
  if (!options.spectrum.empty()) {
    auto written = write_file_atomically(options.spectrum, to_csv(compute_buzz_spectrum(rows, path, setup->period_ns)));
    if (!written) return written;
  }
  return options.csv.empty() ? Result<void>() : write_file_atomically(options.csv, to_csv(rows));
}

}  // namespace

void add_loop_press_command(CommandLine loop, int& exit_code) {
  auto options = std::make_shared<PressOptions>();
  const CommandLine command = loop.add_subcommand("press", "Simulate a press and release: limit cycle, buzz, settling, overshoot, energy");
  add_loop_flags(command, options->loop, false);
  command.add_option("--stiffness", options->stiffness_n_per_m, "Stiffness of the wall, N/m")
      .positive("N/m")
      .between(0.0, 1e9)
      .shows_default();
  command.add_option("--damping", options->damping_ns_per_m, "Damping of the wall, Ns/m").between(0.0, 1e6).shows_default();
  command.add_option("--press", options->plan.press_n, "Force that the hand holds, N")
      .positive("newtons")
      .between(0.0, 1e4)
      .shows_default();
  command.add_option("--speed", options->plan.speed_m_per_s, "Speed at which the hand approaches, m/s").between(1e-3, 10.0).shows_default();
  command.add_option("--hold", options->plan.hold_s, "How long the hand holds this force, s").between(0.1, 1000.0).shows_default();
  command.add_option("--rate", options->rate_hz, "Servo rate, Hz").between(10.0, 1e6).shows_default();
  const CommandLine link = command.add_group("link", "Between device and force program");
  link.add_option("--delay", options->delay_ms, "From the sample to its force on the motors, ms").between(0.0, 10'000.0).shows_default();
  link.add_option("--jitter", options->jitter_ms, "Random extra delay each way, up to this, ms").between(0.0, 10'000.0).shows_default();
  link.add_option("--loss", options->link.loss, "Share of the datagrams lost each way").between(0.0, 0.99).shows_default();
  link.add_option("--reorder", options->link.reorder, "Share that is held back 2 ms each way").between(0.0, 1.0).shows_default();
  link.add_option("--seed", options->seed, "Seed of jitter, loss and reordering").shows_default();
  command
      .add_option("--gate", options->gate,
                  "Stage before the motors: newest (none: the newest force acts), or filter or governor, the stages of io_node")
      .one_of({"newest", "filter", "governor"})
      .shows_default();
  command.add_flag("--passivity", options->is_passive, "With the passivity controller before the motors");
  command.add_flag("--mesh", options->is_mesh, "The wall is a mesh, touched by the step of haptics_node");
  command.add_flag("--impedance", options->impedance, "Rendered stiffness and damping against frequency too");
  command.add_option("--csv", options->csv, "Write a line for each sample to this file").file_to_write();
  command
      .add_option("--spectrum", options->spectrum,
                  "Write the spectrum of the force in the second half of the hold to this file, a line for each frequency")
      .file_to_write();
  command.add_flag("--json", options->json, "Print JSON");
  command.on_run([options, &exit_code] {
    const auto done = run(*options);
    if (!done) fmt::print(stderr, "hapton loop press: {}\n", done.error().what);
    exit_code = done ? 0 : 1;
  });
}

}  // namespace hapton
