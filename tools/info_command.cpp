#include <cstdio>
#include <memory>
#include <optional>
#include <string>

#include "scene/mesh_report.h"
#include "scene/scene_report.h"
#include "scene/unit.h"
#include "tools/commands.h"

namespace hapton {
namespace {

struct InfoOptions {
  std::string file;
  std::string unit;
  bool json = false;
};

Result<std::string> describe_scene(const InfoOptions& options) {
  if (!options.unit.empty()) return fail("{}: a scene file names its units itself: leave --unit out", options.file);
  return make_scene_report(options.file).map([&](const SceneReport& report) { return options.json ? to_json(report) : to_text(report); });
}

Result<std::string> describe_mesh(const InfoOptions& options) {
  std::optional<Unit> unit;
  if (!options.unit.empty()) {
    const Result<Unit> parsed = parse_unit(options.unit);
    if (!parsed) return tl::unexpected(parsed.error());
    unit = *parsed;
  }
  return make_mesh_report(options.file, unit).map([&](const MeshReport& report) {
    return options.json ? to_json(report) : to_text(report);
  });
}

int run(const InfoOptions& options) {
  const Result<std::string> text = options.file.ends_with(".toml") ? describe_scene(options) : describe_mesh(options);
  if (!text) {
    std::fprintf(stderr, "hapton info: %s\n", text.error().what.c_str());
    return 1;
  }
  std::fputs(text->c_str(), stdout);
  return 0;
}

}  // namespace

void add_info_command(CommandLine app, int& exit_code) {
  auto options = std::make_shared<InfoOptions>();
  const CommandLine info = app.add_subcommand("info", "Show a mesh's size, counts, flaws and repairs, or a scene's objects");
  info.add_option("file", options->file, "Mesh (.obj, .stl, .ply, .gltf, .glb) or scene (.toml)").required();
  info.add_option("--unit", options->unit, "Unit of the file: m (default), cm, mm or in; glTF is always m").one_of_names(kUnitNames);
  info.add_flag("--json", options->json, "Print JSON");
  info.on_run([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace hapton
