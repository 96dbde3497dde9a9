#include <cstdio>
#include <memory>

#include "tools/commands.h"
#include "tools/sculpt/sculpt_export.h"

namespace hapton {

void add_sculpt_command(CommandLine app, int& exit_code) {
  auto options = std::make_shared<SculptExport>();
  const CommandLine sculpt = app.add_subcommand("sculpt", "Write the surface of what the stylus has carved as a mesh");
  sculpt.add_option("scene", options->scene, "Scene (.toml) with an object that can be carved").required();
  sculpt.add_option("--annotations", options->annotations, "File (.toml) that vision_node --annotations wrote").required();
  sculpt.add_option("--out", options->out, "Mesh to write: FILE.stl, FILE.obj or FILE.ply").file_to_write().required();
  sculpt.add_option("--object", options->object, "Name of the object; default: all that can be carved, in one mesh");
  sculpt.on_run([options, &exit_code] {
    const auto written = export_carved(*options);
    if (!written) {
      std::fprintf(stderr, "hapton sculpt: %s\n", written.error().what.c_str());
      exit_code = 2;
      return;
    }
    std::fputs(written->c_str(), stdout);
    exit_code = 0;
  });
}

}  // namespace hapton
