#include "tools/bench/remote_processes.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <optional>

#include "devices/model_a.h"
#include "runtime/atomic_file.h"
#include "runtime/realtime.h"
#include "runtime/trajectory_csv.h"
#include "scene/scene_file.h"
#include "tools/bench/remote_report.h"
#include "tools/child_process.h"
#include "tools/local_node.h"
#include "tools/session/ply_writer.h"
#include "tools/temporary_folder.h"

namespace hapton {
namespace {

// Free choices, all generous enough for a busy machine.
constexpr double kNodesJoinS = 2.0;       // time for the nodes to join, besides kJoinTrips round trips
constexpr double kJoinTrips = 8.0;        // round trips for joining, with lost datagrams
constexpr double kSceneTimeFactor = 1.5;  // time for sending the scene, as a multiple of the time that the simulation needs
constexpr double kGraceS = 20.0;          // time for the hub to write its report

// A mesh as a scene file for the programs, and the same scene for the comparison.
struct ProcessScene {
  std::filesystem::path file;
  RemoteScene simulated;                            // for the simulation
  std::shared_ptr<ForceMethod> whole_scene_method;  // the method on the whole scene without delay
};

Result<ProcessScene> make_process_scene(const std::filesystem::path& folder, const RemoteScene& simulated) {
  ProcessScene process_scene;
  process_scene.simulated = simulated;
  process_scene.file = folder / "scene.toml";
  if (auto written = write_ply(folder / "mesh.ply", *simulated.mesh); !written) return tl::unexpected(written.error());
  const auto written = write_file_atomically(
      process_scene.file,
      fmt::format("[[object]]\nmesh = \"mesh.ply\"\nunit = \"m\"\nmaterial = \"m\"\n\n[material.m]\nstiffness_n_per_m = {}\n",
                  simulated.stiffness_n_per_m));
  if (!written) return tl::unexpected(written.error());
  const auto scene = load_scene(process_scene.file);
  if (!scene) return tl::unexpected(scene.error());
  auto method = make_method({}, scene->touch_scene());
  if (!method) return tl::unexpected(method.error());
  process_scene.whole_scene_method = std::move(*method);
  return process_scene;
}

// The programs of one case. The destructor ends those that still run.
class ProcessRun {
 public:
  ProcessRun(const std::filesystem::path& folder, const std::filesystem::path& scene) : folder_(folder), scene_(scene) {}

  // Runs the programs until the hub has played the path.
  Result<void> play(const RemoteProcessRow& row, const RemoteGrid& grid, double seconds) {
    const auto hub = find_free_address();
    if (!hub) return tl::unexpected(hub.error());
    const double delay_ms = 0.5 * 1e3 * row.round_trip_s;  // each way
    auto relay = start_local_relay(folder_, *hub,
                                   {"--seed", fmt::format("{}", row.seed), "--delay-ms", fmt::format("{}", delay_ms), "--loss",
                                    fmt::format("{}", row.loss), "--jitter-ms", fmt::format("{}", 1e3 * grid.jitter_s)});
    if (!relay) return tl::unexpected(relay.error());
    relay_.emplace(std::move(relay->node));
    if (auto started = start_haptics(relay->address, grid); !started) return started;
    auto io = LocalNode::start(folder_, "io_node", find_own_folder() / "io_node", hub_arguments(*hub, row, grid));
    if (!io) return tl::unexpected(io.error());
    if (auto ended = io->wait_for_end(seconds + kGraceS); !ended) return ended;
    if (auto stopped = haptics_->stop(); !stopped) return stopped;
    return relay_->stop();
  }

  std::filesystem::path recording() const { return folder_ / "session.hapton"; }
  std::filesystem::path path() const { return folder_ / "path.csv"; }

 private:
  Result<void> start_haptics(const std::string& hub, const RemoteGrid& grid) {
    auto haptics = LocalNode::start(folder_, "haptics_node", find_own_folder() / "haptics_node",
                                    {"--hub", hub, "--scene", scene_.string(), "--build-at-once", "--cpu", cpu_, "--spin", "0",
                                     "--patch-bandwidth", fmt::format("{}", 1e-6 * grid.settings.patch_bits_per_s)});
    if (!haptics) return tl::unexpected(haptics.error());
    haptics_.emplace(std::move(*haptics));
    return haptics_->wait_for("ready");
  }

  std::vector<std::string> hub_arguments(const std::string& hub, const RemoteProcessRow& row, const RemoteGrid& grid) const {
    std::vector<std::string> arguments = {"--bind",       hub,
                                          "--device",     "replay",
                                          "--trajectory", path().string(),
                                          "--touch",      row.method->scheme == RemoteMethod::Scheme::patch ? "patch" : "remote",
                                          "--cpu",        cpu_,
                                          "--spin-reply", "0",
                                          "--out",        folder_.string(),
                                          "--record",     recording().string(),
                                          "--flight",     "off"};
    if (row.method->is_passive) {
      arguments.insert(arguments.end(), {"--passive-mass", fmt::format("{}", grid.device.model.mass_kg), "--passive-step",
                                         fmt::format("{}", grid.device.model.encoder_step_m)});
    }
    return arguments;
  }

  std::filesystem::path folder_;
  std::filesystem::path scene_;
  std::string cpu_ = fmt::format("{}", find_shared_cpu());
  std::optional<LocalNode> relay_;
  std::optional<LocalNode> haptics_;
};

// Time in free space before the path: until the nodes have joined and the scene near the path was sent.
double find_wait_s(const PrescribedTouch& simulated, const RemoteMethod& method, double round_trip_s) {
  const double scene_s = method.scheme == RemoteMethod::Scheme::patch ? kSceneTimeFactor * simulated.ready_s : 0.0;
  return kNodesJoinS + kJoinTrips * round_trip_s + scene_s;
}

std::string path_to_csv(const SlidePath& path, double wait_s) {
  std::vector<TrajectoryRow> rows = {{0.0, path.rows.front().device_m()}};
  for (std::size_t i = 0; i < path.rows.size(); ++i)
    rows.push_back({wait_s + kRemotePeriodS * static_cast<double>(i + 1), path.rows[i].device_m()});
  return positions_to_csv(rows);
}

// Pre: the key of the row (RemoteKey) is set, with its method.
Result<void> measure_run(const RemoteGrid& grid, const ProcessScene& scene, const SlidePath& path, const std::filesystem::path& folder,
                         RemoteProcessRow& row) {
  auto simulated = run_prescribed(scene.simulated, path, grid.device, make_remote_case(grid, row));
  if (!simulated) return tl::unexpected(simulated.error());
  row.simulated = std::move(*simulated);
  row.simulated.rows.clear();
  const double wait_s = find_wait_s(row.simulated, *row.method, row.round_trip_s);
  ProcessRun run(folder, scene.file);
  if (auto written = write_file_atomically(run.path(), path_to_csv(path, wait_s)); !written) return tl::unexpected(written.error());
  const double seconds = wait_s + kRemotePeriodS * static_cast<double>(path.rows.size());
  if (auto played = run.play(row, grid, seconds); !played) return tl::unexpected(played.error());
  const auto time_of_row = [&](std::size_t i) { return wait_s + kRemotePeriodS * static_cast<double>(i); };
  auto real = evaluate_recording(run.recording(), scene.whole_scene_method,
                                 {.from_s = time_of_row(path.first_sliding_row),
                                  .to_s = time_of_row(path.first_leaving_row),
                                  .period_s = kRemotePeriodS,
                                  .most_late_s = searched_delay_s(row.round_trip_s),
                                  .max_force_n = model_a::limits().max_force_n});
  if (!real) return tl::unexpected(real.error());
  row.real = *real;
  return {};
}

Result<void> measure_mesh(const RemoteGrid& grid, const std::string& mesh_spec, const std::function<void(const std::string&)>& progress,
                          std::vector<RemoteProcessRow>& rows) {
  const auto mesh = make_bench_mesh(mesh_spec, grid.mesh_folder);
  if (!mesh) return tl::unexpected(mesh.error());
  const auto centred = make_centred_scene(grid, *mesh);
  const auto folder = TemporaryFolder::make();
  if (!centred || !folder) return tl::unexpected(centred ? folder.error() : centred.error());
  const auto scene = make_process_scene(folder->path(), *centred);
  if (!scene) return tl::unexpected(scene.error());
  return for_each_remote_path(grid, *centred, mesh->name, [&](const SlidePath& path, const RemoteKey& key) -> Result<void> {
    for (const RemoteMethod* method : grid.methods) {
      RemoteProcessRow row;
      static_cast<RemoteKey&>(row) = key;
      row.method = method;
      if (auto done = measure_run(grid, *scene, path, folder->path(), row); !done) return fail("{}: {}", describe(row), done.error().what);
      progress(describe(row));
      rows.push_back(std::move(row));
    }
    return {};
  });
}

// A result of a run, as a column of the CSV and a key of the JSON.
struct ProcessFigure {
  const char* name;
  double (*value_of)(const RemoteProcessRow&);
};

constexpr ProcessFigure kProcessFigures[] = {
    {"force_error_rms", [](const RemoteProcessRow& r) { return r.real.force.error_rms; }},
    {"force_error_max_n", [](const RemoteProcessRow& r) { return r.real.force.error_max_n; }},
    {"direction_error_rms_deg", [](const RemoteProcessRow& r) { return r.real.force.direction_rms_deg; }},
    {"time_offset_ms", [](const RemoteProcessRow& r) { return 1e3 * r.real.force.time_offset_s; }},
    {"value_offset", [](const RemoteProcessRow& r) { return r.real.force.value_offset; }},
    {"falls", [](const RemoteProcessRow& r) { return static_cast<double>(r.real.force.falls); }},
    {"fall_s", [](const RemoteProcessRow& r) { return r.real.force.fall_s; }},
    {"contact_s", [](const RemoteProcessRow& r) { return r.real.force.contact_s; }},
    {"generated_mj", [](const RemoteProcessRow& r) { return 1e3 * r.real.force.generated_j; }},
    {"zero_delay_generated_mj", [](const RemoteProcessRow& r) { return 1e3 * r.real.force.zero_delay_generated_j; }},
    {"packets_up_per_s", [](const RemoteProcessRow& r) { return r.real.rates.packets_up; }},
    {"packets_down_per_s", [](const RemoteProcessRow& r) { return r.real.rates.packets_down; }},
    {"bytes_up_per_s", [](const RemoteProcessRow& r) { return r.real.rates.bytes_up; }},
    {"bytes_down_per_s", [](const RemoteProcessRow& r) { return r.real.rates.bytes_down; }},
    {"scene_kb", [](const RemoteProcessRow& r) { return r.real.scene_kb; }},
    {"ready_s", [](const RemoteProcessRow& r) { return r.real.ready_s; }},
    {"local_error_rms", [](const RemoteProcessRow& r) { return r.real.local_error_rms; }},
    {"local_error_max_n", [](const RemoteProcessRow& r) { return r.real.local_error_max_n; }},
    {"local_share", [](const RemoteProcessRow& r) { return r.real.local_share; }},
    {"cycles", [](const RemoteProcessRow& r) { return static_cast<double>(r.real.cycles); }},
    {"missed_cycles", [](const RemoteProcessRow& r) { return static_cast<double>(r.real.missed); }},
    {"simulated_force_error_rms", [](const RemoteProcessRow& r) { return r.simulated.force.error_rms; }},
    {"simulated_falls", [](const RemoteProcessRow& r) { return static_cast<double>(r.simulated.force.falls); }},
    {"simulated_packets_up_per_s", [](const RemoteProcessRow& r) { return r.simulated.rates.packets_up; }},
    {"simulated_packets_down_per_s", [](const RemoteProcessRow& r) { return r.simulated.rates.packets_down; }},
};

}  // namespace

bool is_implemented_by_programs(const RemoteMethod& method) noexcept {
  return method.scheme == RemoteMethod::Scheme::patch ||
         (method.scheme == RemoteMethod::Scheme::force && (method.has_governor || method.is_passive));
}

Result<std::vector<RemoteProcessRow>> measure_remote_processes(const RemoteGrid& grid,
                                                               const std::function<void(const std::string&)>& progress) {
  for (const RemoteMethod* method : grid.methods) {
    if (!is_implemented_by_programs(*method)) {
      return fail("--method {}: no program implements it; --processes supports remote, remote-passive, patch and patch-passive",
                  method->name);
    }
  }
  std::vector<RemoteProcessRow> rows;
  for (const std::string& mesh : grid.meshes) {
    if (auto done = measure_mesh(grid, mesh, progress, rows); !done) return tl::unexpected(done.error());
  }
  return rows;
}

std::string processes_to_text(const RemoteGrid& grid, const std::vector<RemoteProcessRow>& rows) {
  std::string text = fmt::format(
      "hub, relay and haptics node on this host; {:g} N/m; jitter {:g} ms. Error: of the force on the motors against the whole scene's, "
      "for "
      "the same sample; local: before the governor, where it was computed beside the device; simulated: of the same cell in simulated "
      "time.\n{:16}{:18}{:>5}{:>6}{:>7}{:>7}{:>13}{:>13}{:>13}{:>9}{:>11}{:>7}{:>9}{:>12}{:>12}{:>8}\n",
      grid.stiffness_n_per_m, 1e3 * grid.jitter_s, "method", "mesh", "seed", "mm/s", "ms", "loss %", "error RMS %", "local %",
      "simulated %", "max N", "direction", "falls", "given mJ", "packets/s", "kB/s", "missed");
  for (const RemoteProcessRow& row : rows) {
    const RecordedTouch& real = row.real;
    text += fmt::format("{:16}{:18}{:>5}{:>6g}{:>7g}{:>7g}{:>13.4f}{:>13.4f}{:>13.4f}{:>9.3f}{:>11.2f}{:>7}{:>9.2f}{:>12}{:>12}{:>8}\n",
                        row.method->name, row.mesh, row.seed, 1e3 * row.speed_m_per_s, 1e3 * row.round_trip_s, 100.0 * row.loss,
                        100.0 * real.force.error_rms, 100.0 * real.local_error_rms, 100.0 * row.simulated.force.error_rms,
                        real.force.error_max_n, real.force.direction_rms_deg, real.force.falls, 1e3 * real.force.generated_j,
                        fmt::format("{:.0f} {:.0f}", real.rates.packets_up, real.rates.packets_down),
                        fmt::format("{:.1f} {:.1f}", 1e-3 * real.rates.bytes_up, 1e-3 * real.rates.bytes_down), real.missed);
  }
  return text;
}

std::string processes_to_csv(const std::vector<RemoteProcessRow>& rows) {
  std::string csv = key_columns();
  for (const ProcessFigure& figure : kProcessFigures) csv += fmt::format(",{}", figure.name);
  csv += '\n';
  for (const RemoteProcessRow& row : rows) {
    csv += to_csv(row);
    for (const ProcessFigure& figure : kProcessFigures) csv += fmt::format(",{:.6g}", figure.value_of(row));
    csv += '\n';
  }
  return csv;
}

std::string processes_to_json(const RemoteGrid& grid, const std::vector<RemoteProcessRow>& rows) {
  nlohmann::ordered_json json = {
      {"schema", "hapton.bench.remote_processes/1"}, {"stiffness_n_per_m", grid.stiffness_n_per_m}, {"jitter_ms", 1e3 * grid.jitter_s}};
  json["runs"] = nlohmann::ordered_json::array();
  for (const RemoteProcessRow& row : rows) {
    nlohmann::ordered_json run = to_json(row);
    for (const ProcessFigure& figure : kProcessFigures) run[figure.name] = figure.value_of(row);
    json["runs"].push_back(std::move(run));
  }
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace hapton
