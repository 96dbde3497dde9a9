#include "tools/bench/remote_grid.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <utility>

#include "closed_loop/stability.h"
#include "core/geometry/mesh_measures.h"

namespace hapton {
namespace {

// The simulation goes on after the hand has left, until the last late force has arrived.
SlidePlan plan_of(const RemoteGrid& grid, std::uint64_t seed, double speed_m_per_s, double round_trip_s) {
  return {.seed = seed, .speed_m_per_s = speed_m_per_s, .after_s = 0.5 + 1.5 * round_trip_s + 2.0 * grid.jitter_s};
}

// Measures every method along one path over one network.
Result<void> measure_path(const RemoteGrid& grid, const RemoteScene& scene, const SlidePath& path, const RemoteKey& key,
                          std::vector<RemoteRow>& rows) {
  RemoteRow row;
  static_cast<RemoteKey&>(row) = key;
  row.method = find_remote_method("local");
  const auto zero_delay = run_closed_loop(scene, path, grid.device, make_remote_case(grid, row), nullptr);
  if (!zero_delay) return tl::unexpected(zero_delay.error());
  for (const RemoteMethod* method : grid.methods) {
    row.method = method;
    const RemoteCase remote_case = make_remote_case(grid, row);
    auto touch = run_prescribed(scene, path, grid.device, remote_case);
    if (!touch) return tl::unexpected(touch.error());
    auto loop = run_closed_loop(scene, path, grid.device, remote_case, &zero_delay->p_WD);
    if (!loop) return tl::unexpected(loop.error());
    row.touch = std::move(*touch);
    row.loop = std::move(*loop);
    row.touch.rows.clear();
    row.loop.p_WD.clear();
    rows.push_back(row);
  }
  return {};
}

Result<void> measure_mesh(const RemoteGrid& grid, const BenchMesh& mesh, const std::function<void(const std::string&)>& progress,
                          std::vector<RemoteRow>& rows) {
  const auto scene = make_centred_scene(grid, mesh);
  if (!scene) return tl::unexpected(scene.error());
  return for_each_remote_path(grid, *scene, mesh.name, [&](const SlidePath& path, const RemoteKey& key) {
    auto done = measure_path(grid, *scene, path, key, rows);
    if (done) progress(describe(key));
    return done;
  });
}

Result<void> measure_walls(const RemoteGrid& grid, const std::function<void(const std::string&)>& progress,
                           std::vector<RemoteWall>& walls) {
  const AxisPlant plant = make_axis_plant(grid.device.model, grid.device.hand);
  for (const double round_trip_s : grid.round_trips_s) {
    const double stable_n_per_m = find_stable_stiffness(SampledPlant(plant, kRemotePeriodS, round_trip_s), 0.0).value;
    for (const double loss : grid.losses) {
      for (const RemoteMethod* method : grid.methods) {
        const auto rest_stiffness =
            find_rest_stiffness_of(grid.device, make_remote_case(grid, {method, "", grid.seed, 0.0, round_trip_s, loss}), kMaxWallNPerM);
        if (!rest_stiffness) return tl::unexpected(rest_stiffness.error());
        walls.push_back({method, round_trip_s, loss, *rest_stiffness, stable_n_per_m});
      }
      progress(fmt::format("walls, {:g} ms, loss {:g} %", 1e3 * round_trip_s, 100.0 * loss));
    }
  }
  return {};
}

}  // namespace

// Moves the middle of the mesh to the origin, since the middle of the device's workspace is there.
Result<RemoteScene> make_centred_scene(const RemoteGrid& grid, const BenchMesh& mesh) {
  TriangleMesh moved = *mesh.mesh;
  const Vec3 centre = compute_bounds(moved).centre();
  for (Vec3& vertex : moved.vertices) vertex -= centre;
  return make_remote_scene(std::make_shared<const TriangleMesh>(std::move(moved)), {.stiffness_n_per_m = grid.stiffness_n_per_m});
}

RemoteCase make_remote_case(const RemoteGrid& grid, const RemoteKey& key) {
  return {key.method, RemoteNetwork::of(key.round_trip_s, key.loss, grid.jitter_s, key.seed), key.round_trip_s, grid.settings,
          grid.stall_s};
}

std::string describe(const RemoteKey& key) {
  return fmt::format("{}{}, seed {}, {:g} mm/s, {:g} ms, loss {:g} %", key.mesh,
                     key.method != nullptr ? fmt::format(", {}", key.method->name) : "", key.seed, 1e3 * key.speed_m_per_s,
                     1e3 * key.round_trip_s, 100.0 * key.loss);
}

Result<void> for_each_remote_path(const RemoteGrid& grid, const RemoteScene& scene, const std::string& mesh, const UseRemotePath& use) {
  for (std::uint64_t seed = grid.seed; seed < grid.seed + grid.seeds; ++seed) {
    for (const double speed : grid.speeds_m_per_s) {
      for (const double round_trip_s : grid.round_trips_s) {
        const auto path = make_slide_path(*scene.mesh, *scene.zero_delay_method, plan_of(grid, seed, speed, round_trip_s));
        if (!path) return fail("{}: {}", mesh, path.error().what);
        for (const double loss : grid.losses) {
          if (auto done = use(*path, {nullptr, mesh, seed, speed, round_trip_s, loss}); !done) return done;
        }
      }
    }
  }
  return {};
}

Result<RemoteResults> measure_remote(const RemoteGrid& grid, const std::function<void(const std::string&)>& progress) {
  RemoteResults results;
  for (const std::string& mesh_spec : grid.meshes) {
    const auto mesh = make_bench_mesh(mesh_spec, grid.mesh_folder);
    if (!mesh) return tl::unexpected(mesh.error());
    if (auto done = measure_mesh(grid, *mesh, progress, results.rows); !done) return tl::unexpected(done.error());
  }
  if (!grid.has_walls) return results;
  if (auto done = measure_walls(grid, progress, results.walls); !done) return tl::unexpected(done.error());
  return results;
}

Result<std::string> trace_remote(const RemoteGrid& grid) {
  const auto mesh = make_bench_mesh(grid.meshes.front(), grid.mesh_folder);
  if (!mesh) return tl::unexpected(mesh.error());
  const auto scene = make_centred_scene(grid, *mesh);
  if (!scene) return tl::unexpected(scene.error());
  const double speed = grid.speeds_m_per_s.front();
  const double round_trip_s = grid.round_trips_s.front();
  const double loss = grid.losses.front();
  SlidePlan plan = plan_of(grid, grid.seed, speed, round_trip_s);
  // Shorter than in a measurement, so that a plot of the trace shows single periods.
  plan.slide_s = 2.0;
  plan.rest_s = 0.3;
  const auto path = make_slide_path(*scene->mesh, *scene->zero_delay_method, plan);
  if (!path) return tl::unexpected(path.error());
  std::string columns = "t_s,x_m,y_m,z_m,fx_zero_delay_n,fy_zero_delay_n,fz_zero_delay_n";
  std::vector<std::vector<ForceRow>> traces;
  for (const RemoteMethod* method : grid.methods) {
    auto touch =
        run_prescribed(*scene, *path, grid.device, make_remote_case(grid, {method, mesh->name, grid.seed, speed, round_trip_s, loss}));
    if (!touch) return tl::unexpected(touch.error());
    traces.push_back(std::move(touch->rows));
    std::string name(method->name);
    for (char& c : name) c = c == '-' ? '_' : c;
    columns += fmt::format(",fx_{0}_n,fy_{0}_n,fz_{0}_n", name);
  }
  std::string csv = fmt::format(
      "# hapton bench remote: {} scaled to 100 mm, {:g} N/m, {:g} mm/s, round trip {:g} ms, jitter {:g} ms, loss {:g} % each way, seed "
      "{}\n{}\n",
      mesh->name, grid.stiffness_n_per_m, 1e3 * speed, 1e3 * round_trip_s, 1e3 * grid.jitter_s, 100.0 * loss, grid.seed, columns);
  const auto add = [&](const Vec3& v, int digits) {
    // Writes 0 in place of "-0.0000".
    for (int k = 0; k < 3; ++k)
      fmt::format_to(std::back_inserter(csv), ",{:.{}f}", std::fabs(v[k]) < 0.5 * std::pow(10.0, -digits) ? 0.0 : v[k], digits);
  };
  for (std::size_t i = 0; i < path->rows.size(); ++i) {
    fmt::format_to(std::back_inserter(csv), "{:.3f}", kRemotePeriodS * static_cast<double>(i));
    add(path->rows[i].device_m(), 6);
    add(traces.front()[i].zero_delay_n, 4);
    for (const std::vector<ForceRow>& trace : traces) add(trace[i].force_n, 4);
    csv += '\n';
  }
  return csv;
}

}  // namespace hapton
