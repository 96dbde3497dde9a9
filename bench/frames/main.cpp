// frames_bench: measures the frames per second of vision_node's view and of a plain VTK program (docs/benchmarks.md).
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <fmt/core.h>

#include <CLI/CLI.hpp>

#include "bench/frames/frames_run.h"
#include "core/geometry/mesh_shapes.h"
#include "runtime/atomic_file.h"
#include "runtime/config.h"
#include "runtime/flag_checks.h"
#include "runtime/log.h"
#include "scene/scene_file.h"

namespace {

using namespace hapton;

// Loads the first object of a mesh file, fitted to the workspace, its cracks not closed, as vision_node draws it. `bumpy` makes a ball with
// a radius of 70 mm and waves of a quarter of that, which has more triangles than any mesh of the repository. Error: see load_scene.
Result<FramesMesh> load_mesh(const std::string& which) {
  if (which == "bumpy") return FramesMesh{"bumpy_1.3M", std::make_shared<TriangleMesh>(make_bumpy_sphere(0.07, 0.25, 1'000'000, 1))};
  auto scene = load_scene(which, {.sealing = CrackSealing::off, .fit = MeshFit::workspace});
  if (!scene) return tl::unexpected(scene.error());
  return FramesMesh{std::filesystem::path(which).stem().string(), scene->objects.front().mesh};
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::string> meshes = {"meshes/car_front_3300.obj", "meshes/nefertiti_70k.ply", "bumpy"};
  FramesSettings settings;
  std::filesystem::path out;
  CLI::App app{"Frames a second of vision_node's view beside a plain VTK program, both on the same mesh in the same run.", "frames_bench"};
  app.add_option("--mesh", meshes, "Mesh files, or bumpy: a generated one of 1,310,720 triangles")->capture_default_str();
  app.add_option("--frames", settings.frames, "Frames of each program and mesh")->check(CLI::Range(1, 100'000))->capture_default_str();
  app.add_flag("--offscreen", settings.offscreen, "No windows; an X display is still needed");
  app.add_option("--out", out, "Folder for frames.csv and frames.txt")->check(folder_to_write());
  if (const auto code = parse_command_line(app, argc, argv)) return *code;
  std::vector<FramesRow> rows;
  for (const std::string& which : meshes) {
    const auto mesh = load_mesh(which);
    const auto row = mesh ? run_frames(*mesh, settings) : tl::unexpected(mesh.error());
    if (!row) {
      log_error("{}", row.error().what);
      return 1;
    }
    rows.push_back(*row);
  }
  double load_average = 0.0;  // of the last minute: other running programs lower all rates
  const bool is_known = getloadavg(&load_average, 1) == 1;
  const std::string text = describe_frames(rows) + (is_known ? fmt::format("load {:.1f}\n", load_average) : "");
  fmt::print("{}", text);
  if (out.empty()) return 0;
  for (const auto& [name, content] : {std::pair("frames.txt", text), std::pair("frames.csv", frames_csv(rows))}) {
    if (const auto written = write_file_atomically(out / name, content); !written) {
      log_error("{}", written.error().what);
      return 1;
    }
  }
  return 0;
}
