#include "tools/method_flags.h"

#include "core/collision/grid_division.h"
#include "scene/unit.h"

namespace hapton {

void add_method_flags(CommandLine command, MethodFlags& flags) {
  MethodSettings& method = flags.settings;
  command.add_option("--method", method.name, "Force method, one of: " + method_names()).one_of_names(method_names()).shows_default();
  command.add_option("--probe-radius", method.probe_radius_m, "Radius of the probe, metres; 0: a point (sweep and smooth have only points)")
      .not_negative("metres")
      .shows_default();
  command
      .add_option("--coupling", method.coupling_n_per_m,
                  "Virtual coupling, N/m: a spring between device and probe, so that no material is stiffer (effects may be); 0: none "
                  "(hapton loop recommend)")
      .between(0.0, 1e6)
      .shows_default();
  command.add_option("--shading", method.shading, "proxy: force direction from face normals (0) to smooth normals (1)")
      .between(0.0, 1.0)
      .shows_default();
  command
      .add_option("--crease", method.crease_deg,
                  "smooth, proxy with shading: edges at which the surface turns by more degrees than this are sharp")
      .between(0.0, 180.0)
      .shows_default();
  command
      .add_option("--simplify", flags.simplify,
                  "smooth: simplify the mesh within this distance of its surface, such as 0.1mm; 0: do not simplify")
      .shows_default();
  command.add_option("--set-size", method.set_size, "smooth: triangles in the local set, 16 to 256").shows_default();
  command
      .add_option("--radius", method.smooth_radius_m,
                  "smooth: RADIUS, the distance within which a triangle exerts force, metres; 0: derived from the mesh")
      .shows_default();
  command
      .add_option("--layer", method.smooth_layer,
                  "smooth: share of RADIUS over which force builds up outside the surface, 0 to 1; 1: Algorithm 1 of the FDH paper")
      .shows_default();
  command.add_option("--directions", method.hull_directions, "smooth: directions of its bounding hulls: 6, 14, 18 or 26").shows_default();
  command.add_option("--grid", flags.grid, "sweep: cells along each axis, N or NxNxN").shows_default();
  command.add_option("--offset-in", flags.offset_in, "sweep: length of the offset vector, inches").positive("inches").shows_default();
}

Result<MethodSettings> settings_of(const MethodFlags& flags) {
  const auto division = parse_grid_division(flags.grid);
  if (!division) return tl::unexpected(division.error());
  const auto bound = parse_length(flags.simplify);
  if (!bound) return fail("--simplify: {}", bound.error().what);
  MethodSettings settings = flags.settings;
  settings.grid_division = *division;
  settings.simplify_m = *bound;
  settings.offset_m = flags.offset_in * metres_per(Unit::in);
  return settings;
}

}  // namespace hapton
