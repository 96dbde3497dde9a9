#include <fmt/core.h>

#include <array>
#include <cstddef>
#include <cstdio>
#include <iterator>
#include <memory>
#include <string>
#include <string_view>

#include "core/geometry/mesh_measures.h"
#include "runtime/atomic_file.h"
#include "runtime/writable_path.h"
#include "tools/commands.h"
#include "tools/mesh_choice.h"
#include "tools/session/ply_writer.h"
#include "tools/session/trajectory.h"

namespace hapton {
namespace {

struct TrajectoryOptions {
  MeshChoice mesh;
  std::string kind = "slide";
  std::string out;
  std::string mesh_out;
  TrajectorySettings settings;
};

std::string to_csv(const TouchTrajectory& made, const TrajectoryOptions& options) {
  std::string text = fmt::format("# hapton trajectory: {} over {}, seed {}, reset every {} rows\nt_s,x_m,y_m,z_m\n", options.kind,
                                 name_of(options.mesh), options.settings.seed, made.reset_every);
  for (std::size_t i = 0; i < made.p_SD.size(); ++i) {
    const Vec3& p = made.p_SD[i];
    fmt::format_to(std::back_inserter(text), "{:.6f},{:.17g},{:.17g},{:.17g}\n", static_cast<double>(i) / options.settings.rate_hz, p.x(),
                   p.y(), p.z());
  }
  return text;
}

Result<void> make(const TrajectoryOptions& options) {
  const auto differ = check_different_outputs({{"--out", options.out}, {"--mesh-out", options.mesh_out}});
  if (!differ) return differ;
  const auto mesh = make_mesh(options.mesh);
  if (!mesh) return tl::unexpected(mesh.error());
  const auto made = make_trajectory(options.kind, *mesh, options.settings);
  if (!made) return tl::unexpected(made.error());
  if (!options.mesh_out.empty()) {
    const auto written = write_ply(options.mesh_out, *mesh);
    if (!written) return written;
  }
  fmt::print("trajectory: {} rows of {} over {} ({} triangles, longest side {:.6g} m), seed {}, reset every {} rows\n", made->p_SD.size(),
             options.kind, name_of(options.mesh), mesh->triangles.size(), compute_bounds(*mesh).extent(), options.settings.seed,
             made->reset_every);
  return write_file_atomically(options.out, to_csv(*made, options));
}

}  // namespace

void add_trajectory_command(CommandLine app, int& exit_code) {
  auto options = std::make_shared<TrajectoryOptions>();
  const CommandLine command = app.add_subcommand("trajectory", "Generate a device trajectory over a mesh, for replay");
  add_mesh_options(command, options->mesh);
  command.add_option("--kind", options->kind, "One of: " + trajectory_kinds()).one_of_names(trajectory_kinds()).shows_default();
  command.add_option("--seed", options->settings.seed, "Seed of every random choice").shows_default();
  command.add_option("--rows", options->settings.rows, "Number of steps").between(1, 100'000'000).shows_default();
  command.add_option("--rate", options->settings.rate_hz, "Steps a second").between(1.0, 1e6).shows_default();
  command.add_option("--out", options->out, "CSV to write").file_to_write().required();
  command.add_option("--mesh-out", options->mesh_out, "Also write the mesh, scaled, as PLY in metres").file_to_write();
  command.on_run([options, &exit_code] {
    const auto done = make(*options);
    if (!done) fmt::print(stderr, "hapton trajectory: {}\n", done.error().what);
    exit_code = done ? 0 : 1;
  });
}

}  // namespace hapton
